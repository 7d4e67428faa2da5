"""Natural frequencies and mode shapes of the linearised scene."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodgen.analyse.analysis_guard import (
    MODES,
    check_analysis_memory,
    check_whole_number,
    guard_analysis,
)
from rodgen.analyse.eigenvalues import (
    MOST_DENSE,
    Complex,
    EigenSolution,
    all_eigenvalues,
    lowest_eigenvalues,
    refine_eigenvalues,
)
from rodgen.analyse.equilibrium_equations import free_directions
from rodgen.analyse.frozen_modes import (
    NUDGE,
    STILL,
    UNSEEN,
    frozen_motions,
    joint_displacements,
    select_modes,
)
from rodgen.analyse.massless import regular_pencil
from rodgen.analyse.modal import CRUDE, ROUNDING
from rodgen.analyse.pencil import BlockPencil, DensePencil
from rodgen.analyse.steady_rod import TIME, StateResult, SteadyRod, state_after
from rodgen.analyse.steady_state import SteadyState, find_steady_state, pencil_about
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import InputError
from rodgen.progress import report_stage
from rodgen.result import ASKED, FLAG, Note, Row, StudyStorage, doubt, omit_from_tables, remarks
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_notes
from rodgen.system import System
from rodgen.system.link_inertia import check_masses

DENSE = 100  # links up to which all eigenvalues take less time than the lowest alone
FARTHEST = 16  # times the asked count of eigenvalues are looked at beyond MOST_DENSE links
SLACK = "rod.spring has no slope above 0 at d = 0: nothing resists a small bend of the straight rod"
NAMED = 3  # frequencies in a line of text

SOME = StudyStorage(usual=True, several=4)
RIGID_WAYS = "", " (turning)", " (moving along and across)", " (moving and turning)"


def _hide_without_growth(found: Modes) -> str | None:
    """Leave a column out where nothing grows or dies away."""
    return "" if found.growth.any() else None


@dataclass(frozen=True, repr=False)
class Modes(StateResult, Plottable):
    """Small motions about a steady state, y = Re(shape exp(s t)), by ascending frequency.

    frequencies: (k,) [Hz], Im s / 2 pi; growth: (k,) [1/s], Re s, negative for what dies away;
    phi: (k, n), shapes as angles of the links; displacements: (k, n+1, 2), shapes as displacements
    of the joints, the largest 1, complex with damping or growth; state: the steady state; rigid:
    number of motions of the rod as a whole without frequency, which are left out; overdamped:
    number of computed motions without oscillation, which are left out too; joints: (n+1, 2), places
    in the steady state [m]; speed: of a free rod along its axis, nose first [m/s]; notes: which
    motions grow, what to know about the speed, and about damping that depends on the number of
    links; system: the rod, with the loads of one time.

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
        Row("growth", "growth", "1/s", ".6g", along="mode", kept=SOME, text=_hide_without_growth),
        Row("damping_ratios", "damping ratio", "", ".6g", along="mode", text=_hide_without_growth),
        Row("largest_growth", "largest growth", "1/s", kept=ASKED, text=omit_from_tables),
        Row("stable", "stable", kept=FLAG),
        Row("state", "state"),
        Row("rigid", "left out", text=lambda found: found._rigid_text),
        Row("overdamped", "overdamped motions", text=omit_from_tables),
        Row("speed", "speed", "m/s", text=omit_from_tables),
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
    def _rigid_text(self) -> str:
        """Description of the motions without a frequency."""
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


