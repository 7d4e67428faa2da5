"""The panel of values of a live run: its rows, and the texts in them at present."""

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
from rodgen.model.quantities import Index, Quantity, find_quantity
from rodgen.model.rod import CLAMP_ANGLE, MASS_PER_LENGTH, ROD
from rodgen.model.term import JOINTS, WEIGHT, Parameter, typeset
from rodgen.model.terms import EMPTYING, PARAMETERS, PULL, TERMS
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


@dataclass(frozen=True)
class RunStatus:
    """State of a run for the panel. chunk: its last sample is the present; counts and seconds: cost
    of the run so far, computing time [s]; ratio: simulated seconds in one second of late, None
    where it is not known; settings: those in use, where they are not the scene's own; critical:
    critical follower force [N], or in words why there is none ("computing"), or None."""

    chunk: Chunk
    counts: Counts
    seconds: float
    ratio: float | None = None
    settings: IntegrationTable | None = None
    critical: float | str | None = None


class PanelState:
    """Values for the rows: the last sample of a run, and what follows from it."""

    def __init__(self, scene: Scene, model: ModuleType, present: RunStatus):
        self.scene, self.model, self.present = scene, model, present
        self.settings = present.settings or scene.integrate
        self.motion = motion_of(model, present.chunk.last(), scene.time_dependent_loads)

    def value(self, name: str, at: Index = ()) -> float:
        """Present value of an entry of a quantity."""
        return float(self.motion.values(name)[(0, *at)])

    def parameter(self, name: str) -> float:
        """Present value of a parameter of the module, or of a load that changes with time."""
        follows = name in self.motion.time_dependent_loads or name in self.motion.values("signals")
        return self.value(name) if follows else float(self.motion.parameter(name))

    def parameter_values(self, name: str) -> Array:
        """Values of a parameter at every joint or link."""
        return self.present.chunk.p[self.scene.structure.slices[name]]

    @property
    def link_mass(self) -> Array:
        """Mass of every link with its bodies [kg]; one number for a uniform rod."""
        if self.scene.structure.masses:
            present = self.scene.distribution_at(float(self.motion.t[-1]))
            return np.array(present.link_parameters()["link_mass"])
        place = self.scene.structure.slices.get("link_mass")
        return np.array([self.per_link("mass")]) if place is None else self.present.chunk.p[place]

    def per_link(self, name: str) -> float:
        """Share of one link in a parameter of the whole rod."""
        return self.parameter(name) / self.scene.rod.links

    @property
    def stiffness(self) -> Array:
        """Stiffness of the springs in all joints [N m/rad], from the bending moments of the
        generated module where every link is turned from the one before, the first from its clamp:
        by 1 rad, or next to nothing where springs have a law of their own."""
        boundary, p = self.scene.boundary_condition, self.present.chunk.p
        clamp = self.parameter(CLAMP_ANGLE.name) if boundary.is_clamped else 0.0
        turned, first = np.zeros((2, len(self.model.STATE))), 2 * boundary.translates
        turn = 1.0 if self.scene.spring_law is None else spring_law.NEAR
        angles = np.arange(boundary.first, self.model.N) + bool(boundary.root)
        half = (turned.shape[1] - len(self.scene.states)) // 2
        turned[:, first:half] = clamp + turn * np.outer((-1, 1), angles)
        below, above = self.model.bending_moments(turned, p)
        stiffness: Array = (above - below) / (2 * turn)
        return stiffness


Entry = tuple[TextRow, Callable[[PanelState], str] | None]


def row_groups(scene: Scene) -> dict[str, list[TextRow]]:
    """The rows of the panel by the title of their group: those of loads, springs and settings that
    the scene has. They are fixed by its structure and the kind of its method."""
    made = {title: [row for row, _ in make(scene)] for title, make in SECTIONS.items()}
    return {title: rows for title, rows in made.items() if rows}


def row_texts(scene: Scene, model: ModuleType, present: RunStatus) -> dict[str, str]:
    """Text of every row of `row_groups`, by key: a number as wide as all others, without its unit,
    or words. The time is left out, as the page has it with every picture. model: a module of the
    scene's structure; values of parameters are those of the chunk."""
    now = PanelState(scene, model, present)
    with np.errstate(all="ignore"):  # a state may have stopped being finite
        rows = (one for make in SECTIONS.values() for one in make(scene))
        return {row.key: show(now) for row, show in rows if show}


def _parameter(name: str, more: str = "") -> Entry:
    """Row that shows a parameter; more: text after its label."""
    parameter = PARAMETERS[name]
    row = TextRow(name, parameter.label + more, parameter.display_unit)
    return row, lambda now: format_significant(now.parameter(name))


