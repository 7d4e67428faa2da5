"""Parameters of a rod, of its boundary or of a load (names, unit, limits, default), and terms:
loads or kinds of damping, with their names and parameters, and how they are drawn.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, TypeVar

ANY, NOT_NEGATIVE, POSITIVE = "any", "at least 0", "positive"
AT_LEAST_ONE, SIDE = "at least 1", "1 or -1"
# What a parameter of several numbers has one for: see Structure.spans.
JOINTS, LINKS, SPRINGS = "joint", "link", "joint with a spring"
KNOTS = "row of a table, its knots first"

# Kinds of terms: what they act on.
FORCE = "force at a point"
COUPLE = "moment on a link"
SPREAD = "force along the rod"
WEIGHT = "force on mass"
DAMPER = "damping moment across joints"
DRAG = "damping forces on joints"
ANCHOR = "springs and dampers from joints to the ground"
BASE = "motion of what holds the start"
CONTACT = "what pushes while it is pressed"
AIR = "force of the air on a point"


def holds(rule: str, numbers: Any) -> Any:
    """Whether a rule allows numbers, each of an array."""
    match rule:
        case "any":
            return numbers == numbers
        case "at least 0":
            return numbers >= 0
        case "positive":
            return numbers > 0
        case "from 0 to 1":
            return (numbers >= 0) & (numbers <= 1)
        case "at least 1":
            return numbers >= 1
        case "1 or -1":
            return abs(numbers) == 1
    raise ValueError(rule)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that a generated module takes, or one for every joint or link.

    name: in the module; key: in its table of a scene; label: in words; symbol: its letter;
    unit: with powers as in "m/s^2"; description: a phrase in which "[]" stands for the unit;
    rule: which values are allowed; default: None where a scene has to give it; first: its value
    in a load that is switched on in the live view, where that is not the default.

    part: which of the numbers of its key it is, where that has two; timed: a scene may give it as a
    function of time; each: what it has a number, or two, for each of, JOINTS, LINKS, SPRINGS or
    KNOTS, where it is several; scales: the load is in proportion to it; decades: a slider moves
    over powers of ten; most: the largest value that it may have; fixed: another value needs another
    module; optional: a module has it only where a scene has its key; unless: the key of optional
    ones that stand in its place where a scene has that; beside: the key of an optional one with
    which it is there; computed: that of a scene without its key follows from the rod; links_power:
    for one and the same rod it grows as this power of the number of links; by_mass: its effect is
    in proportion to the mass of the links at the start of the span; table: of the scene that has
    its key, where that is not the term's own; by_height: the number of such a table at the place of
    its load, where it follows the height there.
    """

    name: str
    key: str
    label: str
    symbol: str
    unit: str
    description: str
    _: KW_ONLY
    rule: str = ANY
    default: float | None = None
    first: float | None = None
    part: int | None = None
    timed: bool = False
    each: str = ""
    scales: bool = False
    decades: bool = False
    most: float | None = None
    fixed: bool = False
    optional: bool = False
    unless: str = ""
    beside: str = ""
    computed: bool = False
    links_power: int = 0
    by_mass: bool = False
    table: str = ""
    by_height: bool = False

    @property
    def is_shared(self) -> bool:
        """Whether several loads have it as one and the same number."""
        return bool(self.table) and not self.by_height

    @property
    def prefix(self) -> str:
        """What the names of the numbers in its expression begin with: of what follows the height,
        those of the table, which are the same at every place."""
        if not self.by_height:
            return self.name
        axis = () if self.part is None else ("xy"[self.part],)
        return "_".join((self.table, self.key, *axis))

    @property
    def key_path(self) -> tuple[str, ...]:
        """Path of keys in its table of a scene."""
        return (self.key,) if self.part is None else (self.key, str(self.part))

    def is_there(self, keys: Collection[str]) -> bool:
        """Whether a module has it that has the optional parameters of these keys."""
        asked = not self.optional or self.option in keys
        return asked and not (self.unless and self.unless in keys)

    @property
    def option(self) -> str:
        """Key with which a module has it, of an optional one."""
        return f"{self.key}{BY_HEIGHT}" if self.by_height else self.beside or self.key

    @property
    def is_signed(self) -> bool:
        """Whether it may be negative."""
        return self.rule == ANY

    @property
    def is_array(self) -> bool:
        """Whether it is several numbers."""
        return bool(self.each)

    @property
    def is_angle(self) -> bool:
        """Whether it is an angle."""
        return self.unit == "rad"

    @property
    def initial_value(self) -> float | None:
        """Initial value in a load that is added to a scene."""
        return self.default if self.first is None else self.first

    @property
    def display_unit(self) -> str:
        """Unit with superscript powers, for pictures and pages."""
        return typeset(self.unit)

    @property
    def documentation(self) -> str:
        """Description with the unit."""
        return self.description.replace("[]", f"[{self.unit}]")


def typeset(unit: str) -> str:
    """A unit with superscript powers."""
    return unit.replace("^2", "²").replace("^3", "³")


