"""What a study keeps of every point: the texts of `keep`, checked, and the variables they fill.

Of a run: reductions of `rodgen.integrate.reductions`, count('EVENT'), section(tip_y,
where='tip_x', rising=0), peak(tip_y), and functions of a Solution. Of an analysis: what it finds,
by name, with how many of several, such as frequency(4).
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.integrate.equations import Equations, equations_of
from rodgen.integrate.reductions import REDUCTIONS, Numbers, Reduction, parse
from rodgen.loading import build_fastest
from rodgen.model.quantities import ADDED, LOADS, QUANTITIES, number_in, watched
from rodgen.model.terms import PARAMETERS
from rodgen.scene import Scene, SceneError
from rodgen.studies.findings import FINDINGS, Finding
from rodgen.studies.reference import reference

if TYPE_CHECKING:
    from rodgen.integrate import Solution
    from rodgen.studies.specification import Study

RUN = "run"
PARTS = ("rhs", "flow", "power", "lanes")  # of a module, that runs ask for
MOST_POINTS = 1000  # of a section, where no other number is given
LIMIT = 10**6  # of these
MESSAGE = 200  # characters of a message that are kept
EVERY = -math.inf, math.inf

_CALL = re.compile(r"\s*(\w+)\s*(?:\((.*)\))?\s*", re.DOTALL)
_PART = re.compile(r"""\s*(?:(\w+)\s*=\s*)?('[^']*'|"[^"]*"|[^,'"=()]+?)\s*(?:,|$)""")
_OF_A_RUN = (
    f"a reduction of a run: {', '.join(REDUCTIONS)} of a number of a quantity, such as max(phi_0) "
    "or rms(tip_y, from=5), count('name of an event'), section(tip_y, where='tip_x', rising=0) or "
    "peak(tip_y)"
)


@dataclass(frozen=True)
class Variable:
    """An array of results: dims and shape beside those of the points, dtype as NumPy writes it,
    units, and what stands where nothing was found."""

    name: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    dtype: str = "f8"
    units: str = ""
    fill: Any = math.nan


# Of every point, whatever is computed.
ALWAYS = (
    Variable("status", dtype="U8", fill=""),
    Variable("message", dtype=f"U{MESSAGE}", fill=""),
    Variable("energy_error", units="J"),
    Variable("seconds", units="s"),
)


@dataclass(frozen=True)
class Sampled:
    """A reduction of the samples of a run."""

    reduction: Reduction
    units: str

    @property
    def text(self) -> str:
        """As it was asked for."""
        return self.reduction.text

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers that it is made of."""
        return (self.reduction.number,)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The number that it is."""
        return (Variable(self.text, units=self.units),)

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run."""
        values = places.values(solution, self.reduction.number)
        return {self.text: self.reduction.of(solution.t, values)}


@dataclass(frozen=True)
class Count:
    """How often an event of the scene happens between two times [s]."""

    text: str
    event: str
    start: float = EVERY[0]
    end: float = EVERY[1]
    numbers: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The number of times, -1 where there was no run."""
        return (Variable(self.text, dtype="i8", fill=-1),)

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run."""
        found = [one for one in solution.events if one.name == self.event]
        return {self.text: sum(self.start <= one.t <= self.end for one in found)}


@dataclass(frozen=True)
class Section:
    """A number at the times at which another passes a level between two times [s], at most so many
    of them, and these times."""

    text: str
    number: str
    where: str
    level: float
    direction: str
    units: str
    event: str = ""
    most: int = MOST_POINTS
    start: float = EVERY[0]
    end: float = EVERY[1]
    dim: str = "crossing"

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers that it is made of."""
        return (self.number,)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The values and the times, one after the other."""
        beyond = (self.dim,), (self.most,)
        return (
            Variable(self.text, *beyond, units=self.units),
            Variable(f"{self.text}.t", *beyond, units="s"),
        )

    @property
    def table(self) -> dict[str, Any]:
        """The event that a run looks out for."""
        crossing = {"quantity": self.where, "value": self.level, "direction": self.direction}
        return crossing | {"name": self.event}

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run."""
        from rodgen.integrate.catalogue import Piece

        met = [e for e in solution.events if e.name == self.event and self.start <= e.t <= self.end]
        met = met[: self.most]
        made = {name: np.full(self.most, math.nan) for name in (self.text, f"{self.text}.t")}
        if met:
            t, y = np.array([one.t for one in met]), np.array([one.y for one in met])
            p = solution.model.parameters(**solution.scene.parameters)
            timed = solution.scene.timed
            there = Piece(solution.model, p, y, t, timed=timed)
            made[self.text][: len(met)] = places.values(there, self.number)
            made[f"{self.text}.t"][: len(met)] = t
        return made


