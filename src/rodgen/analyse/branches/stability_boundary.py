"""Stability boundary in the plane of two numbers of a scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.analyse.analysis_guard import (
    BOUNDARY,
    check_analysis_memory,
    check_bounds,
    guard_analysis,
)
from rodgen.analyse.branches.boundary_equations import BoundaryProblem, ParameterPlane, Scale
from rodgen.analyse.branches.stability_region import (
    Ends,
    OutlineTracer,
    count_growing,
    eigenvalues_at,
)
from rodgen.analyse.critical import Critical, critical_load
from rodgen.analyse.curves.continuation import StepControl
from rodgen.analyse.curves.curve import Curve
from rodgen.analyse.curves.curve_datasets import SPECIAL_ROWS, CurveFormat, extend, make_dataset
from rodgen.analyse.modal import DIVERGENCE, FLUTTER
from rodgen.arrays import Array
from rodgen.dataset_result import POINT, SPECIAL
from rodgen.errors import AnalysisError, InputError
from rodgen.result import Row
from rodgen.scene import Scene
from rodgen.scene.plain_tables import is_number
from rodgen.system import System

if TYPE_CHECKING:
    import xarray

STEP = 0.1  # of the units along the boundary
MOST = 1000  # points to either side
SHARE = 0.02  # of critical damping in the lowest motion: where a search begins
HUGE = 1e8  # units of damping that are as good as no end
LARGEST = 400.0  # units of other numbers, a hundred times what they are
NARROWEST = 1e-6  # of a range, of its ends
OUTSIDE = 1e-9  # of a coordinate, by which a point may lie outside its range
SAME = 1e-12  # of matrices: a change that is rounding
GRID, NARROW = 200, 1e-9  # values along a number; width to which a change is narrowed
FORMAT = CurveFormat(
    "rodgen boundary 1",
    "a boundary",
    (
        Row("a", "{a}", along=POINT),
        Row("b", "{b}", along=POINT),
        Row("frequency", "frequency", "Hz", along=POINT),
        Row("length", "length along the boundary", along=POINT),
        Row("kind", "begins there"),
        Row("end", "ends"),
        *SPECIAL_ROWS,
        Row("special_a", "{a}", along=SPECIAL),
        Row("special_b", "{b}", along=SPECIAL),
        Row("special_frequency", "frequency", "Hz", along=SPECIAL),
    ),
)


@guard_analysis
def stability_boundary(
    system: System | Scene,
    keys: tuple[str, str],
    *,
    bounds: tuple[Ends | None, Ends | None] = (None, None),
    step: float = STEP,
    max_points: int = MOST,
    t: float | None = None,
    resume: xarray.Dataset | None = None,
    point: int = -1,
    callback: Callable[[tuple[float, float, float]], None] = lambda at: None,
) -> xarray.Dataset:
    """Follow the curve on which flutter or divergence begins, in the plane of two numbers.

    If one number is the size of a load, `critical_load` finds the first point, at the scene's
    value of the other number (at a little damping, if that is zero damping). Otherwise the first
    number is searched for a value at which a motion begins or ceases to grow. From there the curve
    is followed both ways. It is the outline of the stable region around its start: if another
    motion becomes unstable first, or flutter becomes divergence, the curve goes on along the
    boundary that begins there. The limit of vanishing damping is a point of the curve. It differs
    from the onset of the rod without damping (H. Ziegler, Ingenieur-Archiv 20 (1952) 49-56).

    Parameters
    ----------
    system
        The scene, or a System.
    keys
        Both numbers, named as in a study, such as loads.follower.force and
        loads.material_damping.time.
    bounds
        First and last value of each number, in SI units. By default they go from 0 to practically
        no limit.
    step
        Length of the longest step, dimensionless. In steps of 1 the linearised equations change by
        their own size.
    max_points
        Largest number of points to either side.
    t
        Time whose loads are taken [s].
    resume, point
        An earlier boundary of the same scene and keys, continued from its point of this number.
    callback
        A function that is called with every point: both numbers in SI units, and the frequency
        [Hz].

    Returns
    -------
    xarray.Dataset
        One dimension along the boundary: both numbers as a and b, frequency [Hz] (0 of divergence);
        special points, special_kind "corner" (two motions begin at once), "zero frequency" (flutter
        and divergence at once) or "cusp" with special_a, special_b, special_frequency and
        special_after, the point that each comes after. Its attributes say what begins there, and
        why it ends.

    Raises
    ------
    InputError
        For numbers that cannot be varied, and for ranges that are not allowed.
    AnalysisError
        If no motion begins to grow in the range.
    BranchInterrupted
        On Ctrl-C. It carries the points so far.

    Examples
    --------
    With vanishing damping Ziegler's pendulum flutters at 41/28 of k/l:

    >>> import rodgen
    >>> scene = rodgen.Scene.example("ziegler").replace({"loads.material_damping.time": 0.1})
    >>> keys = ("loads.follower.force", "loads.material_damping.time")
    >>> line = rodgen.stability_boundary(scene, keys, bounds=(None, (0.0, 1.0)))
    >>> round(float(line.a[line.b == 0].item()), 9), round(41 / 28, 9)
    (1.464285714, 1.464285714)
    """
    system = System.of(system)
    check_analysis_memory(BOUNDARY, system)
    scene = system.scene
    a_key, b_key = _check_keys(scene, keys)
    load, flipped = _find_load(scene, a_key, b_key)
    if flipped:
        bounds = bounds[::-1]
        a_key, b_key = b_key, a_key
    own = np.array(
        [_start_value(scene, key, given) for key, given in zip((a_key, b_key), bounds, strict=True)]
    )
    if load is not None and not own[0]:  # of a load's angle nothing would be felt without the load
        own[0] = scene.distribution.mean_stiffness / scene.rod.length**2
    # Numbers may take the place of laws in time, which then need not be known at t.
    system = system.at(dict(zip((a_key, b_key), own.tolist(), strict=True))).steady(t)
    plane = ParameterPlane(system, (a_key, b_key), own)
    if plane.base.is_light:
        raise AnalysisError(
            "a boundary needs links that all have a mass; 1e-4 of that of the bodies is enough"
        )
    scales = [_choose_scale(plane, axis, bounds[axis]) for axis in (0, 1)]
    begin = np.where([one.damping and not x for one, x in zip(scales, own, strict=True)], 1.0, 0.0)
    begin = own + begin * [one.unit for one in scales]
    limits = [_coordinate_bounds(one, given) for one, given in zip(scales, bounds, strict=True)]
    rows = [] if resume is None else _read_points(resume, scene, keys, point)
    places = [(row[:2][::-1] if flipped else row[:2]) for row in rows]
    if rows:
        begin, omega = np.array(places[0]), 2 * np.pi * rows[0][2]
        if load is not None:
            scales[0] = Scale(abs(float(begin[0])) / 4 or 1.0)
            limits[0] = _coordinate_bounds(scales[0], bounds[0])
    elif load is not None:
        found = _critical_load(system.at({b_key: float(begin[1])}), load, own[0])
        begin[0], omega = found.value, 2 * np.pi * found.frequency
        scales[0] = Scale(abs(found.value) / 4 or 1.0)
        limits[0] = _coordinate_bounds(scales[0], bounds[0])
    # Damping is to be nothing but rounding of its own where it is small.
    origin = np.where([one.damping for one in scales], 0.0, begin)
    plane = ParameterPlane(system, (a_key, b_key), origin)
    plane.interpolate_if_bilinear(np.array([one.unit for one in scales]))
    if load is None and not rows:
        begin[0], omega = _first_crossing(plane, scales[0], limits[0], float(begin[1]))
    if resume is None:
        damped = bool(np.abs(plane.matrices(*begin.tolist()).S1).any())
    else:  # of which the limit of no damping is a point, too
        damped = bool(resume.attrs["damped"])
    boundary = BoundaryProblem(plane, (scales[0], scales[1]), omega, damped)
    _check_start(boundary, begin, limits)
    outline = OutlineTracer(limits, StepControl.of(step, max_points, 4), callback)
    if rows:
        points = [
            boundary.pack(2 * np.pi * (row[2] or rows[0][2]), *place)
            for row, place in zip(rows, places, strict=True)
        ]
        curve = outline.resume(boundary, points)
    else:
        curve = outline.trace(boundary, omega, float(begin[0]), float(begin[1]))

    def whole_dataset() -> xarray.Dataset:
        made = _dataset(scene, boundary, curve, flipped, plane.base.t)
        return made if resume is None else extend(resume, point, made)

    return make_dataset(curve, whole_dataset)


def _check_start(boundary: BoundaryProblem, begin: Array, limits: list[Ends]) -> None:
    """Raise AnalysisError for a boundary that begins outside the range of a number."""
    plane = boundary.plane
    for key, scale, value, (low, high) in zip(
        plane.keys, boundary.scales, begin.tolist(), limits, strict=True
    ):
        if not low - OUTSIDE <= scale.coordinate(value) <= high + OUTSIDE:
            ends = f"{scale.value(low):.6g} to {scale.value(high):.6g}"
            where = ", ".join(
                f"{k} = {x:.9g}" for k, x in zip(plane.keys, begin.tolist(), strict=True)
            )
            raise AnalysisError(
                f"the boundary begins at {where}, outside the range of {key}, {ends}; give a wider "
                "range, or another value of the other number in the scene"
            )


def _read_points(
    data: xarray.Dataset, scene: Scene, keys: tuple[str, str], at: int
) -> list[tuple[float, float, float]]:
    """Read both numbers and the frequency [Hz] of a saved point, and of its neighbour, if any."""
    numbers = FORMAT.resume_numbers(data, scene, dict(zip("ab", keys, strict=True)), at)
    a, b, frequency = (data[name].values.tolist() for name in ("a", "b", "frequency"))
    return [(a[row], b[row], frequency[row]) for row in numbers]


def _first_crossing(
    plane: ParameterPlane, scale: Scale, limits: Ends, b: float
) -> tuple[float, float]:
    """Find the first value of the first number at which a motion begins or ceases to grow, and the
    frequency of this motion [rad/s]."""

    def growth_at(x: float) -> tuple[int, complex]:
        s = eigenvalues_at(plane, scale.value(x), b)
        return count_growing(s), complex(s[np.argmax(s.real)])

    xs = np.linspace(*limits, GRID)
    low, before = float(xs[0]), growth_at(float(xs[0]))[0]
    for high in xs[1:].tolist():
        if growth_at(high)[0] != before:
            break
        low = high
    else:
        raise AnalysisError(
            f"no motion begins or ceases to grow along {plane.keys[0]} from "
            f"{scale.value(limits[0]):.6g} to {scale.value(limits[1]):.6g}, at "
            f"{plane.keys[1]} = {b:.6g}"
        )
    while high - low > NARROW * max(abs(high), 1e-3):
        middle = (low + high) / 2
        if growth_at(middle)[0] == before:
            low = middle
        else:
            high = middle
    s = growth_at(high if growth_at(high)[0] else low)[1]
    return scale.value(high), abs(s.imag) if abs(s.imag) > abs(s.real) else 0.0


def _critical_load(system: System, load: str, own: float) -> Critical:
    """Critical value of a load; for a scene that is unstable without it, the next one beyond the
    scene's own value."""
    try:
        return critical_load(system, load=load)
    except AnalysisError:
        if not own > 0:
            raise
        return critical_load(system, load=load, bounds=(own, None))


