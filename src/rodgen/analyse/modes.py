"""Natural frequencies and mode shapes of the linearised scene."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.balance import free_ways
from rodgen.analyse.eigen import MOST_DENSE, Values, all_values, lowest_values, refined
from rodgen.analyse.guard import guarded
from rodgen.analyse.modal import CRUDE, ROUNDING
from rodgen.analyse.pencil import Dense, Pencil
from rodgen.analyse.sizes import MODES, check_size
from rodgen.analyse.state_result import TIME, StateResult
from rodgen.analyse.steady import Steady, linearised, steady
from rodgen.analyse.steady_rod import SteadyRod, state_after
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import InputError
from rodgen.progress import tell
from rodgen.result import ASKED, FLAG, Kept, Note, Row, doubt, hidden, remarks
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_notes
from rodgen.scene.plain import plain
from rodgen.system import System

DENSE = 24  # links up to which all eigenvalues are computed; the lowest alone beyond
FARTHEST = 16  # times the asked count of eigenvalues are looked at beyond MOST_DENSE links
STILL = 1e-7  # of the modulus: a real part below it is rounding
GONE = 2 * np.pi / np.log(1e16)  # of the decay: a slower oscillation is rounding after a period
SLACK = "rod.spring has no slope above 0 at d = 0: nothing resists a small bend of the straight rod"
NAMED = 3  # frequencies in a line of text
NUDGE = 1e-6  # rad, of the differences by which shapes are drawn: errors are its square


SOME = Kept(usual=True, several=4)
RIGID_WAYS = "", " (turning)", " (moving along and across)", " (moving and turning)"


def _if_damped(found: Modes) -> str | None:
    """Leave a column out where nothing grows or dies away."""
    return "" if found.growth.any() else None


@dataclass(frozen=True, repr=False)
class Modes(StateResult, Plottable):
    """Small motions about a steady state, y = Re(shape exp(s t)), by ascending frequency.

    frequencies: (k,) [Hz], Im s / 2 pi; growth: (k,) [1/s], Re s, negative for what dies away;
    phi: (k, n), shapes as angles of the links; displacements: (k, n+1, 2), shapes as displacements
    of the joints, the largest 1, complex with damping or growth; state: the steady state; rigid:
    number of motions of the rod as a whole without frequency, which are left out; overdamped:
    number of computed motions without frequency, which are left out too; joints: (n+1, 2), places
    in the steady state [m]; speed: of a free rod along its axis, nose first [m/s]; notes: which
    motions grow, what to know about the speed, and about damping that depends on the number of
    links; system: what vibrates, with the loads of one time.

    Examples
    --------
    >>> import rodgen
    >>> modes = rodgen.natural_modes(rodgen.Scene.example("becks_column"), count=3)
    >>> modes.frequencies.shape, modes.phi.shape, bool((modes.growth > 0).any())
    ((3,), (3, 50), False)
    """

    frequencies: Array
    growth: Array
    phi: NDArray[Any]
    displacements: NDArray[Any]
    joints: Array
    state: str
    rigid: int
    overdamped: int
    speed: float = 0.0
    notes: tuple[Note, ...] = ()
    system: System = field(kw_only=True, compare=False)

    ROWS = (
        Row("frequencies", "frequency", "Hz", along="mode", kept=SOME),
        Row("periods", "period", "s", ".6g", along="mode"),
        Row("growth", "growth", "1/s", ".6g", along="mode", kept=SOME, text=_if_damped),
        Row("damping_ratios", "damping ratio", "", ".6g", along="mode", text=_if_damped),
        Row("largest_growth", "largest growth", "1/s", kept=ASKED, text=hidden),
        Row("stable", "stable", kept=FLAG),
        Row("state", "state"),
        Row("rigid", "left out", text=lambda found: found._left_out),
        Row("overdamped", "overdamped motions", text=hidden),
        Row("speed", "speed", "m/s", text=hidden),
        *TIME,
    )

    @property
    def periods(self) -> Array:
        """Periods (k,) [s], infinite without oscillation."""
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.frequencies)

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios (k,), dimensionless: -Re s over the modulus of s, negative for what grows,
        not-a-number without oscillation."""
        modulus = np.hypot(self.growth, 2 * np.pi * self.frequencies)
        turns = self.frequencies > 0
        return np.where(turns, 0.0 - self.growth / np.where(turns, modulus, 1.0), np.nan)

    @property
    def largest_growth(self) -> float:
        """Growth of the motion that grows most [1/s], negative infinity if there is none."""
        return float(self.growth.max(initial=-np.inf))

    @property
    def stable(self) -> bool:
        """Whether no motion grows."""
        return self.largest_growth <= 0

    @property
    def _left_out(self) -> str:
        """Motions without a frequency, in words."""
        s = "s" * (self.rigid != 1)
        words = f"{self.rigid or 'no'} rigid-body motion{s}{RIGID_WAYS[self.rigid]}"
        if not self.overdamped:
            return words
        plural = "s" * (self.overdamped != 1)
        return f"{words}, {self.overdamped} overdamped motion{plural} among those computed"

    def __repr__(self) -> str:
        count, growing = len(self.frequencies), int((self.growth > 0).sum())
        span = ", ".join(f"{f:.5g}" for f in self.frequencies[:NAMED])
        more = ", ..." if count > NAMED else ""
        grow = f"; {growing} grow" if growing else ""
        found = f"{count}, {span}{more} Hz" if count else "none"
        return f"<Modes of {self.scene.name}: {found}, {self.state}{grow}>"


