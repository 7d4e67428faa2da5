"""Units of the work-precision sets: rodgen's methods and everyone else's on every scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rodgen.analyse.precision import method_families
from rodgen.analyse.precision.contestant import (
    Limits,
    Measurement,
    describe_error,
    empty_row,
    sweep,
    sweep_methods,
)
from rodgen.analyse.precision.job import Job
from rodgen.analyse.precision.work_precision import Reference
from rodgen.model.methods import ADAPTIVE, FIXED_STEP
from rodgen.scene import Scene
from rodgen_evidence.report import peers
from rodgen_evidence.report.cases import Case
from rodgen_evidence.report.costs.cold import setups
from rodgen_evidence.report.precision.references import NO_REFERENCE, NoReferenceError, load
from rodgen_evidence.report.unit import Unit

NUMPY = ("rk4", "dop853", "gauss", "radau")  # in Python: some of each kind
MOST_LINKS = 50  # up to which they are run in Python
LIMIT = 180.0  # seconds of all of rodgen's methods, with their set-up
MISSING = "not installed: make report installs it"


def own_methods(job: Job) -> list[tuple[str, str]]:
    """List rodgen's methods and their targets: all in C, and some in Python."""
    found = [(method, "c") for method in (*FIXED_STEP, *ADAPTIVE)]
    if job.scene.rod.links <= MOST_LINKS:
        found += [(method, "numpy") for method in NUMPY]
    return found


def _limits(quick: bool) -> Limits:
    """Limits of the short report or of the whole one."""
    return Limits(0.15, 0.35) if quick else Limits(0.6, 1.2)


def rodgens(name: str, table: dict[str, Any], folder: str, quick: bool) -> list[Measurement]:
    """All of rodgen's own methods on a scene."""
    try:
        job, held = load_job(name, table, folder)
    except NoReferenceError as error:
        return [without(name, table, "rodgen", error)]
    rows: list[Measurement] = []
    # From cold they take longer than all runs of a short set.
    taken = {} if quick else setups(table)
    for method, target in own_methods(job):
        family = method_families.own_family(job, method, target, quick)
        measures = held.measures(job, method)
        rows += sweep(family, label(job, method, target, taken), measures, _limits(quick))
    return rows


def of_peer(
    name: str, table: dict[str, Any], folder: str, quick: bool, names: list[str]
) -> list[Measurement]:
    """Methods of a peer on a scene, by their names in rodgen_evidence.report.peers.FAMILIES."""
    try:
        job, held = load_job(name, table, folder)
    except NoReferenceError as error:
        return [without(name, table, names[0].split()[0], error)]
    return [row for one in names for row in _of_method(job, held, quick, one)]


def _of_method(job: Job, held: Reference, quick: bool, name: str) -> list[Measurement]:
    who, _, method = name.partition(" ")
    nothing = known(job.name, job.scene.rod.links, who, name, method)
    try:
        measures = held.measures(job, method)
        return sweep_methods(peers.family(name, job, quick), nothing, measures, _limits(quick))
    except ModuleNotFoundError as error:
        own = error.name == peers.LIBRARIES[who].package
        return [empty_row(nothing) | {"failed": MISSING if own else describe_error(error)}]
    except Exception as error:  # another's library may fail in any way
        return [empty_row(nothing) | {"failed": describe_error(error)}]


def known(
    scene: str, links: int, who: str, family: str = "", method: str = "", target: str = ""
) -> Measurement:
    """Entries that all rows of a family have in common; family: of a peer's, its name."""
    start: Measurement = {"scene": scene, "n": links, "family": family}
    return start | {"who": who, "method": method, "target": target}


def load_job(name: str, table: dict[str, Any], folder: str) -> tuple[Job, Reference]:
    """Load a job with its reference solution. Raises NoReferenceError."""
    job = Job.of(name, Scene.from_dict(table))
    return job, load(folder, name, table)


def without(name: str, table: dict[str, Any], who: str, why: NoReferenceError) -> Measurement:
    """The row of a scene that has no reference solution."""
    row = empty_row(known(name, table["rod"]["links"], who))
    return row | {"failed": describe_error(f"{NO_REFERENCE}{why}")}


def label(job: Job, method: str, target: str, taken: dict[str, float]) -> Measurement:
    """Entries that all rows of a family of rodgen's have in common; taken: seconds of making both
    modules, by target and kind."""
    start = known(job.name, job.scene.rod.links, "rodgen", method=method, target=target)
    own = {k: v for k, v in taken.items() if k.startswith(f"{target}_")}
    return start | {f"setup_{k.removeprefix(f'{target}_')}": v for k, v in own.items()}


def units(cases: Sequence[Case], quick: bool, folder: str | Path, *_: object) -> list[Unit]:
    """Plan a unit for rodgen's methods and one for every peer's, of every scene."""
    planned: list[Unit] = []
    for case in cases:
        known = case.given(folder, quick=quick)
        name = f"precision-{case.name}"
        mine = Unit("precision", f"{name}-rodgen", f"{__name__}:rodgens", known, limit=LIMIT)
        planned.append(mine)
        for who, library in peers.LIBRARIES.items():
            if library.methods:  # what crashes ends those of its library alone
                arguments = known | {"names": [f"{who} {method}" for method in library.methods]}
                planned.append(Unit("precision", f"{name}-{who}", f"{__name__}:of_peer", arguments))
    return planned