def _choose_scale(plane: ParameterPlane, axis: int, given: Ends | None) -> Scale:
    """Choose the coordinate of a number: linear between given bounds, else by its logarithm. A
    number that scales damping alone has a share of critical damping as its unit."""
    own = float(plane.origin[axis])
    size = abs(own) or 1.0
    try:
        here = plane.evaluate(*plane.origin)
        there = plane.evaluate(*(plane.origin + size * np.eye(2)[axis]))
    except (AnalysisError, InputError):
        return Scale(size)
    change = there.add(here, -1.0).multiply(1 / size)
    same = all(
        np.abs(part).max() <= SAME * np.abs(whole).max()
        for part, whole in ((change.S0, here.S0), (change.S2, here.S2))
    )
    turned = np.abs(size * change.S1).max() > SAME * np.abs(here.S1).max(initial=0.0)
    if same and not (turned and change.S1.any()):
        allowed = "numbers that small motions depend on"
        raise InputError("vary", plane.keys[axis], allowed)
    moved = slice(0, len(here.S0) - plane.n_added_states)  # other states have no inertia
    K, M, K_change, C_change, M_change = (
        part[moved, moved] for part in (here.S0, here.S2, change.S0, change.S1, change.S2)
    )
    squares, shapes = np.linalg.eig(np.linalg.solve(M, K))
    order = np.argsort(np.abs(squares))
    squares, shapes = squares[order], shapes[:, order]
    first = int(np.argmax(np.abs(squares) > 1e-9 * np.abs(squares).max()))
    rate, shape = float(np.sqrt(abs(squares[first]))), shapes[:, first].real
    if same:
        drag = abs(shape @ C_change @ shape) / abs(shape @ M @ shape)
        return Scale(2 * SHARE * rate / drag if drag else size, damping=True)
    if given is not None:
        return Scale((given[1] - given[0]) / 4, curved=False)
    felt = abs(shape @ (K_change - rate**2 * M_change) @ shape) / abs(shape @ K @ shape)
    return Scale(max(abs(own), 1 / felt if felt else 1.0) / 4)