@guarded
def natural_modes(
    system: System | Scene,
    count: int = 10,
    *,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
) -> Modes:
    """Return the lowest natural frequencies and mode shapes of a scene about its steady state.

    The steady state is straight and at rest, in static equilibrium, or straight and steadily
    accelerating under its thrust. All eigenvalues are computed for up to 24 links, if a third or
    more are asked for, with external damping, and with internal damping for up to 500 links.
    Otherwise those of smallest modulus are computed by sparse shift-invert, in O(n). With much
    damping and more than 500 links, there may be fewer than ``count``, and a motion of large
    modulus but low frequency may be missed. Motions that grow are always found. A motion that dies
    away within a period counts as overdamped.

    Parameters
    ----------
    system
        The scene, or a System.
    count
        Largest number of modes, from the lowest on. All that grow are added.
    t
        Time whose loads are taken [s]; by default the start of the span.
    speed
        Speed of a free rod along its axis, nose first [m/s], taken as constant. By default it is
        the part of the scene's initial velocity along the axis.
    after
        Take loads, speed and direction from a run of the scene after this time [s].

    Returns
    -------
    Modes
        Frequencies (k,) [Hz], growth (k,) [1/s] and shapes, by ascending frequency.

    Raises
    ------
    InputError
        For values that cannot be used.
    AnalysisError
        If there is no steady state.

    Examples
    --------
    Beck's column at 75 N, near the force at which its first two frequencies meet:

    >>> import rodgen
    >>> modes = rodgen.natural_modes(rodgen.Scene.example("becks_column"), count=3)
    >>> modes.frequencies.round(3)
    array([0.276, 0.432, 1.725])
    """
    count = plain(count, "count")
    if not isinstance(count, int) or count < 1:
        raise InputError("count", count, "a whole number of at least 1")
    system = System.of(system)
    check_size(MODES, system, count=count, few=max(DENSE, 3 * count))
    system, t = state_after(system, t, speed, after)
    rod = SteadyRod.of(system, t, speed)
    return modes_about(steady(rod), count)


def modes_about(state: Steady, count: int) -> Modes:
    """The lowest natural frequencies and mode shapes about a steady state, ``count`` at most."""
    rod = state.rod
    pencil = state.dense(whole=True) if rod.steered else linearised(state)
    found = _found(state, pencil, count)
    s, vectors = found.s, found.vectors
    moves, kept = _oscillating(s, count)
    phi, moved = _shapes(state, s[kept], vectors[:, kept].T)
    growth = s.real[kept]
    least = 0.0 if pencil.damped else STILL * np.abs(s[kept])
    rounded = CRUDE * ROUNDING * np.abs(s).max(initial=0.0)
    real = (np.abs(growth) > least) & ((growth < 0) | (growth > rounded))
    growth = np.where(real, growth, 0.0)
    return Modes(
        frequencies=s[kept].imag / (2 * np.pi),
        growth=growth,
        phi=phi,
        displacements=moved,
        joints=rod.model.joints(rod.at_rest(state.at), state.p),
        state=state.words,
        rigid=_rigid(state),
        overdamped=int((~moves & (s.real < 0)).sum()),
        speed=rod.speed,
        notes=(
            *_unstable(growth),
            *state.notes,
            *remarks(mesh_notes(rod.scene) + (SLACK,) * rod.scene.slack),
        ),
        system=rod.system,
    )


def _unstable(growth: Array) -> Iterator[Note]:
    """The doubt about a state about which motions grow."""
    numbers = [str(k + 1) for k in np.flatnonzero(growth > 0)]
    if numbers:
        which = f"mode {numbers[0]} grows"
        if len(numbers) > 1:
            which = f"modes {', '.join(numbers[:-1])} and {numbers[-1]} grow"
        yield doubt(f"this state is unstable: {which}", growth=float(growth.max()))


