"""Other libraries that users may take, each on its own natural formulation of the scene."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple

from rodgen.analyse.precision import method_families
from rodgen.analyse.precision.contestant import Contestant
from rodgen.analyse.precision.job import Job
from rodgen_evidence.report.peers.peer import Peer, Prepared


class Library(NamedTuple):
    """A library that users would take instead of rodgen.

    package: what is imported for it; module: which has its Peer for its methods, and a function
    prepare(links) for the rates of the rod of the costs; peer: name of the Peer.
    """

    package: str
    module: str
    peer: str = ""
    methods: tuple[str, ...] = ()
    rates: str = ""


LIBRARIES = {
    "SciPy": Library("scipy", "", "", ("DOP853", "RK45", "Radau", "BDF", "LSODA")),
    "CVODE": Library("sksundae", "cvode", "CvodeRod", ("Adams", "BDF")),
    "heyoka": Library("heyoka", "heyoka_rod", "HeyokaRod", ("Taylor",)),
    "MuJoCo": Library(
        "mujoco", "mujoco_rod", "MujocoRod", ("Euler", "implicitfast", "RK4"), "mj_forward"
    ),
    "Exudyn": Library("exudyn", "exudyn_rod", "ExudynRod", ("generalized-alpha", "RK44")),
    "CasADi": Library(
        *("casadi", "casadi_rod", "CasadiRod"),
        ("CVODES BDF", "CVODES Adams", "IDAS", "collocation"),
        "generated C",
    ),
    "Numba": Library("numba", "numba_rod", rates="by hand"),
    "Pinocchio": Library("pinocchio", "pinocchio_rod", rates="aba"),
    "PyDy": Library("pydy", "pydy_rod", rates="Kane to Cython"),
}
FAMILIES = [f"{who} {method}" for who, one in LIBRARIES.items() for method in one.methods]
RATES = [f"{who}, {one.rates}" for who, one in LIBRARIES.items() if one.rates]


def family(name: str, job: Job, quick: bool = False) -> Iterator[Contestant]:
    """Settings of one of FAMILIES from loose to tight, or those of its short form.

    Raises ImportError where its library is not installed, NotModelledError where it cannot model
    the scene, ArithmeticError where its rates are not those of rodgen.
    """
    who, _, method = name.partition(" ")
    if who == "SciPy":
        settings: Iterator[Contestant] = getattr(method_families, method.lower())(job, quick)
        return settings
    peer: type[Peer] = getattr(_module(who), LIBRARIES[who].peer)
    return iter(peer.family(job, method, quick))


def prepare(name: str, links: int) -> Prepared:
    """One of RATES, for the free uniform rod under thrust.

    Raises ImportError where its library is not installed, NotModelledError for too many links.
    """
    prepared: Prepared = _module(name.partition(",")[0]).prepare(links)
    return prepared


def _module(who: str) -> Any:
    return import_module(f"{__name__}.{LIBRARIES[who].module}")
