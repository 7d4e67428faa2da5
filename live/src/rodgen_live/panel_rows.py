"""The panel of values of a live run: its rows, and the texts in them at present."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType, ModuleType
from typing import NamedTuple

import numpy as np

from rodgen.analyse.critical import Critical
from rodgen.arrays import Array
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.integrate.stepper import Counts
from rodgen.model.quantities import Index, find_quantity
from rodgen.model.rod import MASS_PER_LENGTH, REST_CURVATURE, ROD
from rodgen.model.term import JOINTS, typeset
from rodgen.model.terms import EMPTYING, PARAMETERS, TERMS, describe
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
PARTS = {"nose": slice(1), "body": slice(1, -1), "tail": slice(-1, None)}  # of the joints
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
    """A row of the panel: key, label, unit; without a label it is a row of text alone. text: a
    number as wide as all others, without its unit, or words; while it is empty the row is not
    there; None: the page has it otherwise."""

    key: str
    label: str
    unit: str
    text: str | None


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
            then = self.scene.distribution_at(float(self.motion.t[-1]))
            links = [body.link for body in then.body_outlines]
            return then.link_masses + np.bincount(links, then.body_masses, self.scene.rod.links)
        place = self.scene.structure.slices.get("link_mass")
        return self.per_link("mass") if place is None else self.chunk.p[place]

    def per_link(self, name: str) -> Array:
        """Share of every link in a parameter of the whole rod; one number where all are alike."""
        found = self.scene.mesh.lengths(self.parameter(name))
        return found[:1] if self.scene.mesh.is_even else found

    @property
    def stiffness(self) -> Array:
        """Stiffness of the springs, where the rod is straight, in the joints that have one
        [N m/rad]."""
        linear, law = np.array(self.scene.distribution.joint_stiffness), self.scene.spring_law
        if law is None:
            return linear
        return np.broadcast_to(law.derivative(0.0, {spring_law.STIFFNESS: linear}), linear.shape)


Value = float | str | None  # None: not known
Groups = dict[str, list[TextRow]]


def row_groups(now: RunStatus) -> Groups:
    """Rows of the panel by the title of their group: those of loads, springs and settings that the
    scene has. Which they are is fixed by its structure and the kind of its method."""
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        made = {title: list(make(now)) for title, make in SECTIONS.items()}
    return {title: rows for title, rows in made.items() if rows}


def _row(key: str, label: str, unit: str, value: Value) -> TextRow:
    if value is None:
        text = pad(NOTHING)
    elif isinstance(value, str):
        text = pad(value) if value and label else value
    else:
        text = format_integer(value) if isinstance(value, int) else format_significant(value)
    return TextRow(key, label, unit, text)


def _parameter(now: RunStatus, name: str, more: str = "") -> TextRow:
    """Row that shows a parameter that is not zero, or that changes; more: text after its label."""
    one, value = PARAMETERS[name], now.parameter(name)
    return _row(name, one.label + more, one.display_unit, value if value or more else "")


def _quantity(now: RunStatus, name: str, label: str = "", least: float = 0.0) -> TextRow:
    """Row that shows a scalar of the catalogue, with its words there unless a label is given;
    least: smaller values are rounding errors, which are shown as zero."""
    quantity, at = find_quantity(name)
    label = label or quantity.words + (f", {'xy'[at[0]]}" if at else "")
    value = now.value(quantity.name, at)
    return _row(name, label, typeset(quantity.unit), 0.0 if abs(value) < least else value)


def _rod(now: RunStatus) -> Iterator[TextRow]:
    scene, boundary = now.scene, now.scene.boundary_condition
    for parameter in (*ROD, *boundary.parameters):
        if parameter.name in scene.structure.parameters:
            yield _parameter(now, parameter.name)
    laws = scene.distribution.nonuniform_values
    for one in (*ROD, MASS_PER_LENGTH, REST_CURVATURE):
        if isinstance(law := laws.get(one.key), str):
            yield _row(f"{one.name}_law", "", "", f"{one.label} = {law} {one.display_unit}")
    if scene.bodies:
        masses = scene.distribution_at(float(now.motion.t[-1])).body_masses
        for at, body in enumerate(scene.bodies):
            yield _row(f"body_mass_{at}", f"mass of {body.name}", "kg", float(masses[at]))
    yield _row("links", "links", "", scene.rod.links)
    yield _row("link_length", "length of a link", "m", _format_range(now.per_link("length")))
    yield _row("link_mass", "mass of a link", "kg", _format_range(now.link_mass))
    unit, stiffness = "N m/rad", now.stiffness
    if scene.rod.links > 1:
        inner = slice(bool(boundary.root), scene.rod.links - 1 + bool(boundary.root))
        shown = _format_range(stiffness[inner])
        yield _row("spring_stiffness", "stiffness of a spring", unit, shown)
    if boundary.root:
        label = "stiffness of the root spring"
        yield _row("root_stiffness", label, unit, float(stiffness[0]))


def _loads(now: RunStatus) -> Iterator[TextRow]:
    scene = now.scene
    rows = (row for row in scene.structure.load_rows.values() if row.is_load)
    loads = dict.fromkeys(one.name for row in rows for one in row.parameters)
    for name in (*loads, *scene.structure.base_parameters):
        one = PARAMETERS[name]
        if not one.is_array:
            yield _parameter(now, name, ", at present" if name in scene.expressions else "")
        elif one.each == JOINTS:
            values = now.chunk.p[scene.structure.slices[name]]
            for part, joints in PARTS.items():
                if scene.rod.links > 1 or part != "body":
                    label, shown = f"{one.label}, {part}", _format_range(values[joints])
                    yield _row(f"{name}_{part}", label, one.display_unit, shown)
        elif name not in scene.loads_along_rod:
            shown = _format_range(now.chunk.p[scene.structure.slices[name]])
            yield _row(name, one.label, one.display_unit, shown)


def _format_range(values: Array) -> str:
    low, high = (format_significant(float(value)) for value in (values.min(), values.max()))
    return low if low == high else f"{low.strip()} to {high.strip()}"


def _critical_rows(now: RunStatus) -> Iterator[TextRow]:
    terms = [TERMS[name] for name in now.scene.loads.follower_loads[:1]]
    if not terms or not terms[0].has_size:
        return
    (name,) = (one.name for one in terms[0].size_parameters)
    force, found = now.parameter(name), now.critical.value
    too_long = isinstance(found, str) and len(found) > WIDTH
    yield _row("critical_load", "critical force", "N", None if too_long else found)
    yield _row("critical_why", "", "", found if too_long else "")
    ratio = distance = None
    if isinstance(found, float):
        distance = found - force
        ratio = format_decimals(100 * force / found, 2) if found else None
    yield _row("critical_ratio", "force over critical force", "%", ratio)
    yield _row("critical_distance", "distance to the critical force", "N", distance)
    for row in Critical.ROWS:
        if row.name in CRITICAL:
            shown = now.critical.rows.get(row.words, "")
            yield _row(f"critical_{row.name}", row.words, "", shown)
    yield _row("critical_notes", "", "", "; ".join(now.critical.notes))


def _geometry(now: RunStatus) -> Iterator[TextRow]:
    yield _quantity(now, "centre_of_gravity_x")
    yield _quantity(now, "centre_of_gravity_y")
    angle = math.degrees(now.value("principal_angle"))
    # Either is above -90 degrees.
    for at, direction in enumerate((angle, angle + (90.0 if angle <= 0 else -90.0)), 1):
        shown = format_decimals(direction, ANGLE)
        yield _row(f"principal_direction_{at}", f"principal direction {at}", "°", shown)
    least = ROUNDING * now.value("principal_moments", (1,))
    for at in (1, 2):
        yield _quantity(now, f"principal_moment_{at}", f"principal moment {at}", least)
    for name in ("inertia_x", "inertia_y", "product_xy"):
        yield _quantity(now, name, least=least)


def _energies(now: RunStatus) -> Iterator[TextRow]:
    structure = now.scene.structure
    yield _quantity(now, "kinetic_energy")
    yield _quantity(now, "spring_energy")
    if structure.potentials:
        yield _quantity(now, "gravity_energy")
    yield _quantity(now, "total_energy", "total energy")
    works = [name for name in structure.loads if name not in structure.potentials]
    for name in [*works, EMPTYING] if structure.masses else works:
        key, words = f"work_{name}", f"work of {describe(name)}"  # which a module may lack
        yield _row(key, words, "J", now.value(key) if name in now.motion.work else "")
    # Not there until something is done to the run.
    yield _row("given", "given by changes, kicks and pulls", "J", now.chunk.given or "")
    yield _quantity(now, "energy_balance", "balance error")


def _integration(now: RunStatus) -> Iterator[TextRow]:
    asked, used, counts = now.scene.integrate, now.settings, now.counts
    by_rule = asked.method == AUTO != used.method
    why = " (for looking)" if used.rtol != asked.rtol else f" ({AUTO})" * by_rule
    yield _row("method", "method", "", used.method + why)
    if asked.has_fixed_step:
        yield _row("step", "step", "s", used.step if used.has_fixed_step else None)
    else:
        yield _row("rtol", "relative tolerance", "", used.rtol)
        yield _row("atol", "absolute tolerance", "", used.atol)
    yield TextRow("t", "simulated time", "s", None)  # it comes with every picture
    yield _row("seconds", "computing time", "s", format_decimals(now.seconds, 2))
    ratio = None if now.ratio is None else format_significant(now.ratio, 3)
    yield _row("ratio", "ratio to real time", "", ratio)
    yield _row("steps", "steps", "", counts.nsteps)
    yield _row("rejected", "rejected steps", "", counts.rejected)
    yield _row("rhs", "evaluations of rhs", "", counts.nfev)


SECTIONS: dict[str, Callable[[RunStatus], Iterator[TextRow]]] = {
    "Rod": _rod,
    "Loads and damping": _loads,
    "Critical force": _critical_rows,
    "Centre of gravity and inertia": _geometry,
    "Energy": _energies,
    "Integration": _integration,
}
