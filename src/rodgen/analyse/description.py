"""What the module of a scene will hold, what is left out and why, and by which method it is run."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np

from rodgen.analyse.guard import guarded
from rodgen.analyse.sizes import SHOW, check_size
from rodgen.arrays import Array
from rodgen.integrate.catalogue import Piece as Sample
from rodgen.integrate.diagnosis import drift_doubt
from rodgen.integrate.methods.choose import Choice, choose, described, fastest_motion
from rodgen.integrate.stability import limit
from rodgen.model.methods import FIXED_STEP
from rodgen.progress import tell
from rodgen.result import Note, Result, Row, hidden, remarks
from rodgen.scene import Scene
from rodgen.scene.contents import Piece, contents
from rodgen.scene.mesh import mesh_notes
from rodgen.system import System

MOST_LISTED = 10  # break points
TABLED = re.compile(r"(_(?:knot|value))_\d+$")  # how the numbers of a table are called


@dataclass(frozen=True, repr=False)
class Description(Result):
    """What there is to know about a scene before it is run.

    pieces: terms that a module can have, whether this one has them, and why; choice: the method,
    and why; centre_of_gravity: at the start (2,) [m]; fastest_motion: at the start, in words, None
    where its rate is not finite; largest_stable_steps: of methods of equal steps, for that motion
    [s]; notes: doubts about numbers of the scene and the method, and what to know about the links;
    system: what is described.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.describe(rodgen.Scene.example("ziegler"))
    >>> found.links, [piece.piece for piece in found.pieces if piece.present][:1]
    (2, ['2 moving links'])
    """

    pieces: tuple[Piece, ...]
    choice: Choice
    centre_of_gravity: Array
    fastest_motion: str | None
    largest_stable_steps: dict[str, float]
    notes: tuple[Note, ...] = ()
    system: System = field(kw_only=True)

    ROWS = (
        Row("name", "scene"),
        Row("module", "module", of=lambda found: found.system.structure.stem),
        Row("structure", "structure", of=lambda found: found.system.structure.hash),
        Row("links", "links", text=hidden),
        Row("states", "values of the state", of=lambda found: len(found.system.y0)),
        Row(
            "parameters",
            "parameters",
            of=lambda found: dict(found._parameters()),
            text=lambda found: ", ".join(_in_tables(found.system.structure.parameters)),
        ),
        Row("mass", "mass at the start", "kg", ".9g"),
        Row(
            "centre_of_gravity",
            "centre of gravity at the start",
            "m",
            text=lambda found: found._centre,
        ),
        Row("method", "integrated by", of=lambda found: found.choice.method),
        Row("reason", "because", of=lambda found: found.choice.reason),
        Row("fastest_motion", "fastest motion at the start"),
        Row("largest_stable_steps", "largest stable step of {}", "s", ".3g"),
        Row("span", "span", "s", "g", of=lambda found: found.system.settings.span),
        Row(
            "breaks",
            "break points",
            "s",
            of=lambda found: found.system.scene.breaks(),
            text=lambda found: _listed(found.system.scene.breaks()),
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
        return self.system.structure.links

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
        """Parameters of the module, of tables how many rows these have."""
        rows = dict(self.system.structure.tables)
        for name, value in self.system.scene.parameters.items():
            yield name, {"rows": rows[name]} if name in rows else value

    def __iter__(self) -> Iterator[Piece]:
        return iter(self.pieces)

    def __repr__(self) -> str:
        return f"<Description of {self.name}: {self.links} links, by {self.choice.method}>"


@guarded
def describe(system: System | Scene) -> Description:
    """Return what the module of a scene will hold, what is left out and why, and how it is run.

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
    check_size(SHOW, system)
    scene, model = system.scene, system.model()
    choice = choose(system, model)
    tell("looking for the fastest motion")
    words, limits = None, dict[str, float]()
    with suppress(ArithmeticError):  # the run will say so
        fastest = fastest_motion(system, model)
        limits = {name: limit(name, fastest.value, fastest.partner) for name in FIXED_STEP}
        words = described(fastest)
    start = Sample(model, system.p, system.y0, np.array(system.settings.span[0]))
    drifts = drift_doubt(system)
    return Description(
        pieces=tuple(contents(scene)),
        choice=choice,
        centre_of_gravity=np.asarray(start.values("centre_of_gravity")),
        fastest_motion=words,
        largest_stable_steps=limits,
        notes=(
            *system.doubts,
            *([] if drifts is None else [drifts]),
            *remarks(mesh_notes(scene)),
        ),
        system=system,
    )


def _in_tables(names: Iterable[str]) -> Iterator[str]:
    """Names of parameters, those of the numbers of a table as one."""
    for stem, group in groupby(names, lambda name: TABLED.sub(r"\1", name)):
        found = [*group]
        yield found[0] if len(found) == 1 else f"{stem}_1 to {len(found)}"


def _listed(times: list[float]) -> str:
    """The first of them, and how many there are."""
    first = ", ".join(f"{t:g}" for t in times[:MOST_LISTED]) or "none"
    unit, rest = " s" * bool(times), f" ... ({len(times)} in all)"
    return first + unit + rest * (len(times) > MOST_LISTED)
