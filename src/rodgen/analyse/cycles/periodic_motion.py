"""The periodic motion of a scene at its own values: a limit cycle, or a nonlinear mode."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from rodgen.analyse.analysis_guard import (
    CYCLE,
    check_analysis_memory,
    check_positive,
    guard_analysis,
)
from rodgen.analyse.curves.mesh_check import cycle_doubts, double_links
from rodgen.analyse.cycles.cycle_data import nearest_point, system_and_cycle_at
from rodgen.analyse.cycles.cycle_result import PICARD, Cycle
from rodgen.analyse.cycles.cycle_search import SHOOTING, WAYS, CycleSearch, check_segments
from rodgen.analyse.cycles.nonlinear_modes import mode_of_initial_state
from rodgen.analyse.cycles.shooting import SEGMENTS
from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.scene import Scene
from rodgen.system import System

if TYPE_CHECKING:
    import xarray


@guard_analysis
def find_cycle(
    system: System | Scene,
    *,
    method: str | None = None,
    segments: int | None = None,
    multipliers: int | None = None,
    y0: ArrayLike | None = None,
    period: float | None = None,
    start: xarray.Dataset | None = None,
    point: int | None = None,
    target: str | None = None,
    check_mesh: bool = False,
) -> Cycle:
    """Return the periodic motion that a scene settles on, with its Floquet multipliers.

    The scene runs from its initial state over its span, or up to 16 spans until it settles. When
    the motion comes back to itself, Newton's method takes over. Loads that repeat give the period,
    or a whole multiple of it. Loads that come to rest are taken as they are at the end of the span.
    A cycle may come back in another place and direction if nothing depends on these; a rod that
    turns over and over comes back turned by whole turns. Without dissipation no motion settles. The
    result is then the nonlinear mode that has most of the energy of the initial state, at that
    energy (see `nonlinear_mode`).

    Parameters
    ----------
    system
        The scene, or a System.
    method
        "collocation": on a mesh of the period, refined until nothing changes. "shooting": in equal
        segments. "newton_picard": Newton's method in the directions of the leading multipliers,
        Picard's iteration for the rest. By default, the method to which ``segments`` or
        ``multipliers`` belong, else collocation up to 100 states that count, and
        "newton_picard" beyond.
    segments
        Number of equal parts of the period, for "shooting".
    multipliers
        Number of leading multipliers, for "newton_picard". The default is 10.
    y0, period
        A state (states,) near a cycle, stable or not, and its approximate period [s]. Newton's
        method then begins there, without a run.
    start, point
        A branch of `continue_cycles`: find the cycle of its point of this number again, at the
        value of that point. Without ``point``, begin with the point whose value is nearest to the
        scene's own, and find the cycle at this value.
    target
        "c" or "numpy"; if not given, C where it can be built.
    check_mesh
        Also find the cycle of twice as many links, and say in the notes what changes by more
        than 1 %.

    Returns
    -------
    Cycle
        Period [s], a state on it, multipliers with the error of those that are 1.

    Raises
    ------
    InputError
        For values that cannot be used.
    AnalysisError
        If the motion comes to rest or does not settle, or if Newton's method finds no cycle.

    Examples
    --------
    >>> import rodgen
    >>> cycle = rodgen.find_cycle(rodgen.Scene.example("beck_after_flutter"))
    >>> round(cycle.period, 4), cycle.stable, cycle.trivial_error < 1e-6
    (0.8395, True, True)
    """
    system = System.of(system)
    check_analysis_memory(CYCLE, system)
    if check_mesh:
        if y0 is not None or start is not None:
            beside = "y0" if start is None else "start"
            raise InputError("check_mesh", True, f"absent beside {beside}")
        given: dict[str, Any] = {"method": method, "segments": segments, "multipliers": multipliers}
        found_twice = partial(find_cycle, double_links(system.scene), **given, target=target)
        found = find_cycle(system, **given, target=target)
        return found.with_notes(cycle_doubts(found, system.structure.n_links, found_twice))
    if method not in (None, *WAYS.values()):
        raise InputError("method", method, " or ".join(map(repr, WAYS.values())))
    for name, value, way in (
        ("segments", segments, SHOOTING),
        ("multipliers", multipliers, PICARD),
    ):
        if value is not None and (method not in (None, way) or (segments and multipliers)):
            raise InputError(name, value, f"given with method = {way!r} alone")
    segments = None if segments is None else check_segments(segments)
    multipliers = None if multipliers is None else check_segments(multipliers, "multipliers")
    if start is not None:
        if y0 is not None or period is not None:
            raise InputError("start", "a branch", "absent beside y0 and period")
        there, known = system_and_cycle_at(
            start, nearest_point(start, system.scene) if point is None else point
        )
        system = system if point is None else there
        y0, period = known.y0, known.period
    elif point is not None:
        raise InputError("point", point, "given with start, the branch whose point it is")
    begun = _check_guess(system, y0, period)
    search = replace(
        CycleSearch.of(system, target), method=method, segments=segments, leading=multipliers
    )
    if begun is not None:
        return search.find_near(*begun)
    if search.is_conservative:
        return mode_of_initial_state(system, segments or SEGMENTS, target)
    return search.find_by_run()


def _check_guess(
    system: System, y0: ArrayLike | None, period: float | None
) -> tuple[Array, float] | None:
    """Check a given state and period; None if neither is given."""
    if y0 is None and period is None:
        return None
    if y0 is None:
        raise InputError("period", period, "given with y0, a state near the cycle")
    if period is None:
        raise InputError("y0", y0, "given with period, nearly that of the cycle")
    period = check_positive(period, "period", "a time above 0 s")
    return system.at(y0=y0).y0, period
