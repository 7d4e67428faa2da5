"""A value along the rod: a number, one for every joint or link, or an expression in s and t."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.scene.bounds import Field, find_out_of_bounds, with_neighbours, zeros_on_grid
from rodgen.scene.expression import Difference, Expression, parse_expression
from rodgen.scene.expression_text import Numbers
from rodgen.scene.rod_mesh import POINTS, RodMesh, cell_means

Along = float | list[float] | str  # a number, values along the rod, or an expression in s
GRID = np.linspace(0.0, 1.0, 1001)  # where an expression is looked at besides
MOMENTS = 201  # of the span at which one in t is looked at
CELLS = 40  # at whose points one in s and t is looked at, of a rod that has as many links
STAGES = 21  # times of the span at which a pole along the rod is looked for
SOME = 0.0, 0.5, 1.0  # s at which a divisor that changes with time is looked at
MOST_CORNERS = 50  # functions whose zeros are corners along the rod
BREAKS = 10_000  # at both sides of which an expression in t is looked at; of more, at some


@dataclass(frozen=True)
class Law:
    """A value along a rod: a number, one for every joint or link, or an expression; numbers: values
    of the names in expressions; variables: those that these may have, of s and t."""

    value: Along
    field: str
    numbers: Numbers = ()
    variables: str = "s"

    @property
    def uniform_value(self) -> float | None:
        """Value of the law, if constant along the rod and in time; else None."""
        if isinstance(self.value, str):
            found = self.expression
            return float(found(0.0)) if found.is_constant else None
        return None if isinstance(self.value, list) else self.value

    @property
    def is_time_dependent(self) -> bool:
        """Whether it is a function of time."""
        is_timed = isinstance(self.value, str) and "t" in self.variables
        return is_timed and self.expression.has_variable

    def check(
        self, mesh: RodMesh, count: int, least: float = 0.0, span: Sequence[float] = (0.0, 0.0)
    ) -> None:
        """Raise InputError for a list of another length than `count`, and for an expression that is
        not finite or below `least` at some s and some time of the span."""
        if isinstance(self.value, list) and len(self.value) != count:
            what = "joint" if count > mesh.links else "link"
            allowed = f"a list of {count} values, one for every {what}"
            raise InputError(self.field, self.value, allowed)
        if not isinstance(self.value, str):
            return
        wrong = _describe_violation(self, mesh, (span[0], span[1]), least)
        if wrong:
            limit = {0.0: " and at least 0", -np.inf: ""}.get(least, " and above 0")
            raise InputError(self.field, self.value, f"finite{limit} {wrong}")

    def check_poles(self, span: Sequence[float]) -> None:
        """Raise InputError for an expression with a pole at some s of the rod. One that is infinite
        all along the rod at some time is left alone: it ends a run there."""
        if isinstance(self.value, str) and "s" in self.variables:
            found = _first_pole_along(self, (span[0], span[1]))
            if found is not None:
                when = f" and t = {found[0]:.6g}" if self.is_time_dependent else ""
                allowed = f"finite all along the rod (it has a pole at s = {found[1]:.6g}{when})"
                raise InputError(self.field, self.value, allowed)

    def at(self, places: Array, t: float = 0.0) -> Array:
        """Values at places s and a time t; not of a list."""
        given: object = self.value
        if isinstance(self.value, str) and self.variables == "s":
            given = self.expression(places)
        elif isinstance(self.value, str):
            given = self.expression.evaluate(np.asarray(t, dtype=float), {"s": places})
        return np.broadcast_to(np.asarray(given, dtype=float), places.shape)

    def link_values(self, mesh: RodMesh, t: float = 0.0) -> list[float]:
        """Value of every link: its own, or the mean. Raises InputError where a value that is summed
        up is not finite."""
        if isinstance(self.value, list):
            return self.value
        if not isinstance(self.value, str):
            return [self.value] * mesh.links
        places = mesh.gauss_points()
        values = self.at(places, t)
        wrong = ~np.isfinite(values)
        if wrong.any():
            allowed = f"finite all along the rod (not as at s = {places[wrong][0]:.6g})"
            raise InputError(self.field, self.value, allowed)
        return [float(mean) for mean in self._link_means(mesh, values, t)]

    def _link_means(self, mesh: RodMesh, values: Array, t: float) -> Array:
        """Means over the links from values at their Gauss points; of a link in which the law has
        corners, over the parts between these."""
        means = cell_means(values)
        if self.is_time_dependent:
            return means
        corners, joints = _corners(str(self.value), self.field, self.numbers), mesh.places
        on = np.searchsorted(joints, corners) - 1
        for link in np.unique(on):
            ends = np.array([joints[link], *corners[on == link], joints[link + 1]])
            parts = np.diff(ends)[:, None]
            inside = self.at(ends[:-1, None] + parts * POINTS, t)
            means[link] = parts[:, 0] @ cell_means(inside) / parts.sum()
        return means

    @property
    def expression(self) -> Expression:
        """The expression of a value that is text."""
        assert isinstance(self.value, str)
        return _parse(self.value, self.field, self.numbers, self.variables)


def _parse(text: str, field: str, numbers: Numbers, variables: str) -> Expression:
    """Parse an expression in s, in t or in both."""
    if variables == "s":
        return parse_expression(text, "s", field, numbers)
    found = parse_expression(text, "t", field, numbers, ("s",) if "s" in variables else None)
    if found.sensors:
        allowed = "an expression that no sensor is in: it does not follow the motion"
        raise InputError(field, text, allowed)
    return found


@lru_cache(maxsize=64)
def _corners(text: str, field: str, numbers: Numbers) -> Array:
    """Places inside the rod where an expression in s has corners; knots of tables alone, of one
    that may have more than are worth to be looked for."""
    e = _parse(text, field, numbers, "s")
    few = len(e.corners()) <= MOST_CORNERS
    found = e.breaks(0.0, 1.0) if few else [s for s in e.knots() if 0 < s < 1]
    return np.array(found, dtype=float)


@lru_cache(maxsize=64)
def _describe_violation(law: Law, mesh: RodMesh, span: tuple[float, float], least: float) -> str:
    """Words on where and when an expression is not finite or below `least`; empty if never."""
    times, places = _sample_times(law, span), _sample_places(law, mesh, span)
    found = find_out_of_bounds(_as_field(law, law.expression.evaluate), times, places, least)
    found = found or next(_find_poles(law, span), None)
    if found is None:
        return ""
    t, s, value = found
    at = f"s = {s:.6g}" if "s" in law.variables else ""
    when = f"t = {t:.6g}" if law.is_time_dependent else ""
    where = " and ".join(filter(None, (at, when)))
    everywhere = "all along the rod" if "s" in law.variables else "all the time"
    return f"{everywhere} (not {value:g}, as at {where})"


def _find_poles(law: Law, span: tuple[float, float]) -> Iterator[tuple[float, ...]]:
    """Yield time, place and value, which is infinite, of poles of an expression."""
    e = law.expression
    if not e.open_divisors():
        return
    if "s" in law.variables and (along := _first_pole_along(law, span)):
        yield (*along, np.inf)
    if law.variables != "s" and law.is_time_dependent:
        for s in SOME:
            there = replace(e, states=None, numbers=(*e.numbers, ("s", s)))
            yield from ((t, s, np.inf) for t in there.poles(*span))


@lru_cache(maxsize=64)
def _first_pole_along(law: Law, span: tuple[float, float]) -> tuple[float, float] | None:
    """First sampled time at which an expression has a pole along the rod, and its place, if any."""
    e = law.expression
    if not e.divisors():
        return None
    times = np.linspace(*span, STAGES) if law.is_time_dependent else np.array(span[:1])
    for t in times.tolist():
        try:
            alone, known = law.variables == "s", (*e.numbers, ("t", t))
            there = e if alone else replace(e, variable="s", states=None, numbers=known)
        except InputError:  # all along the rod, where it stops a run
            continue
        if found := there.poles(0.0, 1.0):
            return t, found[0]
    return None


def _as_field(law: Law, of: Difference) -> Field:
    """An expression, or a difference or a divisor of it, as a function of times and places."""
    return (lambda _, s: of(s, {})) if law.variables == "s" else (lambda t, s: of(t, {"s": s}))


def _sample_times(law: Law, span: tuple[float, float]) -> Array:
    """Times at which an expression is sampled."""
    if not law.is_time_dependent:
        return np.array(span[:1])
    e, grid = law.expression, np.linspace(*span, MOMENTS)
    fields = [_as_field(law, one) for one in e.open_divisors()]
    poles = (lambda t, of=of, s=s: of(t, s) for of in fields for s in SOME)
    breaks = e.breaks(*span)
    found = {*breaks[:: len(breaks) // BREAKS + 1], *zeros_on_grid(poles, grid)}
    return np.unique(np.concatenate((grid, with_neighbours(found, *span))))


def _sample_places(law: Law, mesh: RodMesh, span: tuple[float, float]) -> Array:
    """Places at which an expression is sampled, those at which links sum it up among them."""
    if "s" not in law.variables:
        return np.zeros(1)
    grid, summed = GRID, mesh.gauss_points_of_halves()
    if law.is_time_dependent:
        grid, summed = GRID[::10], mesh.gauss_points()[:: mesh.links // CELLS + 1]
    e = law.expression
    fields = [_as_field(law, one) for one in (*e.corners().values(), *e.open_divisors())]
    times = {span[0], sum(span) / 2, span[1]} if law.is_time_dependent else {span[0]}
    alone = [partial(of, t) for of in fields for t in times]
    knots = e.knots() if law.variables == "s" else []
    found = with_neighbours([*zeros_on_grid(alone, grid), *knots], 0.0, 1.0)
    return np.unique(np.concatenate((grid, summed.ravel(), found)))
