"""The panel of values of a live run: which rows it has, and what stands in them at present."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from types import ModuleType
from typing import NamedTuple

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.stepper import Counts
from rodgen.live.catalogue import motion_of
from rodgen.live.samples import Chunk
from rodgen.model.parameter import JOINTS, Parameter, typeset
from rodgen.model.quantities import Index, Quantity, place
from rodgen.model.rod import CLAMP_ANGLE, MASS_PER_LENGTH, ROD
from rodgen.model.term import WEIGHT
from rodgen.model.terms import EMPTYING, PARAMETERS, PULL, TERMS
from rodgen.scene import Scene, spring
from rodgen.scene.integration import AUTO, Integrate

WIDTH = 12  # of -1.2345e-100
FIGURE_SPACE = "\u2007"  # as wide as a digit, and kept by HTML at the start of a line
THIN_SPACE = "\u202f"  # between thousands, where no line is broken
NOTHING = "–"
ANGLE = 3  # decimals of degrees
ROUNDING = 1e-12  # of the larger principal moment


def digits(value: float, count: int = 5) -> str:
    """So many significant digits."""
    text = f"{value:#.{count}g}" if math.isfinite(value) else str(value)
    return padded(text.removesuffix("."))


def fixed(value: float, decimals: int) -> str:
    """So many decimals; five significant digits of what is too large for them."""
    if not abs(value) < 10.0 ** (WIDTH - 3 - decimals):
        return digits(value)
    return padded(f"{round(value, decimals) + 0.0:.{decimals}f}")  # + 0.0: no negative zero


def whole(value: int) -> str:
    """A whole number, its thousands apart."""
    return padded(f"{value:,}".replace(",", THIN_SPACE))


def padded(text: str) -> str:
    """Right-justified."""
    return text.rjust(WIDTH, FIGURE_SPACE)


class Row(NamedTuple):
    """A row of the text panel: its key, what it is in words, its unit; without words it is a row of
    text alone, and not there while that is empty."""

    key: str
    label: str
    unit: str


@dataclass(frozen=True)
class Present:
    """chunk: its last sample is the present; counts and seconds: cost of the run so far, computing
    time [s]; ratio: simulated seconds in one second of late, None where it is not known; settings:
    in use, where they are not the scene's own; critical: critical follower force [N], or in words
    why there is none ("computing"), or None."""

    chunk: Chunk
    counts: Counts
    seconds: float
    ratio: float | None = None
    settings: Integrate | None = None
    critical: float | str | None = None


class Now:
    """What the rows show: the last sample of a run, and what follows from it."""

    def __init__(self, scene: Scene, model: ModuleType, present: Present):
        self.scene, self.model, self.present = scene, model, present
        self.settings = present.settings or scene.integrate
        self.motion = motion_of(model, present.chunk.last(), scene.timed)

    def value(self, name: str, at: Index = ()) -> float:
        """A number of a quantity at present."""
        return float(self.motion.values(name)[(0, *at)])

    def parameter(self, name: str) -> float:
        """A parameter of the module, or of a load that changes with time, at present."""
        follows = name in self.motion.timed or name in self.motion.values("signals")
        return self.value(name) if follows else float(self.motion.parameter(name))

    def along(self, name: str) -> Array:
        """A parameter of every joint or link."""
        return self.present.chunk.p[self.scene.structure.places[name]]

    @property
    def link_mass(self) -> Array:
        """Mass of every link with its bodies [kg]; of an even rod, one number."""
        if self.scene.structure.masses:
            present = self.scene.distribution_at(float(self.motion.t[-1]))
            return np.array(present.of_links()["link_mass"])
        place = self.scene.structure.places.get("link_mass")
        return np.array([self.share("mass")]) if place is None else self.present.chunk.p[place]

    def share(self, name: str) -> float:
        """What one link has of a parameter of the rod."""
        return self.parameter(name) / self.scene.rod.links

    @property
    def stiffness(self) -> Array:
        """Stiffness of the springs in all joints [N m/rad]: the moments that the generated module
        gives where every link is turned from the one before, the first from its clamp: by 1 rad,
        or next to nothing where springs have a law of their own."""
        hold, p = self.scene.hold, self.present.chunk.p
        clamp = self.parameter(CLAMP_ANGLE.name) if hold.clamped else 0.0
        turned, first = np.zeros((2, len(self.model.STATE))), 2 * hold.translates
        turn = 1.0 if self.scene.spring_law is None else spring.NEAR
        angles = np.arange(hold.first, self.model.N) + bool(hold.root)
        half = (turned.shape[1] - len(self.scene.states)) // 2
        turned[:, first:half] = clamp + turn * np.outer((-1, 1), angles)
        below, above = self.model.bending_moments(turned, p)
        stiffness: Array = (above - below) / (2 * turn)
        return stiffness


Entry = tuple[Row, Callable[[Now], str] | None]


def groups(scene: Scene) -> dict[str, list[Row]]:
    """The rows of the panel by the title of their group: those of loads, springs and settings that
    the scene has. They are fixed by its structure and the kind of its method."""
    made = {title: [row for row, _ in make(scene)] for title, make in SECTIONS.items()}
    return {title: rows for title, rows in made.items() if rows}


def texts(scene: Scene, model: ModuleType, present: Present) -> dict[str, str]:
    """What stands in every row of `groups`, by key: a number as wide as all others, without its
    unit, or words; but not the time, which the page has with every picture. model: a module of the
    scene's structure; values of parameters are those of the chunk."""
    now = Now(scene, model, present)
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        rows = (one for make in SECTIONS.values() for one in make(scene))
        return {row.key: show(now) for row, show in rows if show}


