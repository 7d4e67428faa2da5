"""All sections of a report, in the order in which one needs another."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from pathlib import Path

from rodgen_evidence.report.cases import Case
from rodgen_evidence.report.runner import Runner
from rodgen_evidence.report.surroundings import fingerprint
from rodgen_evidence.report.unit import Measured, Unit

# Sections by the module that plans them; those of a scene are measured for scenes of a user too.
OF_SCENES = {
    "references": "precision.references",
    "precision": "precision.contests",
    "growth": "precision.growth",
    "equal_error": "precision.duels",
    "leaving_out": "costs.leaving_out",
}
OF_RODGEN = {
    "costs": "costs.against_n",
    "install": "costs.install",
    "steps": "stability.steps",
    "extremes": "stability.extremes",
    "rounding": "stability.rounding",
}
SECTIONS = {**OF_SCENES, **OF_RODGEN}
# What another section is made from.
AFTER = {"precision": ("references",), "growth": ("references",), "equal_error": ("precision",)}
MEASURED, REFERENCES = "measured", "references"

Contents = dict[str, list[Measured]]
Planner = Callable[..., list[Unit]]


def required_sections(chosen: Iterable[str]) -> list[str]:
    """List the sections chosen and those that they need, in the order of the report."""
    found = set(chosen)
    for name in reversed(SECTIONS):
        if name in found:
            found.update(AFTER.get(name, ()))
    return [name for name in SECTIONS if name in found]


def measure(
    cases: Sequence[Case],
    folder: Path,
    chosen: Iterable[str] = tuple(SECTIONS),
    *,
    quick: bool = False,
    resume: bool = False,
    done: Callable[[Measured], None] = lambda _: None,
) -> Contents:
    """Results of all units, by section.

    folder: where measurements and reference solutions are kept, and taken from on resume, those of
    other sections as well; done: told every result.
    """
    runner = Runner(folder / MEASURED, fingerprint(), resume, done)
    names = required_sections(chosen)
    found: Contents = {}
    for depth in range(1 + max(map(_depth, SECTIONS))):
        looked_at = SECTIONS if resume else names
        wave = [name for name in looked_at if _depth(name) == depth]
        units = {name: _units(name, cases, folder, quick, found) for name in wave}
        asked = [unit for name in wave if name in names for unit in units[name]]
        for unit, one in zip(asked, runner.run(asked), strict=True):
            found.setdefault(unit.section, []).append(one)
        for name in wave:
            if name not in names and (held := runner.held(units[name])):
                found[name] = held
    return {name: found.get(name, []) for name in SECTIONS if name in names or name in found}


def _depth(section: str) -> int:
    """Number of sections that have to be measured before one, one after the other."""
    return max((1 + _depth(name) for name in AFTER.get(section, ())), default=0)


def _units(
    section: str, cases: Sequence[Case], folder: Path, quick: bool, found: Contents
) -> list[Unit]:
    """The units of a section."""
    plan: Planner = import_module(f"rodgen_evidence.report.{SECTIONS[section]}").units
    rows = [row for one in found.get("precision", []) for row in one.rows]
    return plan(cases, quick, folder / REFERENCES, rows)
