"""The panel of values of a live run: its rows, and the texts in them at present."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from types import MappingProxyType, ModuleType
from typing import NamedTuple

import numpy as np

from rodgen.analyse.critical import Critical
from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.stepper import Counts
from rodgen.model.quantities import Index, find_quantity
from rodgen.model.rod import MASS_PER_LENGTH, ROD
from rodgen.model.term import JOINTS, WEIGHT, typeset
from rodgen.model.terms import EMPTYING, PARAMETERS, TERMS
from rodgen.scene import Scene, spring_law
from rodgen.scene.integration import AUTO, IntegrationTable
from rodgen_live.plot_quantities import motion_of
from rodgen_live.sample_store import Chunk

WIDTH = 12  # of -1.2345e-100
FIGURE_SPACE = "\u2007"  # as wide as a digit, and kept by HTML at the start of a line
THIN_SPACE = "\u202f"  # between thousands, where no line is broken
NOTHING = "–"
ANGLE = 3  # decimals of degrees
ROUNDING = 1e-12  # of the larger principal moment
CRITICAL = "kind", "frequency", "modes", "error"  # rows that are shown of a critical force


def format_significant(value: float, count: int = 5) -> str:
    """Format a number with `count` significant digits."""
    text = f"{value:#.{count}g}" if math.isfinite(value) else str(value)
    return pad(text.removesuffix("."))


def format_decimals(value: float, decimals: int) -> str:
    """Format a number with fixed decimals; one too large for them with five significant digits."""
    if not abs(value) < 10.0 ** (WIDTH - 3 - decimals):
        return format_significant(value)
    return pad(f"{round(value, decimals) + 0.0:.{decimals}f}")  # + 0.0: no negative zero


def format_integer(value: int) -> str:
    """Format a whole number, its thousands apart."""
    return pad(f"{value:,}".replace(",", THIN_SPACE))


def pad(text: str) -> str:
    """Right-justify a text in its column."""
    return text.rjust(WIDTH, FIGURE_SPACE)


class TextRow(NamedTuple):
    """A row of the panel: key, label, unit; without a label it is a row of text alone. It is
    not there while its text is empty."""

    key: str
    label: str
    unit: str


class CriticalForce(NamedTuple):
    """Critical follower force. value: the force [N], or in words why there is none, or None where
    no force follows the rod; rows, notes: those of its result as text, rows by their words."""

    value: float | str | None = None
    rows: Mapping[str, str] = MappingProxyType({})
    notes: Sequence[str] = ()


@dataclass
class RunStatus:
    """State of a run for the panel. scene, model: of the run; chunk: its last sample is the
    present; counts and seconds: cost of the run so far, computing time [s]; settings: those in use;
    ratio: simulated seconds in one second of late, None where it is not known."""

    scene: Scene
    model: ModuleType
    chunk: Chunk
    counts: Counts
    seconds: float
    settings: IntegrationTable
    ratio: float | None = None
    critical: CriticalForce = field(default_factory=CriticalForce)

    @cached_property
    def motion(self) -> MotionSlice:
        """The last sample, and what follows from it."""
        return motion_of(self.model, self.chunk.last(), self.scene.time_dependent_loads)

    def value(self, name: str, at: Index = ()) -> float:
        """Present value of an entry of a quantity."""
        return float(self.motion.values(name)[(0, *at)])

    def parameter(self, name: str) -> float:
        """Present value of a parameter of the module, or of a load that changes with time."""
        follows = name in self.motion.time_dependent_loads or name in self.motion.values("signals")
        return self.value(name) if follows else float(self.motion.parameter(name))

    @property
    def link_mass(self) -> Array:
        """Mass of every link with its bodies [kg]; one number for a uniform rod."""
        if self.scene.structure.masses:
            present = self.scene.distribution_at(float(self.motion.t[-1]))
            return np.array(present.link_parameters()["link_mass"])
        place = self.scene.structure.slices.get("link_mass")
        return np.array([self.per_link("mass")]) if place is None else self.chunk.p[place]

    def per_link(self, name: str) -> float:
        """Share of one link in a parameter of the whole rod."""
        return self.parameter(name) / self.scene.rod.links

    @property
    def stiffness(self) -> Array:
        """Stiffness of the springs, where the rod is straight, in the joints that have one
        [N m/rad]."""
        linear, law = np.array(self.scene.distribution.joint_stiffness), self.scene.spring_law
        if law is None:
            return linear
        return np.broadcast_to(law.derivative(0.0, {spring_law.STIFFNESS: linear}), linear.shape)


Value = float | str | None  # None: not known
Entry = tuple[TextRow, Callable[[RunStatus], Value] | None]


def row_groups(scene: Scene) -> dict[str, list[TextRow]]:
    """The rows of the panel by the title of their group: those of loads, springs and settings that
    the scene has. They are fixed by its structure and the kind of its method."""
    made = {title: [row for row, _ in make(scene)] for title, make in SECTIONS.items()}
    return {title: rows for title, rows in made.items() if rows}


def row_texts(now: RunStatus) -> dict[str, str]:
    """Text of every row of `row_groups`, by key: a number as wide as all others, without its unit,
    or words. The time is left out, as the page has it with every picture."""
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        rows = (one for make in SECTIONS.values() for one in make(now.scene))
        return {row.key: _format_value(value(now), row) for row, value in rows if value}


def _format_value(value: Value, row: TextRow) -> str:
    if value is None:
        return pad(NOTHING)
    if isinstance(value, str):
        return pad(value) if value and row.label else value
    return format_integer(value) if isinstance(value, int) else format_significant(value)


def _row(key: str, label: str, unit: str, value: Callable[[RunStatus], Value]) -> Entry:
    return TextRow(key, label, unit), value


def _parameter(name: str, more: str = "") -> Entry:
    """Row that shows a parameter; more: text after its label."""
    one = PARAMETERS[name]
    return _row(name, one.label + more, one.display_unit, lambda now: now.parameter(name))


def _quantity(name: str, label: str = "") -> Entry:
    """Row that shows a scalar of the catalogue, with its words there unless a label is given."""
    quantity, at = find_quantity(name)
    label = label or quantity.words + (f", {'xy'[at[0]]}" if at else "")
    return _row(name, label, typeset(quantity.unit), lambda now: now.value(quantity.name, at))


def _moment(name: str, label: str = "") -> Entry:
    """Row that shows a moment or product of inertia; rounding errors are shown as zero."""
    quantity, at = find_quantity(name)

    def rounded(now: RunStatus) -> float:
        value, largest = now.value(quantity.name, at), now.value("principal_moments", (1,))
        return 0.0 if abs(value) < ROUNDING * largest else value

    return _quantity(name, label)[0], rounded


def _rod(scene: Scene) -> Iterator[Entry]:
    known, boundary = scene.structure.parameters, scene.boundary_condition
    for parameter in (*ROD, *boundary.parameters):
        if parameter.name in known:
            yield _parameter(parameter.name)
    laws = scene.distribution.nonuniform_values
    for one in (*ROD, MASS_PER_LENGTH):
        if isinstance(law := laws.get(one.key), str):
            said = f"{one.label} = {law} {one.display_unit}"
            yield TextRow(f"{one.name}_law", "", ""), partial(_constant_text, said)
    for at, body in enumerate(scene.bodies):
        mass = partial(_body_mass, at)
        yield _row(f"body_mass_{at}", f"mass of {body.name}", "kg", mass)
    yield _row("links", "links", "", lambda now: now.scene.rod.links)
    yield _row("link_length", "length of a link", "m", lambda now: now.per_link("length"))
    yield _row("link_mass", "mass of a link", "kg", lambda now: _format_range(now.link_mass))
    unit = "N m/rad"
    if scene.rod.links > 1:
        label = "stiffness of a spring"
        inner = slice(bool(boundary.root), scene.rod.links - 1 + bool(boundary.root))
        yield _row("spring_stiffness", label, unit, lambda now: _format_range(now.stiffness[inner]))
    if boundary.root:
        label = "stiffness of the root spring"
        yield _row("root_stiffness", label, unit, lambda now: float(now.stiffness[0]))


def _constant_text(text: str, _: RunStatus) -> str:
    return text


def _body_mass(at: int, now: RunStatus) -> float:
    return now.scene.distribution_at(float(now.motion.t[-1])).body_masses[at]


def _loads(scene: Scene) -> Iterator[Entry]:
    parts = {"nose": slice(1), "body": slice(1, -1), "tail": slice(-1, None)}
    for name in scene.loads.parameters:
        one = PARAMETERS[name]
        if one.each == JOINTS:
            for part, joints in parts.items():
                if scene.rod.links > 1 or part != "body":
                    label, range_of = f"{one.label}, {part}", partial(_range_of, name, joints)
                    yield _row(f"{name}_{part}", label, one.display_unit, range_of)
        elif one.is_array and name not in scene.loads_along_rod:
            yield _row(name, one.label, one.display_unit, partial(_range_of, name, slice(None)))
        elif not one.is_array:
            yield _parameter(name, ", at present" if name in scene.expressions else "")


def _range_of(name: str, places: slice, now: RunStatus) -> str:
    return _format_range(now.chunk.p[now.scene.structure.slices[name]][places])


def _format_range(values: Array) -> str:
    low, high = (format_significant(float(value)) for value in (values.min(), values.max()))
    return low if low == high else f"{low.strip()} to {high.strip()}"


def _critical_rows(scene: Scene) -> Iterator[Entry]:
    for term in map(TERMS.__getitem__, scene.loads.follower_loads[:1]):
        if not term.has_size:
            continue
        (force,) = (one.name for one in term.size_parameters)
        yield _parameter(force)
        yield _row("critical_load", "critical force", "N", lambda now: _critical(now)[0])
        yield _row("critical_why", "", "", lambda now: _critical(now)[1])
        yield _row(
            "critical_ratio", "force over critical force", "%", partial(_critical_ratio, force)
        )
        label = "distance to the critical force"
        yield _row("critical_distance", label, "N", partial(_critical_distance, force))
        for row in Critical.ROWS:
            if row.name in CRITICAL:
                yield _row(f"critical_{row.name}", row.words, "", partial(_critical_row, row.words))
        yield _row("critical_notes", "", "", lambda now: "; ".join(now.critical.notes))


def _critical(now: RunStatus) -> tuple[Value, str]:
    """Critical force, and the reason why there is none, if it is too long for the row of that."""
    found = now.critical.value
    return (None, found) if isinstance(found, str) and len(found) > WIDTH else (found, "")


def _critical_row(words: str, now: RunStatus) -> str:
    return now.critical.rows.get(words, "")


def _critical_ratio(force: str, now: RunStatus) -> Value:
    found = now.critical.value
    if not isinstance(found, float) or not found:
        return None
    return format_decimals(100 * now.parameter(force) / found, 2)


def _critical_distance(force: str, now: RunStatus) -> Value:
    found = now.critical.value
    return found - now.parameter(force) if isinstance(found, float) else None


def _geometry(_: Scene) -> Iterator[Entry]:
    yield _quantity("centre_of_gravity_x")
    yield _quantity("centre_of_gravity_y")
    for at in (1, 2):
        direction = partial(_direction, 90.0 * (at - 1))
        yield _row(f"principal_direction_{at}", f"principal direction {at}", "°", direction)
    yield _moment("principal_moment_1", "principal moment 1")
    yield _moment("principal_moment_2", "principal moment 2")
    yield _moment("inertia_x")
    yield _moment("inertia_y")
    yield _moment("product_xy")


def _direction(turned: float, now: RunStatus) -> str:
    """Direction of the principal axis [degrees], or of what is turned from it, above -90."""
    angle = math.degrees(now.value("principal_angle"))
    return format_decimals(angle + (turned if angle <= 0 else -turned), ANGLE)


def _energies(scene: Scene) -> Iterator[Entry]:
    yield _quantity("kinetic_energy")
    yield _quantity("spring_energy")
    terms = [TERMS[term] for term in scene.structure.loads]
    if any(term.kind == WEIGHT for term in terms):
        yield _quantity("gravity_energy")
    yield _quantity("total_energy", "total energy")
    works = {term.name: term.words for term in terms if term.kind != WEIGHT}
    works |= {EMPTYING: EMPTYING} if scene.structure.masses else {}
    for name, words in works.items():
        yield _row(f"work_{name}", f"work of {words}", "J", partial(_work, f"work_{name}"))
    # Not there until something is done to the run.
    given = "given by changes, kicks and pulls"
    yield _row("given", given, "J", lambda now: now.chunk.given or "")
    yield _quantity("energy_balance", "balance error")


def _work(name: str, now: RunStatus) -> Value:
    """Work of a load; nothing where the module has no such work."""
    return now.value(name) if name.removeprefix("work_") in now.motion.work else ""


def _integration(scene: Scene) -> Iterator[Entry]:
    yield _row("method", "method", "", _method)
    if scene.integrate.has_fixed_step:
        yield _row("step", "step", "s", _step)
    else:
        yield _row("rtol", "relative tolerance", "", lambda now: now.settings.rtol)
        yield _row("atol", "absolute tolerance", "", lambda now: now.settings.atol)
    yield TextRow("t", "simulated time", "s"), None
    yield _row("seconds", "computing time", "s", lambda now: format_decimals(now.seconds, 2))
    yield _row("ratio", "ratio to real time", "", _ratio)
    yield _row("steps", "steps", "", lambda now: now.counts.nsteps)
    yield _row("rejected", "rejected steps", "", lambda now: now.counts.rejected)
    yield _row("rhs", "evaluations of rhs", "", lambda now: now.counts.nfev)


def _method(now: RunStatus) -> str:
    asked, used = now.scene.integrate, now.settings
    if used.rtol != asked.rtol:
        return f"{used.method} (for looking)"
    by_rule = asked.method == AUTO != used.method
    return f"{used.method} ({AUTO})" if by_rule else used.method


def _step(now: RunStatus) -> Value:
    return now.settings.step if now.settings.has_fixed_step else None


def _ratio(now: RunStatus) -> Value:
    ratio = now.ratio
    return None if ratio is None else format_significant(ratio, 3)


SECTIONS: dict[str, Callable[[Scene], Iterator[Entry]]] = {
    "Rod": _rod,
    "Loads and damping": _loads,
    "Critical force": _critical_rows,
    "Centre of gravity and inertia": _geometry,
    "Energy": _energies,
    "Integration": _integration,
}
