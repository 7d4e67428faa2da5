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
from rodgen.judge.precision.references import Reference
from rodgen.judge.unit import Row, Unit

MISSING = "not installed: pip install rodgen[bench]"


def rodgens(name: str, table: dict[str, Any], folder: str, quick: bool) -> list[Row]:
    """All of rodgen's own methods on a scene."""
    job, held, measures = prepared(name, table, folder)
    rows: list[Row] = []
    for family in ours.families(job, quick, held.setup):
        rows += sweep(family.make(), label(job, family), measures, Limits.of(quick))
    return rows


def peers(
    name: str, table: dict[str, Any], folder: str, quick: bool, names: list[str]
) -> list[Row]:
    """Methods of a peer on a scene, by their names in rodgen.judge.peers.FAMILIES."""
    job, _, measures = prepared(name, table, folder)
    return [row for one in names for row in _of_peer(job, measures, quick, one)]


def _of_peer(job: Job, measures: Measures, quick: bool, name: str) -> list[Row]:
    from rodgen.judge.peers import family

    known: Row = {"scene": job.name, "n": job.scene.rod.links, "family": name}
    nothing: Row = known | {"who": name.split()[0], "method": name.partition(" ")[2], "target": ""}
    try:
        return in_a_row(family(name, job, quick), nothing, measures, Limits.of(quick))
    except ImportError:
        return [blank(nothing) | {"failed": MISSING}]
    except Exception as error:  # another's library may fail in any way
        return [blank(nothing) | {"failed": words(error)}]


def prepared(name: str, table: dict[str, Any], folder: str) -> tuple[Job, Reference, Measures]:
    """A job with its reference solution."""
    job = Job.of(name, table)
    held = Reference.load(folder, name)
    return job, held, Measures(job, held.states)


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
        planned.append(Unit("precision", f"{name}-rodgen", f"{__name__}:rodgens", known))
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
