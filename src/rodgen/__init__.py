"""rodgen: equations of motion of planar flexible rods, derived, proven, generated, integrated.

    scene = rodgen.Scene.from_toml("scenes/missile.toml")
    model = rodgen.build(scene)
    sol = rodgen.simulate(scene, method="dop853", rtol=1e-8)

Everything is imported when it is first used: a plain ``import rodgen`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rodgen.analyse.branches.boundary import stability_boundary
    from rodgen.analyse.branches.coexistence import static_equilibria
    from rodgen.analyse.branches.equilibrium_branch import continue_equilibria
    from rodgen.analyse.chaos.exponents import Exponents, lyapunov_exponents
    from rodgen.analyse.chaos.zero_one import zero_one_test
    from rodgen.analyse.critical import Critical, critical_force
    from rodgen.analyse.cycles.branches import continue_cycles
    from rodgen.analyse.cycles.cycle import Cycle, find_cycle
    from rodgen.analyse.cycles.floquet import Floquet, floquet
    from rodgen.analyse.cycles.nonlinear_modes import continue_mode, nonlinear_mode
    from rodgen.analyse.errors import AnalysisError, MeshWarning
    from rodgen.analyse.extrapolate import Extrapolation, richardson
    from rodgen.analyse.fourier import Spectrum, spectrum
    from rodgen.analyse.growth import SimulatedCritical, simulated_critical_force
    from rodgen.analyse.modes import Modes, natural_modes
    from rodgen.analyse.precision.work_precision import WorkPrecision, work_precision
    from rodgen.analyse.statics import Equilibrium, static_equilibrium
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
    from rodgen.integrate.ensemble import Ensemble
    from rodgen.integrate.files.result_file import FileWarning
    from rodgen.integrate.files.storage import load
    from rodgen.integrate.many import simulate_many
    from rodgen.loading import BuildError, build
    from rodgen.scene import Scene, SceneError, Structure
    from rodgen.studies.engine import study
    from rodgen.studies.errors import StudyError
    from rodgen.studies.specification import Study

_HOMES = {
    "Scene": "rodgen.scene",
    "SceneError": "rodgen.scene",
    "Structure": "rodgen.scene",
    "build": "rodgen.loading.build",
    "BuildError": "rodgen.native.library",
    "simulate": "rodgen.integrate.simulate",
    "simulate_many": "rodgen.integrate.many",
    "resume": "rodgen.integrate.simulate",
    "choose": "rodgen.integrate.methods.choose",
    "Ensemble": "rodgen.integrate.ensemble",
    "Solution": "rodgen.integrate.solution",
    "Event": "rodgen.integrate.solution",
    "RunError": "rodgen.integrate.endings",
    "Interrupted": "rodgen.integrate.endings",
    "StepWarning": "rodgen.integrate.endings",
    "load": "rodgen.integrate.files.storage",
    "FileWarning": "rodgen.integrate.files.result_file",
    "natural_modes": "rodgen.analyse.modes",
    "Modes": "rodgen.analyse.modes",
    "static_equilibrium": "rodgen.analyse.statics",
    "Equilibrium": "rodgen.analyse.statics",
    "continue_equilibria": "rodgen.analyse.branches.equilibrium_branch",
    "static_equilibria": "rodgen.analyse.branches.coexistence",
    "stability_boundary": "rodgen.analyse.branches.boundary",
    "critical_force": "rodgen.analyse.critical",
    "Critical": "rodgen.analyse.critical",
    "continue_cycles": "rodgen.analyse.cycles.branches",
    "continue_mode": "rodgen.analyse.cycles.nonlinear_modes",
    "nonlinear_mode": "rodgen.analyse.cycles.nonlinear_modes",
    "find_cycle": "rodgen.analyse.cycles.cycle",
    "Cycle": "rodgen.analyse.cycles.cycle",
    "simulated_critical_force": "rodgen.analyse.growth",
    "SimulatedCritical": "rodgen.analyse.growth",
    "lyapunov_exponents": "rodgen.analyse.chaos.exponents",
    "Exponents": "rodgen.analyse.chaos.exponents",
    "zero_one_test": "rodgen.analyse.chaos.zero_one",
    "floquet": "rodgen.analyse.cycles.floquet",
    "Floquet": "rodgen.analyse.cycles.floquet",
    "spectrum": "rodgen.analyse.fourier",
    "Spectrum": "rodgen.analyse.fourier",
    "richardson": "rodgen.analyse.extrapolate",
    "Extrapolation": "rodgen.analyse.extrapolate",
    "work_precision": "rodgen.analyse.precision.work_precision",
    "WorkPrecision": "rodgen.analyse.precision.work_precision",
    "study": "rodgen.studies.engine",
    "Study": "rodgen.studies.specification",
    "StudyError": "rodgen.studies.errors",
    "AnalysisError": "rodgen.analyse.errors",
    "MeshWarning": "rodgen.analyse.errors",
}

__all__ = [
    "AnalysisError",
    "BuildError",
    "Critical",
    "Cycle",
    "Ensemble",
    "Equilibrium",
    "Event",
    "Exponents",
    "Extrapolation",
    "FileWarning",
    "Floquet",
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
    "Study",
    "StudyError",
    "WorkPrecision",
    "build",
    "choose",
    "continue_cycles",
    "continue_equilibria",
    "continue_mode",
    "critical_force",
    "find_cycle",
    "floquet",
    "load",
    "lyapunov_exponents",
    "natural_modes",
    "nonlinear_mode",
    "resume",
    "richardson",
    "simulate",
    "simulate_many",
    "simulated_critical_force",
    "spectrum",
    "stability_boundary",
    "static_equilibria",
    "static_equilibrium",
    "study",
    "work_precision",
    "zero_one_test",
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