def _parameter(name: str, more: str = "") -> Entry:
    """A row that shows a parameter; more: what is said of it beside its label."""
    parameter = PARAMETERS[name]
    row = Row(name, parameter.label + more, parameter.shown_unit)
    return row, lambda now: digits(now.parameter(name))


def _quantity(name: str, label: str = "") -> Entry:
    """A row that shows a number of the catalogue, in the words there if no others are given."""
    quantity, at = place(name)
    return _row(name, label, quantity, at), lambda now: digits(now.value(quantity.name, at))


def _moment(name: str, label: str = "") -> Entry:
    """A row that shows a moment or product of inertia; what is rounding alone is shown as zero."""
    quantity, at = place(name)

    def show(now: Now) -> str:
        value, largest = now.value(quantity.name, at), now.value("principal_moments", (1,))
        return digits(0.0 if abs(value) < ROUNDING * largest else value)

    return _row(name, label, quantity, at), show


def _row(name: str, label: str, quantity: Quantity, at: Index) -> Row:
    axis = f", {'xy'[at[0]]}" if at else ""
    return Row(name, label or quantity.words + axis, typeset(quantity.unit))


def _rod(scene: Scene) -> Iterator[Entry]:
    known = scene.structure.parameters
    for parameter in (*ROD, *scene.hold.parameters):
        if parameter.name in known:
            yield _parameter(parameter.name)
    laws = scene.distribution.differing
    for one in (*ROD, MASS_PER_LENGTH):
        if isinstance(law := laws.get(one.key), str):
            said = f"{one.label} = {law} {one.shown_unit}"
            yield Row(f"{one.name}_law", "", ""), partial(_said, said)
    for at, body in enumerate(scene.bodies):
        yield Row(f"body_mass_{at}", f"mass of {body.name}", "kg"), partial(_body_mass, at)
    yield Row("links", "links", ""), lambda now: whole(now.scene.rod.links)
    yield Row("link_length", "length of a link", "m"), lambda now: digits(now.share("length"))
    yield Row("link_mass", "mass of a link", "kg"), lambda now: _range(now.link_mass)
    if scene.rod.links > 1:
        row = Row("spring_stiffness", "stiffness of a spring", "N m/rad")
        yield row, lambda now: _range(now.stiffness[1:-1])
    if scene.hold.root:
        row = Row("root_stiffness", "stiffness of the root spring", "N m/rad")
        yield row, lambda now: digits(float(now.stiffness[0]))


def _said(text: str, _: Now) -> str:
    return text


def _body_mass(at: int, now: Now) -> str:
    return digits(now.scene.distribution_at(float(now.motion.t[-1])).body_mass[at])


def _loads(scene: Scene) -> Iterator[Entry]:
    for name in scene.loads.parameters:
        one = PARAMETERS[name]
        if one.each == JOINTS:
            yield from _by_joint(one, scene.rod.links)
        elif one.several and name not in scene.along:
            yield Row(name, one.label, one.shown_unit), partial(_all_along, name)
        elif not one.several:
            yield _parameter(name, ", at present" if name in scene.expressions else "")


def _by_joint(parameter: Parameter, links: int) -> Iterator[Entry]:
    """Rows for the joints at both ends and for those between: one value, or the range of all."""
    parts = {"nose": slice(1), "body": slice(1, -1), "tail": slice(-1, None)}
    for part, joints in parts.items():
        if links == 1 and part == "body":
            continue

        def show(now: Now, joints: slice = joints) -> str:
            return _range(now.along(parameter.name)[joints])

        unit = parameter.shown_unit
        yield Row(f"{parameter.name}_{part}", f"{parameter.label}, {part}", unit), show


def _all_along(name: str, now: Now) -> str:
    return _range(now.along(name))


def _range(values: Array) -> str:
    """One value, or the smallest and the largest of several."""
    low, high = (digits(float(value)) for value in (values.min(), values.max()))
    return low if low == high else f"{low.strip()} to {high.strip()}"


