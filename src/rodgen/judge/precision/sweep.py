"""Units of the work-precision sets: rodgen's methods and everyone else's on every scene."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rodgen.judge.cases import Case
from rodgen.judge.precision import ours
from rodgen.judge.precision.errors import Measures
from rodgen.judge.precision.job import Job
from rodgen.judge.precision.measured import Limits, blank, in_a_row, sweep, words
from rodgen.judge.precision.ours import Named
from rodgen.judge.precision.references import NO_REFERENCE, NoReferenceError, Reference
from rodgen.judge.precision.setup import setups
from rodgen.judge.unit import Row, Unit

LIMIT = 180.0  # seconds of all of rodgen's methods, with their set-up
MISSING = 'not installed: pip install "rodgen[bench]"'


def rodgens(name: str, table: dict[str, Any], folder: str, quick: bool) -> list[Row]:
    """All of rodgen's own methods on a scene."""
    try:
        job, _, measures = prepared(name, table, folder)
    except NoReferenceError as error:
        return [without(name, table, "rodgen", error)]
    rows: list[Row] = []
    taken = (
        {} if quick else setups(table)
    )  # from cold they take longer than all runs of a short set
    for family in ours.families(job, quick, taken):
        rows += sweep(family.make(), label(job, family), measures, Limits.of(quick))
    return rows


def peers(
    name: str, table: dict[str, Any], folder: str, quick: bool, names: list[str]
) -> list[Row]:
    """Methods of a peer on a scene, by their names in rodgen.judge.peers.FAMILIES."""
    try:
        job, _, measures = prepared(name, table, folder)
    except NoReferenceError as error:
        return [without(name, table, names[0].split()[0], error)]
    return [row for one in names for row in _of_peer(job, measures, quick, one)]


def _of_peer(job: Job, measures: Measures, quick: bool, name: str) -> list[Row]:
    from rodgen.judge.peers import PACKAGES, family

    known: Row = {"scene": job.name, "n": job.scene.rod.links, "family": name}
    nothing: Row = known | {"who": name.split()[0], "method": name.partition(" ")[2], "target": ""}
    try:
        return in_a_row(family(name, job, quick), nothing, measures, Limits.of(quick))
    except ModuleNotFoundError as error:
        own = error.name == PACKAGES[name.split()[0]]
        return [blank(nothing) | {"failed": MISSING if own else words(error)}]
    except Exception as error:  # another's library may fail in any way
        return [blank(nothing) | {"failed": words(error)}]


def prepared(name: str, table: dict[str, Any], folder: str) -> tuple[Job, Reference, Measures]:
    """A job with its reference solution. Raises NoReferenceError."""
    job = Job.of(name, table)
    held = Reference.load(folder, name, table)
    return job, held, Measures(job, held.states)


def without(name: str, table: dict[str, Any], who: str, why: NoReferenceError) -> Row:
    """The row of a scene that has no reference solution."""
    known: Row = {"scene": name, "n": table["rod"]["links"], "family": "", "who": who}
    known |= {"method": "", "target": ""}
    return blank(known) | {"failed": words(f"{NO_REFERENCE}{why}")}


def label(job: Job, family: Named) -> Row:
    """What all rows of a family of ours have in common."""
    known: Row = {"scene": job.name, "n": job.scene.rod.links, "family": "", "who": family.who}
    known |= {"method": family.method, "target": family.target}
    return known | {f"setup_{kind}": seconds for kind, seconds in family.setup.items()}


def units(cases: Sequence[Case], quick: bool, folder: str | Path) -> list[Unit]:
    """Of every scene, one for rodgen's methods and one for every peer's."""
    planned: list[Unit] = []
    for case in cases:
        known = {"name": case.name, "table": case.scene, "folder": str(folder), "quick": quick}
        name = f"precision-{case.name}"
        mine = Unit("precision", f"{name}-rodgen", f"{__name__}:rodgens", known, limit=LIMIT)
        planned.append(mine)
        for peer, names in by_library().items():
            arguments = known | {"names": names}
            planned.append(Unit("precision", f"{name}-{peer}", f"{__name__}:peers", arguments))
    return planned


def by_library() -> dict[str, list[str]]:
    """Names of the peers' methods by the first word of them: what crashes ends its own alone."""
    from rodgen.judge.peers import FAMILIES

    found: dict[str, list[str]] = {}
    for name in FAMILIES:
        found.setdefault(re.sub(r"[^A-Za-z0-9]", "-", name.split()[0]), []).append(name)
    return found
