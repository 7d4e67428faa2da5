"""What a user would take instead, each on its own natural formulation of the scene.

Every function of FAMILIES makes the settings of one method from loose to tight for a Job, or for
its short form; it raises ImportError where its library is not installed, NotModelledError where it
cannot model the scene, ArithmeticError where its rates are not those of rodgen.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module

from rodgen.judge.precision.contestant import Contestant
from rodgen.judge.precision.job import Job

_HERE = "rodgen.judge.peers."

# Name -> module and function(job, quick).
FAMILIES: dict[str, tuple[str, str]] = {
    name: (_HERE + module, function)
    for name, module, function in (
        ("SciPy DOP853", "scipy_methods", "dop853"),
        ("SciPy RK45", "scipy_methods", "rk45"),
        ("SciPy Radau", "scipy_methods", "radau"),
        ("SciPy BDF", "scipy_methods", "bdf"),
        ("SciPy LSODA", "scipy_methods", "lsoda"),
        ("CVODE Adams", "sundials", "adams"),
        ("CVODE BDF", "sundials", "bdf"),
        ("heyoka Taylor", "taylor", "compact"),
        ("MuJoCo Euler", "mujoco_steps", "euler"),
        ("MuJoCo implicitfast", "mujoco_steps", "implicitfast"),
        ("MuJoCo RK4", "mujoco_steps", "rk4"),
        ("Exudyn generalized-alpha", "exudyn_tree", "generalized_alpha"),
        ("Exudyn RK44", "exudyn_tree", "rk44"),
        ("CasADi CVODES BDF", "casadi_integrators", "cvodes_bdf"),
        ("CasADi CVODES Adams", "casadi_integrators", "cvodes_adams"),
        ("CasADi IDAS", "casadi_integrators", "idas"),
        ("CasADi collocation", "casadi_integrators", "collocation"),
    )
}

# What is imported for them, by the first word of their names.
PACKAGES = {
    "SciPy": "scipy",
    "CVODE": "sksundae",
    "heyoka": "heyoka",
    "MuJoCo": "mujoco",
    "Exudyn": "exudyn",
    "CasADi": "casadi",
}


def family(name: str, job: Job, quick: bool = False) -> Iterator[Contestant]:
    """The settings of one of FAMILIES; what it needs is imported here."""
    module, function = FAMILIES[name]
    settings: Iterator[Contestant] = getattr(import_module(module), function)(job, quick)
    return settings
