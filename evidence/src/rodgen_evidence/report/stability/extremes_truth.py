"""States of extreme cases by a second route: scenes that are equivalent, tighter, or stiff."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import rodgen
from rodgen.model.terms import THESIS_TERMS
from rodgen_evidence.report.stability.extremes_case import (
    ANGLES,
    Array,
    ExtremeCase,
    Measure,
    Tables,
    TrueMotion,
)

Route = Callable[[rodgen.Scene], TrueMotion]
NUDGE = 1e-6  # of the motion at most: the start is moved by it, far above the errors of a run
TIGHT = 1e-13
DENSE = "numpy", "dense"
TERMS = (*THESIS_TERMS, "tip_load")  # of all cases


def tight(scene: rodgen.Scene) -> TrueMotion:
    """SciPy's DOP853 at 1e-13 on the dense form, judged by our Radau at 1e-12 on the chain."""
    return _tight(scene.model_dump_json(exclude_none=True), "DOP853", TIGHT)


def stiff(scene: rodgen.Scene) -> TrueMotion:
    """SciPy's Radau at 1e-11 on the dense form, judged by ours at 1e-12 on the chain."""
    return _tight(scene.model_dump_json(exclude_none=True), "Radau", 1e-11)


def piecewise(times: Sequence[float]) -> Route:
    """Route for loads that jump at these times: SciPy's DOP853 at 1e-13 from jump to jump, judged
    by itself at 1e-11.

    Neither the scene's own break points nor rodgen's methods have a part in it.
    """

    def truth(scene: rodgen.Scene) -> TrueMotion:
        y0 = scene.initial_state()
        y, other = (_scipy(scene, y0, "DOP853", rtol, times) for rtol in (TIGHT, 1e-11))
        return _compare(scene, y, other, "SciPy's DOP853 at 1e-13, from jump to jump")

    return truth


def compiled_truth(scene: rodgen.Scene) -> TrueMotion:
    """Compute the motion of many links by our DOP853 at 1e-10, judged by the method rk4."""
    first, last = scene.integrate.span
    ours = _ours(scene, "dop853", 1e-10)
    step = (last - first) / (4000 if scene.rod.links <= 1000 else 400)
    other = rodgen.simulate(scene, method="rk4", step=step, target="c").y
    return _compare(scene, ours, other, "dop853 at 1e-10 against rk4")


@lru_cache(maxsize=8)
def _tight(text: str, method: str, rtol: float) -> TrueMotion:
    scene = rodgen.Scene.model_validate_json(text)
    y0 = scene.initial_state()
    y = _scipy(scene, y0, method, rtol)
    other = _ours(scene, "radau", 1e-12)
    near = _compare(scene, y, other, f"SciPy's {method} at {rtol:g} on the dense form")
    measure = Measure(scene, y)
    # In proportion to what the tolerances allow in each kind, and so small that it grows linearly.
    tolerated, draw = measure.allowances(), np.random.default_rng(7)
    by = NUDGE / max(tolerated.values())
    nudge = measure.parts(np.zeros_like(y0))
    for kind in nudge:
        scale = by * tolerated[kind] * measure.sizes[kind]
        nudge[kind][...] = scale * draw.choice([-1.0, 1.0], nudge[kind].shape)
    half = np.concatenate((nudge["places"], nudge[ANGLES], nudge["speeds"], nudge["rates"]))
    moved = measure.errors(_scipy(scene, y0 + half, method, rtol))
    grown = max(moved[kind] / by / tolerated[kind] for kind in moved if tolerated[kind])
    return TrueMotion(near.y, near.by, near.error, max(1.0, grown))


def _compare(scene: rodgen.Scene, y: Array, other: Array, by: str) -> TrueMotion:
    measure = Measure(scene, y)
    return TrueMotion(y, by, error=max(measure.errors(other).values()))


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
    whole = rodgen.Structure(rod.n_links, rod.boundary, rod.inertia, TERMS)
    model, given = rodgen.build(whole, *DENSE), {"fin_factor": None, **scene.parameters}
    p = model.parameters(**{name: given.get(name, 0.0) for name in whole.parameters})
    # Loads that change with time are put into p as they are asked for.
    timed = [
        (model.PARAMETERS.index(name), force) for name, force in scene.time_dependent_loads.items()
    ]
    first, last = scene.integrate.span
    times = scene.integrate.sample_times
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
    """Route by an invariance: the motion of other tables, carried over."""

    def truth(scene: rodgen.Scene) -> TrueMotion:
        known = route(ExtremeCase("", tables, route).scene)
        return TrueMotion(carry(known.y), f"invariance; {known.by}", known.error, known.condition)

    return truth


