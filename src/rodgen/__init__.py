"""rodgen: equations of motion of planar flexible rods, derived, proven, generated, integrated.

    scene = rodgen.Scene.from_toml("scenes/missile.toml")
    model = rodgen.build(scene)
    sol = rodgen.simulate(scene, method="dop853", rtol=1e-8)

Everything is imported when it is first used: a plain ``import rodgen`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rodgen.analyse.critical import Critical, critical_force
    from rodgen.analyse.errors import AnalysisError, MeshWarning
    from rodgen.analyse.extrapolate import Extrapolation, richardson
    from rodgen.analyse.fourier import spectrum
    from rodgen.analyse.growth import SimulatedCritical, simulated_critical_force
    from rodgen.analyse.modes import Modes, natural_modes
    from rodgen.analyse.statics import Equilibrium, static_equilibrium
    from rodgen.analyse.tones import Spectrum
    from rodgen.integrate import (
        Event,
        Interrupted,
        RunError,
        Solution,
        StepWarning,
        choose,
        resume,
        simulate,
    )
    from rodgen.integrate.files.storage import load
    from rodgen.integrate.files.stored import FileWarning
    from rodgen.loading import BuildError, build
    from rodgen.scene import Scene, SceneError, Structure

_HOMES = {
    "Scene": "rodgen.scene",
    "SceneError": "rodgen.scene",
    "Structure": "rodgen.scene",
    "build": "rodgen.loading.build",
    "BuildError": "rodgen.loading.module",
    "simulate": "rodgen.integrate.simulate",
    "resume": "rodgen.integrate.simulate",
    "choose": "rodgen.integrate.methods.choose",
    "Solution": "rodgen.integrate.solution",
    "Event": "rodgen.integrate.solution",
    "RunError": "rodgen.integrate.outcome",
    "Interrupted": "rodgen.integrate.outcome",
    "StepWarning": "rodgen.integrate.outcome",
    "load": "rodgen.integrate.files.storage",
    "FileWarning": "rodgen.integrate.files.stored",
    "natural_modes": "rodgen.analyse.modes",
    "Modes": "rodgen.analyse.modes",
    "static_equilibrium": "rodgen.analyse.statics",
    "Equilibrium": "rodgen.analyse.statics",
    "critical_force": "rodgen.analyse.critical",
    "Critical": "rodgen.analyse.critical",
    "simulated_critical_force": "rodgen.analyse.growth",
    "SimulatedCritical": "rodgen.analyse.growth",
    "spectrum": "rodgen.analyse.fourier",
    "Spectrum": "rodgen.analyse.tones",
    "richardson": "rodgen.analyse.extrapolate",
    "Extrapolation": "rodgen.analyse.extrapolate",
    "AnalysisError": "rodgen.analyse.errors",
    "MeshWarning": "rodgen.analyse.errors",
}

__all__ = [
    "AnalysisError",
    "BuildError",
    "Critical",
    "Equilibrium",
    "Event",
    "Extrapolation",
    "FileWarning",
    "Interrupted",
    "MeshWarning",
    "Modes",
    "RunError",
    "Scene",
    "SceneError",
    "SimulatedCritical",
    "Solution",
    "Spectrum",
    "StepWarning",
    "Structure",
    "build",
    "choose",
    "critical_force",
    "load",
    "natural_modes",
    "resume",
    "richardson",
    "simulate",
    "simulated_critical_force",
    "spectrum",
    "static_equilibrium",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("rodgen")
    if name not in _HOMES:
        raise AttributeError(f"module 'rodgen' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