@guard_analysis
def natural_modes(
    system: System | Scene,
    count: int = 10,
    *,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
    frozen: bool = False,
) -> Modes:
    """Return the lowest natural frequencies and mode shapes of a scene about its steady state.

    The steady state is straight and at rest, in static equilibrium, or straight and steadily
    accelerating under its thrust; a rod that is bent at rest is so instead of straight. All
    eigenvalues are computed for up to 100 links, if a third or more are asked for, with external
    damping, and with internal damping for up to 500 links. Otherwise those of smallest modulus are
    computed by sparse shift-invert, in O(n). With much damping and more than 500 links, there may
    be fewer than ``count``, and a motion of large modulus but low frequency may be missed. Motions
    that grow are always found. A motion that dies away within a period counts as overdamped.

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
    frozen
        Take the shape at the start, or after a run (``after``), as if the rod stood still in it;
        forces that drive it away from there are left out. All eigenvalues are computed.

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
    count = check_whole_number(count, "count", 1)
    system = System.of(system)
    few = system.structure.n_links if frozen else max(DENSE, 3 * count)
    check_analysis_memory(MODES, system, count=count, few=few)
    if frozen:
        check_masses(system)
    if frozen and speed is not None:
        raise InputError("speed", speed, "absent: the rod is taken to stand still (frozen)")
    system, t = state_after(system, t, speed, after)
    rod = SteadyRod.of(system, t, speed)
    if frozen:
        return _modes_about_shape(rod, count)
    return modes_about(find_steady_state(rod), count)


def modes_about(state: SteadyState, count: int) -> Modes:
    """Compute the lowest natural frequencies and mode shapes about a steady state."""
    rod = state.rod
    reduced = None
    if rod.is_light:
        reduced = regular_pencil(state.dense_pencil(whole=rod.has_feedback))
        pencil: BlockPencil | DensePencil = reduced.pencil
    else:
        pencil = state.dense_pencil(whole=True) if rod.has_feedback else pencil_about(state)
    found = _find_eigenvalues(state, pencil, count)
    s, vectors = found.s, found.vectors
    if reduced is not None:
        vectors = reduced.expand(s, vectors)
    moves, kept = select_modes(s, count)
    phi, moved = _mode_shapes(state, s[kept], vectors[:, kept].T)
    rounded = CRUDE * ROUNDING * np.abs(s).max(initial=0.0)
    growth = _without_rounding(s[kept], 0.0 if pencil.is_damped else STILL, rounded)
    return Modes(
        frequencies=s[kept].imag / (2 * np.pi),
        growth=growth,
        phi=phi,
        displacements=moved,
        joints=rod.model.joints(rod.state_at_rest(state.at), state.p),
        state=state.description,
        rigid=_count_rigid(state),
        overdamped=int((~moves & (s.real < 0)).sum()),
        speed=rod.speed,
        notes=(
            *_instability_doubts(growth),
            *state.notes,
            *remarks(mesh_notes(rod.scene) + (SLACK,) * rod.scene.has_no_tangent_stiffness),
        ),
        system=rod.system,
    )


def _modes_about_shape(rod: SteadyRod, count: int) -> Modes:
    """Compute modes about the positions of the initial state, as if the rod stood still there."""
    y, p = rod.system.y0, rod.system.p
    span = float(np.ptp(rod.system.settings.span))
    found = frozen_motions(rod.model, rod.t, y, p, count, span)
    growth = _without_rounding(found.s, STILL, 0.0)
    phi, moved = _real_shapes(rod, found.q, found.displacements)
    turning = float(np.abs(found.accelerations[rod.n_base :]).max())  # falling changes no shape
    moves = turning > max(STILL * np.abs(found.s).max(initial=0.0) ** 2, UNSEEN / span**2)
    at = f"of up to {turning:.3g} rad/s^2 are left out"
    return Modes(
        frequencies=found.s.imag / (2 * np.pi),
        growth=growth,
        phi=phi,
        displacements=moved,
        joints=rod.model.joints(y, p),
        state=f"the shape at t = {rod.t:g} s, taken to stand still",
        rigid=min(found.still, rod.n_base + (not rod.is_clamped)),  # of a chain more stand still
        overdamped=found.overdamped,
        notes=(
            *_instability_doubts(growth),
            *remarks((f"the rod is not at rest in this shape: accelerations {at}",) * bool(moves)),
            *remarks(mesh_notes(rod.scene)),
        ),
        system=rod.system,
    )


def _without_rounding(s: Complex, least: float, rounded: float) -> Array:
    """Growth (k,) of eigenvalues [1/s], zero below their moduli times ``least``, and what grows by
    less than ``rounded``."""
    growth: Array = s.real
    real = (np.abs(growth) > least * np.abs(s)) & ((growth < 0) | (growth > rounded))
    return np.where(real, growth, 0.0)


def _instability_doubts(growth: Array) -> Iterator[Note]:
    """Yield the doubt about a state about which motions grow."""
    numbers = [str(k + 1) for k in np.flatnonzero(growth > 0)]
    if numbers:
        which = f"mode {numbers[0]} grows"
        if len(numbers) > 1:
            which = f"modes {', '.join(numbers[:-1])} and {numbers[-1]} grow"
        yield doubt(f"this state is unstable: {which}", growth=float(growth.max()))


def _find_eigenvalues(
    state: SteadyState, pencil: BlockPencil | DensePencil, count: int
) -> EigenSolution:
    """Compute all eigenvalues, or enough of the lowest."""
    n_moving, turns = state.rod.n_moving, state.has_free_rotation
    report_stage("looking for eigenvalues")
    if isinstance(pencil, DensePencil):
        return all_eigenvalues(pencil)
    if n_moving <= max(DENSE, 3 * count) or (pencil.is_damped and n_moving <= MOST_DENSE):
        found = all_eigenvalues(pencil, turns)
        return (
            refine_eigenvalues(pencil, found, select_modes(found.s, count)[1])
            if n_moving > DENSE
            else found
        )
    asked = count
    while True:
        found = lowest_eigenvalues(pencil, asked, state.free_rotation)
        if len(select_modes(found.s, count)[1]) >= count or asked >= FARTHEST * count:
            return found
        asked *= 2  # overdamped motions have taken the places


def _count_rigid(state: SteadyState) -> int:
    """Number of motions without frequency that move or turn the rod as a whole."""
    rod = state.rod
    if rod.n_base and rod.has_supports:
        return len(free_directions(rod, state.at, state.p))
    return rod.n_base + (state.has_free_rotation or state.turns_with_path)


def _mode_shapes(
    state: SteadyState, s: NDArray[Any], vectors: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles (k, n) and displacements (k, n+1, 2) of modes from their vectors (k, coordinates),
    which hold the angles and, before them, displacements of a free joint 0."""
    rod, across = state.rod, vectors[:, : -state.rod.n_moving]
    q = np.zeros((len(s), rod.n_base + rod.n_moving), dtype=complex)
    q[:, rod.n_base :] = vectors[:, -rod.n_moving :]
    if across.shape[1] == 1:
        across = across * [-np.sin(state.phi[0]), np.cos(state.phi[0])]
    if across.size:
        q[:, :2] = across
    q /= np.abs(q).max(axis=1, keepdims=True)
    if rod.n_base and not across.size:
        q[:, :2] = _base_displacements(state, s, q)
    moved, largest = joint_displacements(rod.model, rod.state_at_rest(state.at), state.p, q)
    return _real_shapes(rod, q / largest[:, None], moved / largest[:, None, None])