def _coordinate_bounds(scale: Scale, given: Ends | None) -> Ends:
    """Bounds of the coordinate of a number: those given, or from 0 to its largest value."""
    if given is not None:
        low, high = given
        return scale.coordinate(low), scale.coordinate(high)
    return 0.0, scale.coordinate((HUGE if scale.damping else LARGEST) * scale.unit)


def _find_load(scene: Scene, a: str, b: str) -> tuple[str | None, bool]:
    """Name of the load whose size one key is, if any, and whether that is the second key."""
    for key, flipped in ((a, False), (b, True)):
        for name in scene.loads.terms:
            term = scene.structure.load_rows[name]
            if term.has_size and scene.key_of(term.size_parameters[0].name) == key:
                return term.name, flipped
    return None, False


def _check_keys(scene: Scene, keys: Any) -> tuple[str, str]:
    if isinstance(keys, str) or len(keys) != 2 or keys[0] == keys[1]:
        raise InputError("vary", keys, "two different numbers of the scene")
    for key in keys:
        scene.value_of(str(key))
    return str(keys[0]), str(keys[1])


def _number_or_zero(scene: Scene, key: str) -> float:
    """Value of a key as a number: 0 for a function of time or an absent one."""
    value = scene.value_of(key)
    return float(value) if is_number(value) else 0.0


