"""A parameter of a rod, of its boundary or of a load: its names, unit, limits and default."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

ANY, NOT_NEGATIVE, POSITIVE = "any", "at least 0", "positive"
# What a parameter of several numbers has one for: see Structure.spans.
JOINTS, LINKS, SPRINGS = "joint", "link", "joint with a spring"
ROWS = "row of a table, its knots first"


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that a generated module takes, or one for every joint or link.

    name: in the module; key: in its table of a scene; label: in words; symbol: its letter;
    unit: with powers as in "m/s^2"; description: a phrase in which "[]" stands for the unit;
    rule: which values are allowed; default: None where a scene has to give it; first: its value
    in a load that is switched on in the live view, where that is not the default.

    part: which of the numbers of its key it is, where that has two; timed: a scene may give it as a
    function of time; each: what it has a number, or two, for each of, JOINTS, LINKS, SPRINGS or
    ROWS, where it is several; scales: the load is in proportion to it; decades: a slider moves over
    powers of ten; most: the largest value that it may have; fixed: another value needs another
    module; links_power: for one and the same rod it grows as this power of the number of links;
    by_mass: its effect is in proportion to the mass of the links at the start of the span.
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
    links_power: int = 0
    by_mass: bool = False

    @property
    def key_path(self) -> tuple[str, ...]:
        """Path of keys in its table of a scene."""
        return (self.key,) if self.part is None else (self.key, str(self.part))

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
    return unit.replace("^2", "²")
