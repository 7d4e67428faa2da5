"""The critical load of a scene, by the eigenvalues of the linearised equations."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from rodgen.analyse.confirm import ALIKE, doubt, doubt_of_onset, eigenvalues
from rodgen.analyse.family import (
    BASIS,
    FOLLOWER,
    Family,
    ScaledLoad,
    default_load,
    scaled,
    unit_of,
)
from rodgen.analyse.guard import guarded
from rodgen.analyse.modal import DIVERGENCE, FLUTTER, MOST_DENSE, slight
from rodgen.analyse.onset import At, Onset, digits, onset
from rodgen.analyse.pencil import Dense, Pencil
from rodgen.analyse.search import Event, Search, grid
from rodgen.analyse.sizes import CRITICAL, check_size
from rodgen.analyse.steady_rod import SteadyRod, state_after
from rodgen.analyse.zero_onset import zero_onset
from rodgen.errors import AnalysisError, InputError
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_notes
from rodgen.scene.plain import is_number, plain
from rodgen.scene.tables import LARGEST
from rodgen.shown import Shown
from rodgen.system import System

HIGHEST = 1000.0  # EI/L^2: ten times what a free rod bears
NARROWEST = 1e-6, 1e-9  # range that is searched: of EI/L^2, and of its ends
SLOW = 0.01  # of the lowest frequency
WHOLE = 0.9  # of the angles that links have in common, squared: the whole rod turns
KNOWN = 1e-4  # share of an onset that rounding may change at most
AT_ONCE = 1e-9  # EI/L^2: an onset so close to the lowest force lies at it
CHECKED = (0.0, 0.5, 0.9)  # of the way to an onset, where all eigenvalues are looked at
TURNING = "turning"
UPPER, LOWER = "upper", "lower"


@dataclass(frozen=True, repr=False)
class Critical(Shown):
    """The critical load: the steady state loses its stability, or regains it at a lower end.

    force: size of the load [N; m/s^2 of gravity]; factor: force L^2/EI (`stiffness` is this EI), of
    gravity the weight M g L^2/EI, of all loads their multiple, dimensionless; kind: "flutter",
    "divergence" (without oscillation), or "turning" (the rod turns as a whole); frequency: at the
    onset [Hz], zero for divergence; modes: numbers of the two modes whose frequencies meet, or,
    with damping, of the mode that grows and its neighbour in frequency, counted from 1 by frequency
    just below the force, without rigid-body motions (a mode that diverges, or oscillates alone, is
    named twice); turning: growth of a slow turning of the whole rod at that force [1/s]; error:
    bound of the rounding error of the force [N]; searched: range of forces that was searched [N],
    up to the onset, and number of forces; state: the steady state that grows unstable; complete:
    whether all modes were looked at (under four forces up to this one, and just above it), or only
    those next to the onset in rate; t: time at which the other loads are taken [s].

    speed: of a free rod along its axis, nose first [m/s]; notes: what to know about this speed, and
    about damping that depends on the number of links; applied: size that this load has in the scene
    itself at t [N], not-a-number where it follows the motion, 1 of all loads; load: the load that
    is scaled; unit: its unit; end: "upper" or "lower"; growth: of the motion that grows at the
    lowest force already [1/s], 0 if none does; elastic: whether turning of the whole rod was left
    out; stable: all windows of stability in the range (low, high) [N], if they were asked for;
    frequency_error: bound of the rounding error of the frequency [Hz]; scene: the scene of the
    steady state.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.critical_force(rodgen.Scene.example("ziegler"))
    >>> found.kind, found.modes
    ('flutter', (1, 2))
    """

    force: float
    factor: float
    kind: str
    frequency: float
    modes: tuple[int, int]
    turning: float
    error: float
    searched: tuple[float, float, int]
    state: str
    complete: bool
    t: float
    speed: float = 0.0
    notes: tuple[str, ...] = ()
    applied: float = math.nan
    load: str = FOLLOWER
    unit: str = unit_of(FOLLOWER)
    end: str = UPPER
    growth: float = 0.0
    elastic: bool = False
    stable: tuple[tuple[float, float], ...] | None = None
    frequency_error: float = 0.0
    scene: Scene = field(kw_only=True, compare=False)

    @property
    def stiffness(self) -> float:
        """EI by which the factor is taken [N m^2]: of a rod along which it differs, the mean of the
        springs of the inner joints times the length of a link."""
        return self.scene.distribution.usual_stiffness

    @property
    def load_ratio(self) -> float:
        """The load ratio: ``applied`` over ``force``, dimensionless; not-a-number where that is
        zero."""
        return self.applied / self.force if self.force else math.nan

    def __repr__(self) -> str:
        at = f" at {digits(self.frequency, self.frequency_error)} Hz" * bool(self.frequency)
        ends = "ends" if self.end == LOWER else "from"
        where = f"{ends} {digits(self.force, self.error)} {self.unit}{at}"
        return f"<Critical {self.load} of {self.scene.name}: {self.kind} {where}>"


@guarded
def critical_force(
    system: System | Scene,
    *,
    lowest: float | None = None,
    highest: float | None = None,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
    load: str | None = None,
    end: str = UPPER,
    windows: bool = False,
    elastic: bool = False,
) -> Critical:
    """Return the smallest force above ``lowest`` at which a small motion begins to grow.

    A range of forces is searched in the lowest 16 modes, in steps of EI/(2 L^2) or 1 %. The onset
    is then solved for with all links, to the digits that ``error`` leaves. If a motion grows at a
    ``lowest`` of your own already, the next motion that begins to grow is found. Internal damping
    counts as the scene has it: a little of it can lower the force much. External damping counts as
    at the given speed.

    Parameters
    ----------
    system
        The scene, or a System. The size of the load that is scaled is not used.
    lowest, highest
        Forces at which the search begins and ends [N]. By default 0 and 1000 EI/L^2.
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

    Returns
    -------
    Critical
        The force [N], its kind ("flutter", "divergence", "turning"), frequency [Hz] and error [N].

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
    >>> found = rodgen.critical_force(rodgen.Scene.example("becks_column"))
    >>> found.kind, round(found.factor, 4)
    ('flutter', 20.0268)
    """
    family = family_of(system, t, speed, after, load)
    if not family.whole:
        raise AnalysisError("no mode can become unstable: all motions move the rod as a whole")
    if end not in (UPPER, LOWER):
        raise InputError("end", end, f"{UPPER} or {LOWER}")
    low, high = _range(lowest, highest, family.unit)
    forces = grid(low, high, family.unit)
    search = Search(family, forces, BASIS, elastic)
    growth = float(search.first.growth.max(initial=0.0))
    if 0 < growth <= ALIKE * slight(0.0, family.lowest) and not eigenvalues(family, low).count:
        growth = 0.0  # the rounding of a motion that nothing resists
    if growth and lowest is None and end == UPPER and not windows:
        raise AnalysisError(_unstable(search, growth))
    found = _first(search, end, growth)
    looked = forces[: int(np.searchsorted(forces, found.force)) + 1]
    complete = family.rod.cells <= MOST_DENSE
    # A rod that is held and stays straight is what it is without the load.
    same = family.straight and not family.rod.base
    state = family.state(0.0 if same else found.force)
    return Critical(
        force=found.force,
        factor=found.force / family.load.reference,
        kind=_kind(search, found),
        frequency=found.s.imag / (2 * np.pi),
        modes=_pair(family, found, end, family.whole if complete else BASIS),
        turning=family.turning(found.force),
        error=found.error,
        searched=(low, float(looked[-1]), len(looked)),
        state=state.words,
        complete=complete,
        t=family.rod.t,
        speed=family.rod.speed,
        notes=state.notes + mesh_notes(family.rod.system.source),
        applied=family.load.applied,
        load=family.load.name,
        unit=unit_of(family.load.name),
        end=end,
        growth=growth,
        elastic=elastic,
        stable=tuple(_windows(search)) if windows else None,
        frequency_error=found.rate_error / (2 * np.pi),
        scene=family.rod.scene,
    )


def family_of(
    system: System | Scene,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
    load: str | None = None,
) -> Family:
    """The linearised scene for every size of a load. Raises InputError, AnalysisError."""
    system = System.of(system)
    check_size(CRITICAL, system)
    system, t = state_after(system, t, speed, after)
    load = default_load(system) if load is None else load
    term, law = scaled(load), None
    if term and term.name in system.load_terms and term.has_size:
        # Its size is not used by what follows; one that is a function of time is no parameter.
        name = term.sizes[0].name
        law = system.laws.get(name)
        if law is not None:
            system = system.at({system.field(name): 0.0})
    rod = SteadyRod.of(system, t, speed)
    made = ScaledLoad.of(load, rod)
    if law is not None:
        applied = math.nan if law.signals else float(law(rod.t))
        made = replace(made, applied=applied)
    return Family(rod, made)


def _range(lowest: float | None, highest: float | None, unit: float) -> tuple[float, float]:
    """Ends of the search; raises InputError for what are none."""
    low = 0.0 if lowest is None else _number("lowest", lowest)
    high = HIGHEST * unit if highest is None else _number("highest", highest)
    least = max(NARROWEST[0] * unit, NARROWEST[1] * max(abs(low), abs(high)))
    if not high - low >= least:
        raise InputError("highest", high, f"above lowest = {low:g} by {least:.3g} or more")
    return low, high


def _number(name: str, value: float) -> float:
    value = plain(value, name)
    if not (is_number(value) and np.isfinite(value) and abs(value) <= LARGEST):
        raise InputError(name, value, f"a finite number, at most {LARGEST:g} in size")
    return float(value)


def _unstable(search: Search, growth: float) -> str:
    """What is said of a rod that is unstable from the start."""
    low, unit = search.forces[0], unit_of(search.family.load.name)
    said = f"unstable already at the lowest force of the search, {low:g} {unit}: "
    said += f"a motion grows with {growth:.3g} 1/s"
    found = [f"{a:.6g} to {b:.6g}" for a, b in _rough(search)]
    if not found:
        return said
    return f"{said}; stable from {', '.join(found)} {unit} (a lowest within finds where that ends)"


def _rough(search: Search) -> list[tuple[float, float]]:
    """Windows of stability, their ends by bisection."""
    return _between(search, lambda event: search.near(event).force)


def _windows(search: Search) -> list[tuple[float, float]]:
    """Windows of stability, their ends to the last digits."""
    return _between(search, lambda event: _onset(search, search.near(event)).force)


def _between(search: Search, solved: Callable[[Event], float]) -> list[tuple[float, float]]:
    events = list(search.borders())
    first, last = (float(search.forces[at]) for at in (0, -1))
    ends = [first] * (not (events[0].before if events else search.counts(search.forces[:1])[0]))
    ends += [solved(event) for event in events]
    ends += [last] * (len(ends) % 2)
    return list(zip(ends[::2], ends[1::2], strict=True))


def _first(search: Search, end: str, growth: float) -> Onset:
    """The first onset with all links, from a search in a few modes; in all of them where those did
    not do. Raises AnalysisError, too where what grows is not what the eigenvalues say."""
    family, why = search.family, AnalysisError("")
    many = family.rod.cells > MOST_DENSE
    enough = many or family.whole <= BASIS
    for one in [search] if enough else [search, replace(search, modes=family.whole)]:
        near = _found(one, end)
        try:
            found = None if near is None else _onset(one, near)
        except AnalysisError as error:
            why = error
            continue
        low, high = float(search.forces[0]), float(search.forces[-1])
        if found is None:
            why = AnalysisError(_none(one, end, growth))
            apart = doubt(one, (low, (low + high) / 2, high))
            if not apart:
                break
        else:
            ways = low + np.array(CHECKED) * (found.force - low)
            # The modes of many links are those of the whole unloaded rod already.
            apart = doubt(one, [] if many else ways.tolist())
            apart = apart or doubt_of_onset(one, found, end == UPPER)
            if not apart:
                return found
        why = AnalysisError(apart)
    raise why


def _found(search: Search, end: str) -> Onset | None:
    """The first event that is asked for, roughly."""
    ends = (event for event in search.borders() if not event.after)
    event = next(search.begins() if end == UPPER else ends, None)
    return None if event is None else search.near(event)


def _none(search: Search, end: str, growth: float) -> str:
    """What is said where there is no such event."""
    low, high = search.forces[[0, -1]]
    where = f"between {low:g} and {high:g} {unit_of(search.family.load.name)}"
    if end == LOWER:
        what = f"no lower end of a window of stability {where}"
    elif growth:
        what = f"{_unstable(search, growth)}; no other motion begins to grow {where}"
    else:
        what = f"neither flutter nor divergence {where}"
    modes = min(search.modes, search.family.whole)
    return f"{what} ({len(search.forces)} forces, the lowest {modes} modes)"


def _onset(search: Search, near: Onset) -> Onset:
    """The onset with all links, next to an estimate; that which is next to the lowest force is
    there, since the motion grows under every larger one."""
    family, lowest = search.family, float(search.forces[0])
    if near.s == 0 and family.neutral.steps:
        found = zero_onset(family.without_neutral, near, family.unit)
    else:
        found = onset(_equations(family, near), near, family.unit, family.straight)
    if found.force - found.error < lowest + AT_ONCE * family.unit:
        return replace(found, force=lowest)
    if found.error > KNOWN * abs(found.force) and family.whole <= BASIS:
        raise AnalysisError(
            f"an onset near {digits(found.force, found.error)} {unit_of(family.load.name)} is "
            f"known to {found.error / abs(found.force):.1e} of it only, by rounding"
        )
    return found


def _equations(family: Family, near: Onset) -> At:
    """Where almost nothing oscillates, turning the whole rod would be next to singular too."""
    if near.s == 0:  # of stiffness alone
        return family.without_turning
    if abs(near.s) >= SLOW * family.lowest or not isinstance(family.at(near.force), Pencil):
        return family.at
    return family.modal if family.whole <= BASIS else family.without_turning


def _kind(search: Search, found: Onset) -> str:
    """Flutter, divergence, or the turning of the whole rod, by the angles of what grows."""
    family, here = search.family, search.family.at(found.force)
    turns = family.bare is not None and family.rod.base and not search.elastic
    if isinstance(here, Dense) and turns:
        shape = np.linalg.svd(here.at(found.s))[2][-1, -family.rod.cells :]
        common = abs(shape.mean()) ** 2 * len(shape)
        if common >= WHOLE * np.linalg.norm(shape) ** 2 and not family.diverges(found.force):
            return TURNING
    return FLUTTER if found.s else DIVERGENCE


def _pair(family: Family, found: Onset, end: str, modes: int) -> tuple[int, int]:
    """Numbers of the modes, by frequency just below the force, or just above a lower end."""
    beside = found.force * (1 - 1e-5 if end == UPPER else 1 + 1e-5)
    s = family.rates(np.array([beside]), modes)[0]
    rates = np.sort(s.imag[s.imag > family.rigid])
    if not found.s or len(rates) < 2:
        return 1, 1
    nearest = np.argsort(np.abs(rates - found.s.imag))[:2] + 1
    first, second = sorted(int(at) for at in nearest)
    return first, second