def _start_value(scene: Scene, key: str, given: Ends | None) -> float:
    """The scene's value of a key, or, outside of given bounds, their middle."""
    own = _number_or_zero(scene, key)
    if given is None:
        return own
    low, high = check_bounds(given)
    if not high - low > NARROWEST * max(abs(low), abs(high)):
        least = f"by more than {NARROWEST:g} of it" if low < high else "where its range begins"
        allowed = f"(a, b) of {key} with b above {low:.9g}, {least}"
        raise InputError("bounds", given, allowed)
    return own if low <= own <= high else float((low + high) / 2)


def _dataset(
    scene: Scene, boundary: BoundaryProblem, curve: Curve, flipped: bool, t: float
) -> xarray.Dataset:
    rows = np.array([point.u for point in curve.points])
    special = np.array([one.u for one in curve.special]).reshape(-1, 4)
    a, b = (1, 0) if flipped else (0, 1)
    keys = boundary.plane.keys
    names = {"a": keys[a], "b": keys[b]}
    values = {
        "a": rows[:, a],
        "b": rows[:, b],
        "frequency": rows[:, 2],
        "length": np.cumsum([0.0, *np.abs(np.diff(rows[:, 3]))]),
        "special_a": special[:, a],
        "special_b": special[:, b],
    }
    said = names | {
        "kind": FLUTTER if boundary.omega else DIVERGENCE,
        "damped": int(boundary.damped),
    }
    return FORMAT.dataset(scene, curve, t, values, said, **names)