@dataclass(frozen=True)
class Peak:
    """The highest peak in the spectrum of a number between two times [s]."""

    text: str
    number: str
    units: str
    start: float = EVERY[0]
    end: float = EVERY[1]

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers that it is made of."""
        return (self.number,)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Its frequency and its amplitude."""
        return (
            Variable(f"{self.text}.frequency", units="Hz"),
            Variable(f"{self.text}.amplitude", units=self.units),
        )

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it is of a run; not-a-number where there is no peak. Raises SceneError for samples
        that are not uniform."""
        from rodgen.analyse.errors import AnalysisError
        from rodgen.analyse.fourier import peaks_of

        t, values = solution.t, places.values(solution, self.number)
        inside = (t >= self.start) & (t <= self.end)
        last = int(np.flatnonzero(inside)[-1]) if inside.any() else 0
        if last > 1 and t[last] - t[last - 1] < 0.999 * (t[1] - t[0]):
            inside[last] = False  # the end of the run, between two samples
        try:
            found = peaks_of(t[inside], values[inside], peaks=1)
        except AnalysisError:
            return {f"{self.text}.{part}": math.nan for part in ("frequency", "amplitude")}
        return {
            f"{self.text}.frequency": float(found.frequencies[0]),
            f"{self.text}.amplitude": float(found.amplitudes[0]),
        }


@dataclass(frozen=True)
class Own:
    """A function of a Solution that gives a number."""

    text: str
    function: Callable[[Solution], float] = field(compare=False)
    numbers: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """That number."""
        return (Variable(self.text),)

    def of(self, solution: Solution, places: Numbers) -> dict[str, Any]:
        """What it makes of a run. Raises what it raises; TypeError for what is no number."""
        return {self.text: float(self.function(solution))}


Kept = Sampled | Count | Section | Peak | Own


def variables(study: Study) -> list[Variable]:
    """What the points of a study fill, known before any is computed. Raises SceneError for what
    cannot be kept, and for a study all of whose tried points the scene refuses."""
    if study.what == RUN:
        made = [variable for one in kept(study) for variable in one.variables]
    else:
        made = [variable_of(study, one) for one in found(study)]
    names = [variable.name for variable in (*made, *ALWAYS)]
    for at, name in enumerate(names):
        if name in names[:at]:
            raise SceneError("compute.keep", name, "each thing once")
    return [*made, *ALWAYS]


# Of a run -----------------------------------------------------------------------------------------


@lru_cache(maxsize=8)
def kept(study: Study) -> tuple[Kept, ...]:
    """What is kept of every run. Raises SceneError."""
    if study.options:
        raise SceneError("compute.options", study.options, f"absent: what = {RUN!r} has none")
    if not study.keep:
        raise SceneError("compute.keep", [], "what is kept of every run, such as last(tip_x)")
    scene = study.scene_at(reference(study))
    equations = equations_of(build_fastest(scene, PARTS))
    made: list[Kept] = []
    for at, text in enumerate(study.keep):
        made.append(_kept(f"compute.keep[{at}]", text, scene, equations))
    return tuple(_numbered(made))


def _kept(place: str, text: Any, scene: Scene, equations: Equations) -> Kept:
    """One thing that is kept of a run."""
    if callable(text):
        return Own(getattr(text, "__name__", place).strip("<>"), text)
    if not isinstance(text, str):
        raise SceneError(place, text, "text, or in Python a function of a Solution")
    numbers = equations.numbers
    reduction = parse(text)
    if reduction is not None:
        _check_number(place, text, reduction.number, numbers)
        seconds = reduction.kind == "time_of_max"
        return Sampled(reduction, "s" if seconds else unit_of(reduction.number, numbers))
    kind, arguments, named = _call(place, text, _OF_A_RUN)
    number = arguments[0] if len(arguments) == 1 else ""
    span = _span(place, text, named)
    if kind == "count" and number and not named:
        names = [event.name for event in scene.events]
        if number not in names:
            allowed = f"of an event of the scene: {', '.join(map(repr, names)) or 'it has none'}"
            raise SceneError(place, text, allowed)
        return Count(text, number, *span)
    if kind == "peak" and number and not named:
        _check_number(place, text, number, numbers)
        return Peak(text, number, unit_of(number, numbers), *span)
    if kind == "section" and number:
        _check_number(place, text, number, numbers)
        return _section(place, text, number, named, span, scene, numbers)
    raise SceneError(place, text, _OF_A_RUN)


def _section(
    place: str,
    text: str,
    number: str,
    named: dict[str, str],
    span: tuple[float, float],
    scene: Scene,
    numbers: Numbers,
) -> Section:
    """A section from what is said of it."""
    where, most = named.pop("where", ""), named.pop("most", str(MOST_POINTS))
    known = [*watched(scene.hold, scene.rod.links), *((name, range(1)) for name in scene.states)]
    if not any(number_in(where, name) in range_ for name, range_ in known):
        shown = ", ".join(name for name, _ in known)
        raise SceneError(place, text, f"where = one of {shown}")
    if len(named) != 1 or {*named} - {"rising", "falling", "either"}:
        raise SceneError(place, text, "with one of rising=, falling= or either= the level")
    ((direction, level),) = named.items()
    points = _number(place, text, most)
    if not (points.is_integer() and 0 < points <= LIMIT):
        raise SceneError(place, text, f"with most= a whole number from 1 to {LIMIT}")
    value, units = _number(place, text, level), unit_of(number, numbers)
    return Section(
        text, number, where, value, direction, units, most=int(points), start=span[0], end=span[1]
    )


def _numbered(made: Sequence[Kept]) -> list[Kept]:
    """Sections with events of their own; with dimensions of their own where lengths differ."""
    lengths: list[int] = []
    numbered: list[Kept] = []
    for at, one in enumerate(made):
        if isinstance(one, Section):
            if one.most not in lengths:
                lengths.append(one.most)
            number = lengths.index(one.most)
            dim = f"crossing_{number + 1}" if number else "crossing"
            one = replace(one, event=f"section {at} of the study", dim=dim)
        numbered.append(one)
    return numbered


def _call(place: str, text: str, allowed: str) -> tuple[str, list[str], dict[str, str]]:
    """The name of a call, its arguments without and with names. Raises SceneError."""
    whole = _CALL.fullmatch(text)
    if whole is None:
        raise SceneError(place, text, allowed)
    arguments, named, at, inside = list[str](), dict[str, str](), 0, whole[2] or ""
    while at < len(inside):
        part = _PART.match(inside, at)
        if part is None or (part[1] in named):
            raise SceneError(place, text, allowed)
        value = part[2].strip("'\"") if part[2][0] in "'\"" else part[2]
        if part[1]:
            named[part[1]] = value
        else:
            arguments.append(value)
        at = part.end()
    return whole[1], arguments, named


def _span(place: str, text: str, named: dict[str, str]) -> tuple[float, float]:
    """The times from and to, which are taken out of what is named."""
    start, end = (
        _number(place, text, named.pop(key)) if key in named else value
        for key, value in zip(("from", "to"), EVERY, strict=True)
    )
    if not start <= end:
        raise SceneError(place, text, "with times from <= to")
    return start, end


def _number(place: str, text: str, value: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise SceneError(place, text, f"with a finite number in place of {value!r}")
    return number


def _check_number(place: str, text: str, number: str, numbers: Numbers) -> None:
    if number not in numbers.places:
        shown = dict.fromkeys(re.sub(r"(?<=_)\d+", "{}", name) for name in numbers.places)
        raise SceneError(place, text, f"{_OF_A_RUN}; numbers are {', '.join(shown)}")


def check_numbers(scene: Scene, numbers: Iterable[str], equations: Equations) -> None:
    """Raise SceneError for a number that this rod does not have, though another one of the study
    has it."""
    for number in numbers:
        if number not in equations.numbers.places:
            allowed = f"a number of the rod: one of {scene.rod.links} links has no {number}"
            raise SceneError("compute.keep", number, allowed)


def unit_of(number: str, numbers: Numbers) -> str:
    """The unit of a number of a quantity, by its name."""
    name, _ = numbers.places[number]
    if name in PARAMETERS:
        return PARAMETERS[name].unit
    for quantity in QUANTITIES:
        prefix = quantity.name.removesuffix("{}") if quantity.each else quantity.name
        open_ = quantity.each not in ("", LOADS, ADDED) and name.startswith(prefix)
        if name == quantity.name or open_:
            return quantity.unit
    return "J" if name == "total_work" else ""


# Of an analysis -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Asked:
    """Something that an analysis finds; count: how many of several."""

    text: str
    finding: Finding
    count: int = 0


@lru_cache(maxsize=8)
def found(study: Study) -> tuple[Asked, ...]:
    """What is kept of every point of an analysis. Raises SceneError."""
    rows = FINDINGS[study.what]
    _check_options(study)
    texts = study.keep or tuple(name for name, row in rows.items() if row.usual)
    return tuple(_asked(f"compute.keep[{at}]", text, rows) for at, text in enumerate(texts))


def _asked(place: str, text: Any, rows: Mapping[str, Finding]) -> Asked:
    shown = ", ".join(f"{name}(4)" if row.several else name for name, row in rows.items())
    allowed = f"one of {shown}"
    if not isinstance(text, str):
        raise SceneError(place, text, allowed)
    name, arguments, named = _call(place, text, allowed)
    row = rows.get(name)
    if row is None or named or len(arguments) > (1 if row.several else 0):
        raise SceneError(place, text, allowed)
    count = _number(place, text, arguments[0]) if arguments else float(row.several)
    if not (count.is_integer() and (0 < count <= 1000 or not row.several)):
        raise SceneError(place, text, f"{name}(k) of a whole number k from 1 to 1000")
    return Asked(text, row, int(count))


def variable_of(study: Study, one: Asked) -> Variable:
    """The variable of something that is found."""
    row = one.finding
    if not row.several:
        return Variable(one.text, (), (), row.dtype, row.units, row.fill)
    lengths = list(dict.fromkeys(a.count for a in found(study) if a.finding.several))
    number = lengths.index(one.count)
    dim = f"mode_{number + 1}" if number else "mode"
    return Variable(one.text, (dim,), (one.count,), row.dtype, row.units, row.fill)


def _check_options(study: Study) -> None:
    """Raise SceneError for options that the analysis does not have; what they may be, it checks of
    every point."""
    from rodgen.studies.findings import function_of

    allowed = list(inspect.signature(function_of(study.what)).parameters)[1:]
    for name in study.options:
        if name not in allowed or name == "count":
            known = ", ".join(one for one in allowed if one != "count")
            raise SceneError(f"compute.options.{name}", study.options[name], f"one of {known}")
