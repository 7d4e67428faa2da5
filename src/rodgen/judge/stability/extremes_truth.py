"""Second routes to a motion: other families of methods, and invariances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

import rodgen
from rodgen.judge.stability.extremes_case import ANGLES, Array, Extreme, Measure, Tables, Truth
from rodgen.scene.structure import TERMS

Route = Callable[[rodgen.Scene], Truth]
NUDGE = 1e-6  # of the motion at most: the start is moved by it, far above the errors of a run
TIGHT = 1e-13
DENSE = "numpy", "dense"
LOADS = (
    *("follower_force", "follower_angle", "gravity", "internal_damping", "external_damping"),
    *("tip_force_x", "tip_force_y"),
)


def tight(scene: rodgen.Scene) -> Truth:
    """SciPy's DOP853 at 1e-13 on the dense form, judged by our Radau at 1e-12 on the chain."""
    return _tight(scene.model_dump_json(exclude_none=True), "DOP853", "radau")


def stiff(scene: rodgen.Scene) -> Truth:
    """SciPy's Radau at 1e-11 on the dense form, judged by our DOP853 or Gauss on the chain."""
    return _tight(scene.model_dump_json(exclude_none=True), "Radau", "radau")


def switched(times: Sequence[float]) -> Route:
    """Of loads that jump at these times and are smooth between: SciPy's DOP853 at 1e-13 from jump
    to jump, judged by itself at 1e-11.

    Neither the scene's own break points nor rodgen's methods have a part in it.
    """

    def truth(scene: rodgen.Scene) -> Truth:
        y0 = scene.initial_state()
        y, other = (_scipy(scene, y0, "DOP853", rtol, times) for rtol in (TIGHT, 1e-11))
        return _judged(scene, y, other, "SciPy's DOP853 at 1e-13, from jump to jump")

    return truth


def compiled(scene: rodgen.Scene) -> Truth:
    """For many links: our DOP853 at 1e-10, judged by the classical Runge-Kutta method."""
    first, last = scene.integrate.span
    ours = _ours(scene, "dop853", 1e-10)
    step = (last - first) / (4000 if scene.rod.links <= 1000 else 400)
    other = rodgen.simulate(scene, method="rk4", step=step, target="c").y
    return _judged(scene, ours, other, "dop853 at 1e-10 against rk4")


@lru_cache(maxsize=8)
def _tight(text: str, method: str, judge: str) -> Truth:
    scene = rodgen.Scene.model_validate_json(text)
    y0 = scene.initial_state()
    rtol = TIGHT if method == "DOP853" else 1e-11
    y = _scipy(scene, y0, method, rtol)
    other = _ours(scene, judge, 1e-12)
    near = _judged(scene, y, other, f"SciPy's {method} at {rtol:g} on the dense form")
    measure = Measure(scene, y)
    # In proportion to what the tolerances allow in each kind, and so small that it grows linearly.
    tolerated, draw = measure.tolerated(), np.random.default_rng(7)
    by = NUDGE / max(tolerated.values())
    nudge = measure.parts(np.zeros_like(y0))
    for kind in nudge:
        scale = by * tolerated[kind] * measure.sizes[kind]
        nudge[kind][...] = scale * draw.choice([-1.0, 1.0], nudge[kind].shape)
    half = np.concatenate((nudge["places"], nudge[ANGLES], nudge["speeds"], nudge["rates"]))
    moved = measure.errors(_scipy(scene, y0 + half, method, rtol))
    grown = max(moved[kind] / by / tolerated[kind] for kind in moved if tolerated[kind])
    return Truth(near.y, near.by, near.error, max(1.0, grown))


def _judged(scene: rodgen.Scene, y: Array, other: Array, by: str) -> Truth:
    measure = Measure(scene, y)
    return Truth(y, by, error=max(measure.errors(other).values()))


def _scipy(
    scene: rodgen.Scene,
    y0: Array,
    method: str,
    rtol: float,
    breaks: Sequence[float] | None = None,
) -> Array:
    """SciPy's method on the dense form, from break point to break point: the scene's, or these."""
    rod = scene.structure
    # One module for all loads; those that a scene has not are zero.
    model = rodgen.build(rodgen.Structure(rod.links, rod.boundary, rod.inertia, TERMS), *DENSE)
    p = model.parameters(**{**dict.fromkeys(LOADS, 0.0), **scene.parameters})
    # Loads that change with time are put into p as they are asked for.
    timed = [(model.PARAMETERS.index(name), force) for name, force in scene.timed.items()]
    first, last = scene.integrate.span
    times = scene.integrate.samples
    rows, y = [y0[None]], y0
    # What is asked of the tight run is small beside the motion, whatever its unit of time.
    atol = rtol * 1e-3 * min(1.0, 1.0 / (last - first))
    more = {"jac": model.jac} if method == "Radau" else {}
    for a, b in pairwise([first, *(scene.breaks() if breaks is None else breaks), last]):
        low, high = a + 8 * np.spacing(abs(a)), b - 8 * np.spacing(abs(b))
        inside = times[(times > a) & (times < b)]

        def rates(t: float, y: Array, low: float = low, high: float = high) -> Array:
            for at, force in timed:
                p[at] = force(min(max(t, low), high))
            return np.asarray(model.rhs(t, y, p))

        jacobian = {k: lambda t, y, f=f: f(t, y, p) for k, f in more.items()}
        found = solve_ivp(
            rates, (a, b), y, method, rtol=rtol, atol=atol, dense_output=True, **jacobian
        )
        assert found.success, found.message
        if len(inside):
            rows.append(found.sol(inside).T)
        y = found.y[:, -1]
        if b in times:
            rows.append(y[None])
    return np.concatenate(rows)


def _ours(scene: rodgen.Scene, method: str, rtol: float) -> Array:
    first, last = scene.integrate.span
    atol = rtol * 1e-2 * min(1.0, 1.0 / (last - first))
    sol = rodgen.simulate(scene, method=method, rtol=rtol, atol=atol, target="c")
    return sol.y


def same_as(tables: Tables, carry: Callable[[Array], Array], route: Route = tight) -> Route:
    """By an invariance: the motion of other tables, carried over."""

    def truth(scene: rodgen.Scene) -> Truth:
        known = route(Extreme("", "", tables, route).scene)
        return Truth(carry(known.y), f"invariance; {known.by}", known.error, known.condition)

    return truth