@dataclass(frozen=True, slots=True)
class Term:
    """A load, or a kind of damping.

    name: where terms are listed; table: of [loads] in a scene; label: in words; symbol: of its size
    as a force; kind: what it acts on; description: a phrase for the tables of keys; colours:
    of its arrows, on white and on black; follows: a force that turns with the rod; thesis: one of
    the thesis's terms, which a structure has that names none; placed: a scene may have several,
    each on a point of its own, by default the tail; given: the numbers of its table, where those of
    the module are others; array: a scene has an array of its tables; kinked: damping without a
    linear part about a rest that is bent; at_joints: it is placed on joints alone.
    """

    name: str
    table: str
    label: str
    symbol: str
    kind: str
    description: str
    _: KW_ONLY
    parameters: tuple[Parameter, ...]
    colours: tuple[str, str] = ("#475569", "#cbd5e1")
    follows: bool = False
    thesis: bool = False
    placed: bool = False
    given: tuple[Parameter, ...] = ()
    array: bool = False
    kinked: bool = False
    at_joints: bool = False

    @property
    def options(self) -> tuple[str, ...]:
        """Keys of its optional parameters."""
        return tuple(dict.fromkeys(one.option for one in self.parameters if one.optional))

    @property
    def words(self) -> str:
        """The name as words."""
        return self.name.replace("_", " ")

    @property
    def base_name(self) -> str:
        """Name without a number: of the first load of this kind."""
        found = NUMBERED.fullmatch(self.name)
        return found[1] if found and self.is_several else self.name

    @property
    def is_several(self) -> bool:
        """Whether a scene may have several."""
        return self.placed or self.kind == CONTACT

    @property
    def follows_velocity(self) -> bool:
        """Whether it is a force by the velocities of joints and points."""
        return self.kind in (DRAG, AIR)

    @property
    def is_damping(self) -> bool:
        """Whether it takes energy wherever something moves."""
        return self.kind in (DAMPER, DRAG)

    @property
    def is_conservative(self) -> bool:
        """Whether it has a potential while its parameters do not change."""
        return self.kind in (WEIGHT, COUPLE)

    @property
    def is_load(self) -> bool:
        """Whether it is a table of [loads]; others follow from tables of their own."""
        return self.kind not in (ANCHOR, BASE, CONTACT)

    @property
    def holds_joints(self) -> bool:
        """Whether it acts by where joints are."""
        return self.kind == ANCHOR or (self.kind == CONTACT and not self.at_joints)

    @property
    def size_parameters(self) -> tuple[Parameter, ...]:
        """Parameters with which the load grows in proportion; several are its components."""
        return tuple(one for one in self.parameters if one.scales)

    @property
    def scaling_parameters(self) -> tuple[Parameter, ...]:
        """Parameters that its force is in proportion to: its sizes, or the coefficients of drag."""
        if self.kind == AIR:  # of a product, one factor
            return tuple(p for p in self.parameters if p.key == "area")
        of_drag = self.kind == DRAG
        return tuple(p for p in self.parameters if p.scales or (of_drag and p.rule == NOT_NEGATIVE))

    def parameters_with(self, keys: str) -> tuple[Parameter, ...]:
        """Parameters of the load in a module, with the optional ones of some keys: "x+y"."""
        given = keys.split("+")
        return tuple(one for one in self.parameters if one.is_there(given))

    @property
    def initial_table(self) -> dict[str, Any]:
        """Initial table of a load that is added to a scene, without parameters of every joint,
        those that have no initial value, and optional ones without a first value."""
        found: dict[str, Any] = {}
        for one in self.given or self.parameters:
            unasked = (one.optional or one.computed) and one.first is None
            if one.table or one.initial_value is None or one.each == JOINTS or unasked:
                continue
            if one.part is not None:
                found.setdefault(one.key, []).append(one.initial_value)
            else:
                found[one.key] = one.initial_value
        return found

    def with_number(self, number: int) -> Term:
        """Row of the load of this kind that has this number in a scene."""
        return replace(
            self,
            name=f"{self.name}_{number}",
            label=f"{self.label} {number}",
            symbol=f"{self.symbol}{number}",
            parameters=tuple(self._parameter_with_number(number, one) for one in self.parameters),
        )

    def _parameter_with_number(self, number: int, one: Parameter) -> Parameter:
        if one.is_shared:
            return one
        return replace(
            one,
            name=one.name.replace(self.name, f"{self.name}_{number}", 1),
            label=f"{one.label} {number}",
            symbol=f"{one.symbol}{number}" if one.symbol else "",
        )

    @property
    def is_distributed(self) -> bool:
        """Whether it is given per length, for every link by itself."""
        return self.kind == SPREAD

    @property
    def has_size(self) -> bool:
        """Whether it grows with one number."""
        return len(self.size_parameters) == 1 and not self.is_distributed


BY_HEIGHT = "_by_height"  # behind the key of a number that follows the height of a load's place
NUMBERED = re.compile(r"([a-z_]+?)_([2-9]|[1-9][0-9]{1,3})(?:_([a-z_]+))?")
Row = TypeVar("Row")


class NumberedRows(dict[str, Row]):
    """Rows by name; ``made`` makes the row of a further placed load from the name of the first, its
    number, and the rest of the name."""

    def __init__(self, rows: dict[str, Row], made: Callable[[str, int, str], Row | None]):
        super().__init__(rows)
        self._made = made

    def __missing__(self, name: str) -> Row:
        row = self._make_row(name)
        if row is None:
            raise KeyError(name)
        return row

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or (
            isinstance(name, str) and self._make_row(name) is not None
        )

    def _make_row(self, name: str) -> Row | None:
        found = NUMBERED.fullmatch(name)
        return self._made(found[1], int(found[2]), found[3] or "") if found else None