def _real_shapes(rod: SteadyRod, q: Complex, moved: Complex) -> tuple[NDArray[Any], NDArray[Any]]:
    """Angles (k, n) of shapes (k, coordinates), and displacements (k, n+1, 2), real where joints
    move in step."""
    phi = rod.all_angles(q[:, rod.n_base :])
    phi[:, : rod.scene.n_fixed_links] = 0.0
    real = np.abs(phi.imag).max(initial=0.0) <= 1e3 * STILL * np.abs(phi).max(initial=0.0)
    return (phi.real, moved.real) if real else (phi, moved)


def _base_displacements(state: SteadyState, s: NDArray[Any], q: NDArray[Any]) -> NDArray[Any]:
    """Displacements (k, 2) of joint 0 that go with the angles: its acceleration over s^2."""
    rod, y = state.rod, state.rod.state_in_flight(state.at)
    base = np.zeros((len(s), 2), dtype=complex)
    for at, (rate, shape) in enumerate(zip(s, q, strict=True)):
        change = np.concatenate((shape, np.zeros_like(shape)))
        # Rates are small and their effect linear: internal damping.
        change[len(shape) :] = rate * shape
        for unit, part in ((1.0, change.real), (1j, change.imag)):
            up, down = (rod.accelerations(y + sign * NUDGE * part, state.p) for sign in (1, -1))
            base[at] += unit * (up - down)[:2] / (2 * NUDGE * rate**2)
    return base