def _found(state: Steady, pencil: Pencil | Dense, count: int) -> Values:
    """All eigenvalues, or enough of them."""
    cells, turns = state.rod.cells, state.turns_freely
    tell("looking for eigenvalues")
    if isinstance(pencil, Dense):
        return all_values(pencil)
    if cells <= max(DENSE, 3 * count) or (pencil.damped and cells <= MOST_DENSE):
        found = all_values(pencil, turns)
        return refined(pencil, found, _oscillating(found.s, count)[1]) if cells > DENSE else found
    asked = count
    while True:
        found = lowest_values(pencil, asked, state.turning if turns else None)
        if len(_oscillating(found.s, count)[1]) >= count or asked >= FARTHEST * count:
            return found
        asked *= 2  # overdamped motions have taken the places


def _oscillating(s: NDArray[Any], count: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Which eigenvalues oscillate before they have died away; the numbers of the lowest ``count``
    of them and of all that grow, by frequency."""
    moves = s.imag > np.maximum(STILL * np.abs(s), -GONE * s.real)
    grows = s.real > STILL * np.abs(s)
    kept = np.flatnonzero(moves | grows)
    kept = kept[np.argsort(s[kept].imag, kind="stable")]
    return moves, kept[(np.arange(len(kept)) < count) | grows[kept]]


def _rigid(state: Steady) -> int:
    """Motions that move or turn the rod as a whole, without a frequency."""
    rod = state.rod
    if rod.base and rod.anchored:
        return len(free_ways(rod, state.at, state.p))
    return rod.base + state.turns_freely


def _shapes(
    state: Steady, s: NDArray[Any], vectors: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles (k, n) and displacements (k, n+1, 2) of modes from their vectors (k, coordinates):
    those of the angles, or before them the displacement of joint 0 across the rod."""
    rod, across = state.rod, vectors[:, : -state.rod.cells]
    q = np.zeros((len(s), rod.base + rod.cells), dtype=complex)
    q[:, rod.base :] = vectors[:, -rod.cells :]
    if across.shape[1] == 1:
        across = across * [-np.sin(state.phi[0]), np.cos(state.phi[0])]
    if across.size:
        q[:, :2] = across
    q /= np.abs(q).max(axis=1, keepdims=True)
    if rod.base and not across.size:
        q[:, :2] = _base(state, s, q)
    parts = [_displaced(state, part) for part in (q.real, q.imag)]
    moved = parts[0] + 1j * parts[1]
    flat = moved.reshape(len(s), moved[0].size if len(s) else 1)
    at = np.abs(flat).argmax(axis=1)
    largest = flat[np.arange(len(s)), at][:, None]
    phi = rod.all_links(q[:, rod.base :])
    phi[:, : rod.scene.held] = 0.0
    phi, moved = phi / largest, moved / largest[..., None]
    real = np.abs(phi.imag).max(initial=0.0) <= 1e3 * STILL * np.abs(phi).max(initial=0.0)
    return (phi.real, moved.real) if real else (phi, moved)


def _base(state: Steady, s: NDArray[Any], q: NDArray[Any]) -> NDArray[Any]:
    """Displacements (k, 2) of joint 0 that go with the angles: its acceleration over s^2."""
    rod, y = state.rod, state.rod.flying(state.at)
    base = np.zeros((len(s), 2), dtype=complex)
    for at, (rate, shape) in enumerate(zip(s, q, strict=True)):
        change = np.concatenate((shape, np.zeros_like(shape)))
        # Rates are small and their effect linear: internal damping.
        change[len(shape) :] = rate * shape
        for unit, part in ((1.0, change.real), (1j, change.imag)):
            up, down = (rod.rates(y + sign * NUDGE * part, state.p) for sign in (1, -1))
            base[at] += unit * (up - down)[:2] / (2 * NUDGE * rate**2)
    return base


def _displaced(state: Steady, q: Array) -> Array:
    """Displacements (k, n+1, 2) of the joints for coordinates (k, coordinates)."""
    rod = state.rod
    y = np.tile(rod.at_rest(state.at), (len(q), 1))
    y[:, : q.shape[1]] += NUDGE * q
    up = rod.model.joints(y, state.p)
    y[:, : q.shape[1]] -= 2 * NUDGE * q
    moved: Array = (up - rod.model.joints(y, state.p)) / (2 * NUDGE)
    return moved