N, LENGTH, STIFFNESS, MASS, SPAN = 4, 2.0, 30.0, 3.0, 0.3
CRITICAL = 109.9 * STIFFNESS / LENGTH**2  # follower force at which a free rod flutters [N]


# Every load, none of it acting: with the module of `loaded`.
IDLE: Tables = {
    "follower": {"force": 0.0},
    "gravity": {"g": 0.0},
    "internal_damping": {"coefficient": 0.0},
    "external_damping": {"coefficient": 0.0},
}


def rod(links: int = N, span: float = SPAN, **tables: Any) -> Tables:
    """A rod of 2 m, 30 N m^2 and 3 kg, bent and turning, if not told otherwise."""
    shape = {"links": links, "length": LENGTH, "bending_stiffness": STIFFNESS, "mass": MASS}
    return {
        "name": "extreme",
        "rod": {**shape, **tables.pop("rod", {})},
        "initial": {"phi": "0.4*cos(pi*s)", "omega": "0.5*s", **tables.pop("initial", {})},
        "integrate": {"span": [0.0, span], **tables.pop("integrate", {})},
        **tables,
    }


def loaded_rod(length: float = 1.0, mass: float = 1.0, time: float = 1.0, links: int = N) -> Tables:
    """Rod under every load, with units of length, mass and time so many times larger."""
    force = mass * length / time**2
    return rod(
        links,
        span=SPAN * time,
        rod={
            "length": LENGTH * length,
            "bending_stiffness": STIFFNESS * force * length**2,
            "mass": MASS * mass,
        },
        loads={
            "follower": {"force": 40.0 * force, "angle": 0.1},
            "gravity": {"g": 9.81 * length / time**2},
            "internal_damping": {"coefficient": 0.2 * length**2 / time},
            "external_damping": {"coefficient": 0.7 / time, "fin_factor": {"tail": 5.0}},
        },
        initial={
            "position": [0.0, 1.0 * length],
            "velocity": [1.0 * length / time, 0.3 * length / time],
            "omega": f"{0.5 / time!r}*s",
        },
    )


def rescaling(length: float, time: float) -> Route:
    """Route from the motion in plain units to that in other ones."""

    def carry(y: Array) -> Array:
        half = y.shape[1] // 2
        q, u = y[:, :half].copy(), y[:, half:] / time
        q[:, :2] *= length
        u[:, :2] *= length
        return np.concatenate((q, u), axis=1)

    return same_as(loaded_rod(), carry)


def shifted_rod(tables: Tables, by: dict[str, float], route: Route = tight) -> tuple[Tables, Route]:
    """A free rod displaced by x, y, turned by phi or flying by vx, and how it moves then."""
    initial = dict(tables["initial"])
    x, y = initial.get("position", [0.0, 0.0])
    vx, vy = initial.get("velocity", [0.0, 0.0])
    dx, dy, turn, speed = (by.get(name, 0.0) for name in ("x", "y", "phi", "vx"))
    phi = initial["phi"]
    initial["position"], initial["velocity"] = [x + dx, y + dy], [vx + speed, vy]
    initial["phi"] = [a + turn for a in phi] if isinstance(phi, list) else f"{turn!r} + ({phi})"
    span = tables["integrate"]["span"]

    def carry(states: Array) -> Array:
        half = states.shape[1] // 2
        out = states.copy()
        t = np.linspace(0.0, span[1] - span[0], len(out))
        cos, sin = np.cos(turn), np.sin(turn)
        for at in (0, half):
            a, b = states[:, at].copy(), states[:, at + 1].copy()
            out[:, at], out[:, at + 1] = cos * a - sin * b, sin * a + cos * b
        out[:, 0] += dx + speed * t
        out[:, 1] += dy
        out[:, half] += speed
        out[:, 2:half] += turn
        return out

    return {**tables, "initial": initial}, same_as(tables, carry, route)
