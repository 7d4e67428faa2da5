"""The critical load of a scene, by the eigenvalues of the linearised equations."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from rodgen.analyse.analysis_guard import (
    Bounds,
    OpenBounds,
    check_open_bounds,
    check_positive,
    guard_analysis,
)
from rodgen.analyse.eigenvalue_check import (
    ALIKE,
    find_contradiction,
    find_onset_contradiction,
    full_spectrum,
)
from rodgen.analyse.load_family import BASIS, HIGHEST, LoadFamily
from rodgen.analyse.modal import DIVERGENCE, FLUTTER, MOST_DENSE, rounding_growth
from rodgen.analyse.onset import At, LoadSearch, Onset, load_grid, solve_onset, solve_zero_onset
from rodgen.analyse.pencil import BlockPencil, DensePencil
from rodgen.analyse.scaled_load import FOLLOWER, GROUPS, find_term, label_of, symbol_of, unit_of
from rodgen.analyse.scene_family import load_family
from rodgen.analyse.simulated_critical import (
    GrowthTest,
    SimulatedCritical,
    bisect_growth,
    comparison_rows,
    find_difference,
)
from rodgen.analyse.steady_rod import TIME, StateResult
from rodgen.display import Plottable
from rodgen.errors import AnalysisError, InputError
from rodgen.result import (
    ASKED,
    USUAL,
    WORD,
    Note,
    Row,
    doubt,
    format_with_error,
    omit_from_tables,
    remarks,
)
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_notes
from rodgen.system import System

NARROWEST = 1e-6, 1e-9  # range that is searched: of EI/L^2, and of its ends
SLOW = 0.01  # of the lowest frequency
WHOLE = 0.9  # of the angles that links have in common, squared: the whole rod turns
KNOWN = 1e-4  # share of an onset that rounding may change at most
AT_ONCE = 1e-9  # EI/L^2: an onset so close to the lowest force lies at it
CHECKED = (0.0, 0.5, 0.9)  # of the way to an onset, where all eigenvalues are looked at
TURNING = "turning"
UPPER, LOWER = "upper", "lower"
UNIT = "{unit}"  # that of the load

FAST = "links without mass buckle between what has mass, which nothing slows down; give them some"


@dataclass(frozen=True, repr=False)
class Critical(StateResult, Plottable):
    """The critical load: the steady state loses its stability, or regains it at a lower end.

    value: size of the load, in SI units; load_parameter: P L^2/EI (`stiffness` is this EI), of
    gravity the weight M g L^2/EI, of all loads their multiple, dimensionless; kind: "flutter",
    "divergence" (without oscillation), or "turning" (the rod turns as a whole); frequency: at the
    onset [Hz], zero for divergence; modes: numbers of the two modes whose frequencies meet, or,
    with damping, of the mode that grows and its neighbour in frequency, counted from 1 by frequency
    just below the load, without rigid-body motions (a mode that diverges, or oscillates alone, is
    named twice); turning: growth of a slow turning of the whole rod at that load [1/s]; error:
    bound of the rounding error of the value, in SI units; searched: range of sizes that was
    searched, up to the onset, in SI units, and number of sizes; state: the steady state that grows
    unstable; complete: whether all modes were looked at (under four sizes up to this one, and just
    above it), or only those next to the onset in rate.

    speed: of a free rod along its axis, nose first [m/s]; notes: what to know about this speed,
    about damping that depends on the number of links, and about simulations that find another load;
    applied: size that this load has in the scene itself at t, in SI units, not-a-number where it
    follows the motion, 1 of all loads; load: the load that is scaled; unit: its unit; end: "upper"
    or "lower"; growth: of the motion that grows at the lowest load already [1/s], 0 if none does;
    elastic: whether turning of the whole rod was left out; windows: all windows of stability in the
    range (low, high), in SI units, if they were asked for; frequency_error: bound of the rounding
    error of the frequency [Hz]; simulated: what simulations found, if they were asked for and found
    it; system: the rod in the steady state, with the loads of one time.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.critical_load(rodgen.Scene.example("ziegler"))
    >>> found.kind, found.modes
    ('flutter', (1, 2))
    """

    value: float
    load_parameter: float
    kind: str
    frequency: float
    modes: tuple[int, int]
    turning: float
    error: float
    searched: tuple[float, float, int]
    state: str
    complete: bool
    speed: float = 0.0
    notes: tuple[Note, ...] = ()
    applied: float = math.nan
    load: str = FOLLOWER
    unit: str = unit_of(FOLLOWER)
    end: str = UPPER
    growth: float = 0.0
    elastic: bool = False
    windows: tuple[tuple[float, float], ...] | None = None
    frequency_error: float = 0.0
    simulated: SimulatedCritical | None = None
    system: System = field(kw_only=True, compare=False)

    ROWS = (
        Row("load", "load", text=lambda found: label_of(found.load)),
        Row("value", "critical load", UNIT, kept=USUAL, error="error"),
        Row("unit", "unit", text=omit_from_tables),
        Row("load_parameter", "load parameter", text=lambda found: found._parameter, kept=USUAL),
        Row("stiffness", "EI in it", "N m^2", text=lambda found: found._stiffness),
        Row("applied", "load of the scene", UNIT, ".9g", missing="follows the motion"),
        Row("load_ratio", "load ratio", "", ".6g", kept=ASKED, missing="not known"),
        Row(
            "kind",
            "kind",
            text=lambda found: found.kind + ", where stability is regained" * (found.end == LOWER),
            kept=WORD,
        ),
        Row("frequency", "frequency at onset", "Hz", kept=USUAL, error="frequency_error"),
        Row("frequency_error", "error of the frequency", "Hz", text=omit_from_tables, kept=ASKED),
        Row("modes", "modes", text=lambda found: " and ".join(map(str, sorted({*found.modes})))),
        Row("error", "error, estimated", UNIT, ".1e", kept=USUAL),
        Row("end", "end of the window", text=omit_from_tables),
        Row("state", "grows from the state"),
        Row("searched", "searched", UNIT, text=lambda found: found._range_text),
        Row(
            "complete",
            "modes looked at",
            text=lambda found: "all" if found.complete else f"the lowest {BASIS}",
        ),
        Row("growth", "grows already", "1/s", text=lambda found: found._growth, kept=ASKED),
        Row("windows", "stable", UNIT, text=lambda found: found._windows),
        Row("turning", "apart from that", "1/s", text=lambda found: found._turning, kept=ASKED),
        Row("elastic", "turning left out", text=omit_from_tables),
        Row("speed", "speed", "m/s", text=omit_from_tables, kept=ASKED),
        Row(
            "simulated",
            "by simulation",
            of=lambda found: found.simulated and found.simulated.to_dict(),
            text=lambda found: found.simulated and comparison_rows(found.simulated, found.value),
        ),
        *TIME,
    )

    @property
    def stiffness(self) -> float:
        """EI in the load parameter [N m^2]: of a rod along which it differs, the mean of the
        springs of the inner joints times the length of a link."""
        return self.scene.distribution.mean_stiffness

    @property
    def load_ratio(self) -> float:
        """``applied`` over ``value``, dimensionless; not-a-number where that is zero."""
        return self.applied / self.value if self.value else math.nan

    @property
    def _scaled_parameters(self) -> tuple[str, ...]:
        term = find_term(self.load)
        rows = self.scene.structure.load_rows
        return () if term is None else tuple(one.name for one in rows[term.name].size_parameters)

    @property
    def _parameter(self) -> dict[str, str]:
        if self.load in GROUPS:  # it is the value
            return {}
        error = self.error * self.load_parameter / (self.value or 1)
        return {symbol_of(self.load): format_with_error(self.load_parameter, error)}

    @property
    def _stiffness(self) -> str | None:
        """The EI of the load parameter, of a rod along which it differs."""
        if self.scene.distribution.stiffness is not None or self.load in GROUPS:
            return None
        what = "the mean of the springs of the inner joints times the length of a link"
        return f"{self.stiffness:.10g} N m^2, {what}"

    @property
    def _range_text(self) -> str:
        low, high, count = self.searched
        return f"{low:g} to {high:g} {self.unit} at {count} sizes"

    @property
    def _growth(self) -> str | None:
        low = self.searched[0]
        return f"at {low:g} {self.unit}, with {self.growth:.4g} 1/s" if self.growth else None

    @property
    def _windows(self) -> str | None:
        if self.windows is None:
            return None
        ends = [f"{a:.10g} to {b:.10g} {self.unit}" for a, b in self.windows]
        return ", ".join(ends) or "nowhere in the range"

    @property
    def _turning(self) -> str | None:
        turns = f"the rod turns as a whole, with {self.turning:.4g} 1/s"
        return turns if self.turning else None

    def __repr__(self) -> str:
        ends = "ends" if self.end == LOWER else "from"
        where = f"{ends} {format_with_error(self.value, self.error)} {self.unit}"
        if self.frequency:
            where += f" at {format_with_error(self.frequency, self.frequency_error)} Hz"
        return f"<Critical {self.load} of {self.scene.name}: {self.kind} {where}>"


@guard_analysis
def critical_load(
    system: System | Scene,
    *,
    bounds: OpenBounds = (None, None),
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
    load: str | None = None,
    end: str = UPPER,
    windows: bool = False,
    elastic: bool = False,
    simulate: float | None = None,
    progress: Callable[[float, bool], None] = lambda force, grew: None,
) -> Critical:
    """Return the smallest load within bounds at which a small motion begins to grow.

    A range of sizes is searched in the lowest 16 modes, in steps of EI/(2 L^2) or 1 %. The onset
    is then solved for with all links, to the digits that ``error`` leaves. If a motion grows at a
    lower bound of your own already, the next motion that begins to grow is found. Internal damping
    counts as the scene has it: a little of it can lower the force much. External damping counts as
    at the given speed.

    Parameters
    ----------
    system
        The scene, or a System. The size of the load that is scaled is not used.
    bounds
        Sizes of the load (a, b) between which is searched, in its unit. None is the default of
        either: 0 and 1000 EI/L^2.
    t
        Time whose other loads are taken [s]; by default the start of the span.
    speed
        Speed of a free rod along its axis, nose first [m/s], taken as constant. By default it is
        the part of the scene's initial velocity along the axis.
    after
        Take the other loads, speed and direction from a run of the scene after this time [s].
    load
        The load that is scaled: "follower", "follower_2" if there are several,
        "distributed_follower" (the whole force), "tip" (the dead force, in its direction),
        "gravity" [m/s^2], "followers" or "all" (by one factor). By default the first that follows
        the rod.
    end
        "upper": where stability is lost. "lower": where it is regained.
    windows
        Also find all windows of stability in the range.
    elastic
        Leave out motions that turn a free rod as a whole.
    simulate
        Also find a critical follower force by simulations of this length [s], see
        `simulated_critical_load`. A doubt says so where they find another.
    progress
        A function that is called with every force of these simulations [N], and with whether the
        motion grew.

    Returns
    -------
    Critical
        The load with its unit, its kind ("flutter", "divergence", "turning"), frequency [Hz] and
        error.

    Raises
    ------
    InputError
        For a scene without that load, and for an empty range.
    AnalysisError
        If there is no steady state, if it does not lose its stability in the range, or if it is
        unstable from the start.

    Examples
    --------
    Beck's column of 50 links; the continuous one flutters at 20.0510 EI/L^2.

    >>> import rodgen
    >>> found = rodgen.critical_load(rodgen.Scene.example("becks_column"))
    >>> found.kind, round(found.load_parameter, 4)
    ('flutter', 20.0268)
    """
    if simulate is not None:
        _check_simulate(simulate, load)
    family = load_family(system, t, speed, after, load)
    if not family.lowest_frequency:
        raise AnalysisError("no mode can become unstable: all motions move the rod as a whole")
    if end not in (UPPER, LOWER):
        raise InputError("end", end, f"{UPPER} or {LOWER}")
    low, high = _check_range(bounds, family.unit)
    forces = load_grid(low, high, family.unit)
    search = LoadSearch(family, forces, BASIS, elastic)
    growth = float(search.first_motions.growth.max(initial=0.0))
    if (
        0 < growth <= ALIKE * rounding_growth(0.0, family.lowest_frequency)
        and not full_spectrum(family, low).n_growing
    ):
        growth = 0.0  # the rounding of a motion that nothing resists
    if growth and bounds[0] is None and end == UPPER and not windows:
        raise AnalysisError(_describe_instability(search, growth))
    found = _find_first_onset(search, end, growth)
    looked = forces[: int(np.searchsorted(forces, found.force)) + 1]
    complete = family.rod.n_moving <= MOST_DENSE
    # The state of a straight rod with fixed joint 0 does not depend on the load.
    same = family.straight and not family.rod.n_base
    state = family.steady_state(0.0 if same else found.force)
    simulated, doubts = None, tuple[Note, ...]()
    if simulate is not None:
        simulated, doubts = _simulate_critical(family, found.force, simulate, progress)
    return Critical(
        value=found.force,
        load_parameter=found.force / family.load.reference,
        kind=_classify_onset(search, found),
        frequency=found.s.imag / (2 * np.pi),
        modes=_mode_pair(family, found, end, family.n_modes if complete else BASIS),
        turning=family.rotation_growth(found.force),
        error=found.error,
        searched=(low, float(looked[-1]), len(looked)),
        state=state.description,
        complete=complete,
        speed=family.rod.speed,
        notes=(*state.notes, *doubts, *remarks(mesh_notes(family.rod.system.source))),
        applied=family.load.applied,
        load=family.load.name,
        unit=unit_of(family.load.name),
        end=end,
        growth=growth,
        elastic=elastic,
        windows=tuple(_windows(search, refined=True)) if windows else None,
        frequency_error=found.rate_error / (2 * np.pi),
        simulated=simulated,
        system=family.rod.system,
    )


def _check_simulate(span: object, load: str | None) -> None:
    """Raise InputError for an unusable length of simulations, and for loads that they do not
    find."""
    check_positive(span, "simulate", "a positive number of seconds")
    if load not in (None, FOLLOWER):
        raise InputError("simulate", span, "absent: runs find a follower force alone")


def _simulate_critical(
    family: LoadFamily, force: float, span: float, progress: Callable[[float, bool], None]
) -> tuple[SimulatedCritical | None, tuple[Note, ...]]:
    """Find the critical force by simulations, with a doubt where it differs or is not found."""
    try:
        found = bisect_growth(GrowthTest(family, span, progress=progress))
    except AnalysisError as error:
        return None, (doubt(f"by simulation: {error}"),)
    return found, tuple(find_difference(force, found, family))


def _check_range(bounds: OpenBounds, unit: float) -> Bounds:
    """Return the bounds of the search. Raises InputError for an empty range."""
    low, high = (
        float(default if one is None else one)
        for one, default in zip(check_open_bounds(bounds), (0.0, HIGHEST * unit), strict=True)
    )
    least = max(NARROWEST[0] * unit, NARROWEST[1] * max(abs(low), abs(high)))
    if not high - low >= least:
        raise InputError("bounds", bounds, f"({low:g}, b) with b above that by {least:.3g} or more")
    return low, high


def _describe_instability(search: LoadSearch, growth: float) -> str:
    """Describe a rod that is unstable from the start, and where it is stable."""
    low, unit = search.forces[0], unit_of(search.family.load.name)
    said = f"unstable already at the lowest size of the search, {low:g} {unit}: "
    said += f"a motion grows with {growth:.3g} 1/s"
    found = [f"{a:.6g} to {b:.6g}" for a, b in _windows(search, refined=False)]
    if not found:
        return said
    where = f"stable from {', '.join(found)} {unit}"
    return f"{said}; {where} (a lower bound within finds where that ends)"


def _windows(search: LoadSearch, refined: bool) -> list[tuple[float, float]]:
    """Windows of stability, with ends by bisection, or refined to the last digits."""
    changes = list(search.stability_borders())
    first, last = (float(search.forces[at]) for at in (0, -1))
    ends = [first] * (not (changes[0].before if changes else search.first_motions.n_growing[0]))
    for change in changes:
        near = search.locate(change)
        ends.append((_refine_onset(search, near) if refined else near).force)
    ends += [last] * (len(ends) % 2)
    return list(zip(ends[::2], ends[1::2], strict=True))


def _find_first_onset(search: LoadSearch, end: str, growth: float) -> Onset:
    """Find the first onset with all links, from a search in a few modes, or in all where those
    fail. Raises AnalysisError, also where eigenvalues contradict the search."""
    family, why = search.family, AnalysisError("")
    many = family.rod.n_moving > MOST_DENSE
    enough = many or family.n_modes <= BASIS
    for one in [search] if enough else [search, replace(search, modes=family.n_modes)]:
        near = _estimate_first_onset(one, end)
        try:
            found = None if near is None else _refine_onset(one, near)
        except AnalysisError as error:
            why = error
            continue
        low, high = float(search.forces[0]), float(search.forces[-1])
        if found is None:
            why = AnalysisError(_describe_no_onset(one, end, growth))
            apart = find_contradiction(one, (low, (low + high) / 2, high))
            if not apart:
                break
        else:
            ways = low + np.array(CHECKED) * (found.force - low)
            # A search for many links is already in the lowest modes of the whole rod.
            apart = find_contradiction(one, [] if many else ways.tolist())
            apart = apart or find_onset_contradiction(one, found, end == UPPER)
            if not apart:
                return found
        why = AnalysisError(apart)
    raise why


def _estimate_first_onset(search: LoadSearch, end: str) -> Onset | None:
    """Estimate the first onset of the requested kind; None where there is none."""
    ends = (event for event in search.stability_borders() if not event.after)
    event = next(search.onsets() if end == UPPER else ends, None)
    return None if event is None else search.locate(event)


def _describe_no_onset(search: LoadSearch, end: str, growth: float) -> str:
    """Describe a range without the requested onset."""
    low, high = search.forces[[0, -1]]
    where = f"between {low:g} and {high:g} {unit_of(search.family.load.name)}"
    if end == LOWER:
        what = f"no lower end of a window of stability {where}"
    elif growth:
        what = f"{_describe_instability(search, growth)}; no other motion begins to grow {where}"
    else:
        what = f"neither flutter nor divergence {where}"
    modes = min(search.modes, search.family.n_modes)
    return f"{what} ({len(search.forces)} forces, the lowest {modes} modes)"


def _refine_onset(search: LoadSearch, near: Onset) -> Onset:
    """Refine an estimate to the onset with all links. One within rounding of the lowest force lies
    there, since the motion grows under every larger one."""
    family, lowest = search.family, float(search.forces[0])
    if np.isinf(near.s):
        raise AnalysisError(f"at {near.force:.6g} {unit_of(family.load.name)}, {FAST}")
    if near.s == 0 and family.neutral_motions.steps:
        found = solve_zero_onset(family.matrix_without_neutral, near, family.unit)
    else:
        found = solve_onset(_choose_equations(family, near), near, family.unit, family.straight)
    if found.force - found.error < lowest + AT_ONCE * family.unit:
        return replace(found, force=lowest)
    if found.error > KNOWN * abs(found.force) and family.n_modes <= BASIS:
        about = format_with_error(found.force, found.error)
        raise AnalysisError(
            f"an onset near {about} {unit_of(family.load.name)} is known to "
            f"{found.error / abs(found.force):.1e} of it only, by rounding"
        )
    return found


def _choose_equations(family: LoadFamily, near: Onset) -> At:
    """Choose the equations for an onset; near s = 0 those in which turning does not interfere."""
    if near.s == 0:  # of stiffness alone
        return family.without_rotation
    if abs(near.s) >= SLOW * family.lowest_frequency or not isinstance(
        family.linearise(near.force), BlockPencil
    ):
        return family.linearise
    return family.modal_pencil if family.n_modes <= BASIS else family.without_rotation


def _classify_onset(search: LoadSearch, found: Onset) -> str:
    """Classify an onset by the shape of its motion: flutter, divergence, or turning of the rod."""
    family, here = search.family, search.family.linearise(found.force)
    turns = family.without_damping is not None and family.rod.n_base and not search.elastic
    if isinstance(here, DensePencil) and turns:
        shape = np.linalg.svd(here.at(found.s))[2][-1, -family.rod.n_moving :]
        common = abs(shape.mean()) ** 2 * len(shape)
        if common >= WHOLE * np.linalg.norm(shape) ** 2 and not family.has_divergence(found.force):
            return TURNING
    return FLUTTER if found.s else DIVERGENCE


def _mode_pair(family: LoadFamily, found: Onset, end: str, modes: int) -> tuple[int, int]:
    """Numbers of the modes that meet, by frequency just below the force, or above a lower end."""
    beside = found.force * (1 - 1e-5 if end == UPPER else 1 + 1e-5)
    s = family.eigenvalues(np.array([beside]), modes)[0]
    rates = np.sort(s.imag[s.imag > family.zero_tolerance])
    if not found.s or len(rates) < 2:
        return 1, 1
    nearest = np.argsort(np.abs(rates - found.s.imag))[:2] + 1
    first, second = sorted(int(at) for at in nearest)
    return first, second