def _critical(scene: Scene) -> Iterator[Entry]:
    for term in map(TERMS.__getitem__, scene.loads.following[:1]):
        if not term.has_size:
            continue
        (force,) = (one.name for one in term.sizes)
        yield _parameter(force)
        yield Row("critical_load", "critical force", "N"), _critical_force
        yield Row("critical_why", "", ""), _critical_why
        row = Row("critical_ratio", "force over critical force", "%")
        yield row, partial(_beside_critical, force, _percent)
        row = Row("critical_distance", "distance to the critical force", "N")
        yield row, partial(_beside_critical, force, lambda now, most: digits(most - now))


def _critical_force(now: Now) -> str:
    found = now.present.critical
    if isinstance(found, str):
        return padded(NOTHING if len(found) > WIDTH else found)
    return padded(NOTHING) if found is None else digits(found)


def _critical_why(now: Now) -> str:
    """Why there is none, in words that need a row of their own."""
    found = now.present.critical
    return found if isinstance(found, str) and len(found) > WIDTH else ""


def _percent(force: float, critical: float) -> str:
    return fixed(100 * force / critical, 2) if critical else padded(NOTHING)


def _beside_critical(force: str, shown: Callable[[float, float], str], now: Now) -> str:
    """Something made of the present force and the critical one."""
    found = now.present.critical
    if not isinstance(found, float | int):
        return padded(NOTHING)
    return shown(now.parameter(force), found)


def _geometry(_: Scene) -> Iterator[Entry]:
    yield _quantity("centre_of_gravity_x")
    yield _quantity("centre_of_gravity_y")
    row = Row("principal_direction_1", "principal direction 1", "°")
    yield row, lambda now: fixed(_degrees(now), ANGLE)
    row = Row("principal_direction_2", "principal direction 2", "°")
    yield row, lambda now: fixed(_degrees(now) + (90 if _degrees(now) <= 0 else -90), ANGLE)
    yield _moment("principal_moment_1", "principal moment 1")
    yield _moment("principal_moment_2", "principal moment 2")
    yield _moment("inertia_x")
    yield _moment("inertia_y")
    yield _moment("product_xy")


def _degrees(now: Now) -> float:
    return math.degrees(now.value("principal_angle"))


def _energies(scene: Scene) -> Iterator[Entry]:
    yield _quantity("kinetic_energy")
    yield _quantity("spring_energy")
    terms = [TERMS[term] for term in scene.structure.loads]
    if any(term.kind == WEIGHT for term in terms):
        yield _quantity("gravity_energy")
    yield _quantity("total_energy", "total energy")
    for term in terms:
        if term.kind != WEIGHT:
            yield Row(f"work_{term.name}", f"work of {term.words}", "J"), _work(term.name)
    if scene.structure.masses:
        yield Row(f"work_{EMPTYING}", f"work of {EMPTYING}", "J"), _work(EMPTYING)
    yield Row(f"work_{PULL}", f"work of the {PULL}", "J"), _work(PULL)
    row = Row("given", "given by changes and kicks", "J")
    yield row, lambda now: digits(now.present.chunk.given)
    yield _quantity("energy_balance", "balance error")


def _work(term: str) -> Callable[[Now], str]:
    """Work of a load; a rod whose module does no work by it shows none."""
    return lambda now: digits(now.value(f"work_{term}") if term in now.motion.work else 0.0)


def _integration(scene: Scene) -> Iterator[Entry]:
    yield Row("method", "method", ""), _method
    if scene.integrate.fixed:
        yield Row("step", "step", "s"), _step
    else:
        yield Row("rtol", "relative tolerance", ""), lambda now: digits(now.settings.rtol)
        yield Row("atol", "absolute tolerance", ""), lambda now: digits(now.settings.atol)
    yield Row("t", "simulated time", "s"), None
    yield Row("seconds", "computing time", "s"), lambda now: fixed(now.present.seconds, 2)
    yield Row("ratio", "ratio to real time", ""), _ratio
    yield Row("steps", "steps", ""), lambda now: whole(now.present.counts.nsteps)
    yield Row("rejected", "rejected steps", ""), _rejected
    yield Row("rhs", "evaluations of rhs", ""), lambda now: whole(now.present.counts.nfev)


def _method(now: Now) -> str:
    asked, used = now.scene.integrate, now.settings
    if used.rtol != asked.rtol:
        return padded(f"{used.method} (for looking)")
    by_rule = asked.method == AUTO != used.method
    return padded(f"{used.method} ({AUTO})" if by_rule else used.method)


def _step(now: Now) -> str:
    step = now.settings.step if now.settings.fixed else None
    return padded(NOTHING) if step is None else digits(step)


def _ratio(now: Now) -> str:
    ratio = now.present.ratio
    return padded(NOTHING) if ratio is None else digits(ratio, 3)


def _rejected(now: Now) -> str:
    rejected = now.present.counts.rejected
    return padded(NOTHING) if rejected is None else whole(rejected)


SECTIONS: dict[str, Callable[[Scene], Iterator[Entry]]] = {
    "Rod": _rod,
    "Loads and damping": _loads,
    "Critical force": _critical,
    "Centre of gravity and inertia": _geometry,
    "Energy": _energies,
    "Integration": _integration,
}