def _quantity(name: str, label: str = "") -> Entry:
    """Row that shows a scalar of the catalogue, with its words there unless a label is given."""
    quantity, at = find_quantity(name)
    return _row(name, label, quantity, at), lambda now: format_significant(
        now.value(quantity.name, at)
    )


def _moment(name: str, label: str = "") -> Entry:
    """Row that shows a moment or product of inertia; rounding errors are shown as zero."""
    quantity, at = find_quantity(name)

    def show(now: PanelState) -> str:
        value, largest = now.value(quantity.name, at), now.value("principal_moments", (1,))
        return format_significant(0.0 if abs(value) < ROUNDING * largest else value)

    return _row(name, label, quantity, at), show


def _row(name: str, label: str, quantity: Quantity, at: Index) -> TextRow:
    axis = f", {'xy'[at[0]]}" if at else ""
    return TextRow(name, label or quantity.words + axis, typeset(quantity.unit))


def _rod(scene: Scene) -> Iterator[Entry]:
    known = scene.structure.parameters
    for parameter in (*ROD, *scene.boundary_condition.parameters):
        if parameter.name in known:
            yield _parameter(parameter.name)
    laws = scene.distribution.nonuniform_values
    for one in (*ROD, MASS_PER_LENGTH):
        if isinstance(law := laws.get(one.key), str):
            said = f"{one.label} = {law} {one.display_unit}"
            yield TextRow(f"{one.name}_law", "", ""), partial(_constant_text, said)
    for at, body in enumerate(scene.bodies):
        yield TextRow(f"body_mass_{at}", f"mass of {body.name}", "kg"), partial(_body_mass, at)
    yield TextRow("links", "links", ""), lambda now: format_integer(now.scene.rod.links)
    yield (
        TextRow("link_length", "length of a link", "m"),
        lambda now: format_significant(now.per_link("length")),
    )
    yield TextRow("link_mass", "mass of a link", "kg"), lambda now: _format_range(now.link_mass)
    if scene.rod.links > 1:
        row = TextRow("spring_stiffness", "stiffness of a spring", "N m/rad")
        yield row, lambda now: _format_range(now.stiffness[1:-1])
    if scene.boundary_condition.root:
        row = TextRow("root_stiffness", "stiffness of the root spring", "N m/rad")
        yield row, lambda now: format_significant(float(now.stiffness[0]))


def _constant_text(text: str, _: PanelState) -> str:
    return text


def _body_mass(at: int, now: PanelState) -> str:
    return format_significant(now.scene.distribution_at(float(now.motion.t[-1])).body_masses[at])


def _loads(scene: Scene) -> Iterator[Entry]:
    for name in scene.loads.parameters:
        one = PARAMETERS[name]
        if one.each == JOINTS:
            yield from _by_joint(one, scene.rod.links)
        elif one.is_array and name not in scene.loads_along_rod:
            yield TextRow(name, one.label, one.display_unit), partial(_parameter_range, name)
        elif not one.is_array:
            yield _parameter(name, ", at present" if name in scene.expressions else "")


def _by_joint(parameter: Parameter, links: int) -> Iterator[Entry]:
    """Rows for the joints at both ends and for those between: one value, or the range of all."""
    parts = {"nose": slice(1), "body": slice(1, -1), "tail": slice(-1, None)}
    for part, joints in parts.items():
        if links == 1 and part == "body":
            continue

        def show(now: PanelState, joints: slice = joints) -> str:
            return _format_range(now.parameter_values(parameter.name)[joints])

        unit = parameter.display_unit
        yield TextRow(f"{parameter.name}_{part}", f"{parameter.label}, {part}", unit), show


def _parameter_range(name: str, now: PanelState) -> str:
    return _format_range(now.parameter_values(name))


def _format_range(values: Array) -> str:
    """Format one value, or the smallest and the largest of several."""
    low, high = (format_significant(float(value)) for value in (values.min(), values.max()))
    return low if low == high else f"{low.strip()} to {high.strip()}"


def _critical_rows(scene: Scene) -> Iterator[Entry]:
    for term in map(TERMS.__getitem__, scene.loads.follower_loads[:1]):
        if not term.has_size:
            continue
        (force,) = (one.name for one in term.size_parameters)
        yield _parameter(force)
        yield TextRow("critical_load", "critical force", "N"), _critical_force
        yield TextRow("critical_why", "", ""), _critical_reason
        row = TextRow("critical_ratio", "force over critical force", "%")
        yield row, partial(_compare_critical, force, _percent)
        row = TextRow("critical_distance", "distance to the critical force", "N")
        yield (
            row,
            partial(_compare_critical, force, lambda now, most: format_significant(most - now)),
        )


