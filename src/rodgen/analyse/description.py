"""Description of a scene before it is run: the terms of its module, and its method."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from rodgen.analyse.analysis_guard import SHOW, check_analysis_memory, guard_analysis
from rodgen.arrays import Array
from rodgen.integrate.contact_press import all_presses
from rodgen.integrate.diagnosis import drift_doubt
from rodgen.integrate.methods.method_choice import Choice, choose, describe_motion, fastest_motion
from rodgen.integrate.quantity_formulas import MotionSlice as Sample
from rodgen.integrate.stability import dominant, step_limit
from rodgen.model.methods import FIXED_STEP
from rodgen.progress import report_stage
from rodgen.result import Note, Result, Row, doubt, omit_from_tables, remarks
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_notes
from rodgen.scene.model_contents import ModelPart, model_parts
from rodgen.system import System
from rodgen.system.link_inertia import missing_mass

MOST_LISTED = 10  # break points
TABLED = re.compile(r"(_(?:knot|value))_\d+$")  # names of the numbers of a table


@dataclass(frozen=True, repr=False)
class Description(Result):
    """Description of a scene before it is run.

    pieces: terms that a module can have, whether this one has them, and why; choice: the method,
    and why, None of a rod that lacks a mass for a run; centre_of_gravity: at the start (2,) [m];
    fastest_motion: at the start, in words, None where its rate is not finite; largest_stable_steps:
    of methods of equal steps, for that motion [s]; notes: doubts about numbers of the scene and the
    method, and what to know about the links; system: what is described.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.describe(rodgen.Scene.example("ziegler"))
    >>> found.links, [piece.piece for piece in found.pieces if piece.present][:1]
    (3, ['2 moving links'])
    """

    pieces: tuple[ModelPart, ...]
    choice: Choice | None
    centre_of_gravity: Array
    fastest_motion: str | None
    largest_stable_steps: dict[str, float]
    notes: tuple[Note, ...] = ()
    system: System = field(kw_only=True)

    ROWS = (
        Row("name", "scene"),
        Row("module", "module", of=lambda found: found.system.structure.stem),
        Row("structure", "structure", of=lambda found: found.system.structure.hash),
        Row("links", "links", text=omit_from_tables),
        Row("states", "values of the state", of=lambda found: len(found.system.y0)),
        Row(
            "parameters",
            "parameters",
            of=lambda found: dict(found._parameters()),
            text=lambda found: ", ".join(_group_table_entries(found.system.structure.parameters)),
        ),
        Row("mass", "mass at the start", "kg", ".9g"),
        Row(
            "centre_of_gravity",
            "centre of gravity at the start",
            "m",
            text=lambda found: found._centre,
        ),
        Row("method", "integrated by", of=lambda found: found.choice and found.choice.method),
        Row("reason", "because", of=lambda found: found.choice and found.choice.reason),
        Row("fastest_motion", "fastest motion at the start"),
        Row("largest_stable_steps", "largest stable step of {}", "s", ".3g"),
        Row("span", "span", "s", "g", of=lambda found: found.system.settings.span),
        Row(
            "breaks",
            "break points",
            "s",
            of=lambda found: found.system.scene.breaks(),
            text=lambda found: _format_times(found.system.scene.breaks()),
        ),
        Row(
            "events",
            "events",
            of=lambda found: [one.model_dump() for one in found.system.events],
            text=lambda found: found._events,
        ),
        Row("pieces", "piece", along="piece", of=lambda found: [one.piece for one in found]),
        Row("present", "in the module", along="piece", of=lambda found: [o.present for o in found]),
        Row("because", "because", along="piece", of=lambda found: [one.reason for one in found]),
    )

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self.system.name

    @property
    def links(self) -> int:
        """Number of links."""
        return self.system.structure.n_links

    @cached_property
    def mass(self) -> float:
        """Mass at the start [kg]."""
        return self.system.scene.mass

    @property
    def _centre(self) -> str:
        x, y = self.centre_of_gravity.round(12) + 0.0  # without -0
        return f"({x:.9g}, {y:.9g}) m"

    @property
    def _events(self) -> str | None:
        said = [f"{e.name!r}: {e.quantity} {e.direction}, {e.action}" for e in self.system.events]
        return "; ".join(said) or None

    def _parameters(self) -> Iterator[tuple[str, Any]]:
        """Parameters of the module; of a table the number of its rows."""
        rows = dict(self.system.structure.tables)
        for name, value in self.system.scene.parameters.items():
            yield name, {"rows": rows[name]} if name in rows else value

    def __iter__(self) -> Iterator[ModelPart]:
        return iter(self.pieces)

    def __repr__(self) -> str:
        run = f"by {self.choice.method}" if self.choice else "not to be run"
        return f"<Description of {self.name}: {self.links} links, {run}>"


@guard_analysis
def describe(system: System | Scene) -> Description:
    """Describe a scene before it is run: the terms of its module, with reasons, and its method.

    Parameters
    ----------
    system
        The scene, or a System.

    Returns
    -------
    Description
        Pieces, parameters, mass, the method and the fastest motion [rad/s], and doubts.

    Raises
    ------
    InputError
        For so many links that there is not enough memory.

    Examples
    --------
    >>> import rodgen
    >>> rodgen.describe(rodgen.Scene.example("missile")).choice.method
    'dop853'
    """
    system = System.of(system)
    check_analysis_memory(SHOW, system)
    scene, lacking = system.scene, missing_mass(system)
    choice, words, limits = None, None, dict[str, float]()
    if lacking is None:
        model = system.model()
        choice = choose(system, model)
        report_stage("looking for the fastest motion")
        with suppress(ArithmeticError):  # the run will say so
            fastest = fastest_motion(system, model)
            limits = {name: step_limit(name, fastest.value, fastest.partner) for name in FIXED_STEP}
            words = describe_motion(fastest)
            begin = system.settings.span[0], system.y0
            for near in all_presses(model, *begin, system.p):
                touching = dominant(model, *begin, near)
                limits = {
                    name: min(step, step_limit(name, touching.value, touching.partner))
                    for name, step in limits.items()
                }
    else:
        model = system.model("numpy", parts=("kinetics",))
    unfit = () if lacking is None else (doubt(f"no run: {lacking}"),)
    start = Sample(model, system.p, system.y0, np.array(system.settings.span[0]))
    drifts = drift_doubt(system)
    return Description(
        pieces=tuple(model_parts(scene)),
        choice=choice,
        centre_of_gravity=np.asarray(start.values("centre_of_gravity")),
        fastest_motion=words,
        largest_stable_steps=limits,
        notes=(
            *unfit,
            *system.doubts,
            *([] if drifts is None else [drifts]),
            *remarks(mesh_notes(scene)),
        ),
        system=system,
    )


def _group_table_entries(names: Iterable[str]) -> Iterator[str]:
    """Yield names of parameters, with one name for all numbers of a table."""
    for stem, group in groupby(names, lambda name: TABLED.sub(r"\1", name)):
        found = [*group]
        yield found[0] if len(found) == 1 else f"{stem}_1 to {len(found)}"


def _format_times(times: list[float]) -> str:
    """Format the first times of a list, and their number."""
    first = ", ".join(f"{t:g}" for t in times[:MOST_LISTED]) or "none"
    unit, rest = " s" * bool(times), f" ... ({len(times)} in all)"
    return first + unit + rest * (len(times) > MOST_LISTED)