def _critical_force(now: PanelState) -> str:
    found = now.present.critical
    if isinstance(found, str):
        return pad(NOTHING if len(found) > WIDTH else found)
    return pad(NOTHING) if found is None else format_significant(found)


def _critical_reason(now: PanelState) -> str:
    """Reason why there is no critical force, if it is too long for the row of the force."""
    found = now.present.critical
    return found if isinstance(found, str) and len(found) > WIDTH else ""


def _percent(force: float, critical: float) -> str:
    return format_decimals(100 * force / critical, 2) if critical else pad(NOTHING)


def _compare_critical(force: str, shown: Callable[[float, float], str], now: PanelState) -> str:
    """Text that `shown` makes of the present force and the critical one."""
    found = now.present.critical
    if not isinstance(found, float | int):
        return pad(NOTHING)
    return shown(now.parameter(force), found)


def _geometry(_: Scene) -> Iterator[Entry]:
    yield _quantity("centre_of_gravity_x")
    yield _quantity("centre_of_gravity_y")
    row = TextRow("principal_direction_1", "principal direction 1", "°")
    yield row, lambda now: format_decimals(_degrees(now), ANGLE)
    row = TextRow("principal_direction_2", "principal direction 2", "°")
    yield (
        row,
        lambda now: format_decimals(_degrees(now) + (90 if _degrees(now) <= 0 else -90), ANGLE),
    )
    yield _moment("principal_moment_1", "principal moment 1")
    yield _moment("principal_moment_2", "principal moment 2")
    yield _moment("inertia_x")
    yield _moment("inertia_y")
    yield _moment("product_xy")


def _degrees(now: PanelState) -> float:
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
            yield TextRow(f"work_{term.name}", f"work of {term.words}", "J"), _work(term.name)
    if scene.structure.masses:
        yield TextRow(f"work_{EMPTYING}", f"work of {EMPTYING}", "J"), _work(EMPTYING)
    yield TextRow(f"work_{PULL}", f"work of the {PULL}", "J"), _work(PULL)
    row = TextRow("given", "given by changes and kicks", "J")
    yield row, lambda now: _unless_zero(now.present.chunk.given)
    yield _quantity("energy_balance", "balance error")


def _work(term: str) -> Callable[[PanelState], str]:
    """Make the function for the text of the work of a load, nothing where the module has no such
    work."""
    return lambda now: (
        format_significant(now.value(f"work_{term}")) if term in now.motion.work else ""
    )


def _unless_zero(value: float) -> str:
    """Format a number that is zero until something is done to the run, and not there so long."""
    return format_significant(value) if value else ""


def _integration(scene: Scene) -> Iterator[Entry]:
    yield TextRow("method", "method", ""), _method
    if scene.integrate.has_fixed_step:
        yield TextRow("step", "step", "s"), _step
    else:
        yield (
            TextRow("rtol", "relative tolerance", ""),
            lambda now: format_significant(now.settings.rtol),
        )
        yield (
            TextRow("atol", "absolute tolerance", ""),
            lambda now: format_significant(now.settings.atol),
        )
    yield TextRow("t", "simulated time", "s"), None
    yield (
        TextRow("seconds", "computing time", "s"),
        lambda now: format_decimals(now.present.seconds, 2),
    )
    yield TextRow("ratio", "ratio to real time", ""), _ratio
    yield TextRow("steps", "steps", ""), lambda now: format_integer(now.present.counts.nsteps)
    yield TextRow("rejected", "rejected steps", ""), _rejected_steps
    yield (
        TextRow("rhs", "evaluations of rhs", ""),
        lambda now: format_integer(now.present.counts.nfev),
    )


def _method(now: PanelState) -> str:
    asked, used = now.scene.integrate, now.settings
    if used.rtol != asked.rtol:
        return pad(f"{used.method} (for looking)")
    by_rule = asked.method == AUTO != used.method
    return pad(f"{used.method} ({AUTO})" if by_rule else used.method)


def _step(now: PanelState) -> str:
    step = now.settings.step if now.settings.has_fixed_step else None
    return pad(NOTHING) if step is None else format_significant(step)


def _ratio(now: PanelState) -> str:
    ratio = now.present.ratio
    return pad(NOTHING) if ratio is None else format_significant(ratio, 3)


def _rejected_steps(now: PanelState) -> str:
    rejected = now.present.counts.rejected
    return pad(NOTHING) if rejected is None else format_integer(rejected)


SECTIONS: dict[str, Callable[[Scene], Iterator[Entry]]] = {
    "Rod": _rod,
    "Loads and damping": _loads,
    "Critical force": _critical_rows,
    "Centre of gravity and inertia": _geometry,
    "Energy": _energies,
    "Integration": _integration,
}
