"""Linear models of scenes about an equilibrium, in flight, or about any state."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rodgen.analyse.analysis_guard import LINEAR, check_analysis_memory, guard_analysis
from rodgen.analyse.linear_model import ROUNDED, LinearModel
from rodgen.analyse.linear_signals import ADDED, LinearPoint, check_names, state_unit
from rodgen.analyse.steady_rod import SteadyRod, state_after
from rodgen.analyse.steady_state import find_steady_state, kinked_loads
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.air_doubts import air_doubts
from rodgen.integrate.quantity_formulas import MotionSlice
from rodgen.result import Note, doubt, remarks
from rodgen.scene import Scene
from rodgen.system import System
from rodgen.system.freezing import load_time

STEADY, START = "steady", "start"


class _Point(NamedTuple):
    """Where a scene is linearised: the system, the time [s], the state (states,), and in words."""

    system: System
    t: float
    state: Array
    about: str
    notes: tuple[Note, ...]


@guard_analysis
def linearise(
    system: System | Scene,
    inputs: Iterable[str] = (),
    outputs: Iterable[str] | None = None,
    *,
    about: str | ArrayLike = STEADY,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
) -> LinearModel:
    """Linearise a scene: matrices A, B, C and D for the control of a rod.

    All derivatives are exact, by the derivation: those of the parts `jac` and `inputs` of the
    module. The states are those of the module, so that A is the Jacobian of its rhs, also in flight
    at a speed that changes. What is constant is in `rates`; the loads are those of one time.

    Parameters
    ----------
    system
        The scene, or a System.
    inputs
        What acts: keys of numbers of loads, such as loads.follower.angle or air.wind.0; added
        states, such as states.gimbal, which are inputs then and no states; and numbers of
        [parameters] that laws of loads and rates of states name, such as parameters.command. Of a
        key that is an expression the input adds to its value.
    outputs
        What is measured: states, such as phi_3 or vx0; quantities, such as bending_moment_3, tip_x,
        joint_2_y, centre_of_gravity_x, attack_fins or airspeed_nose; and expressions of sensors and
        states, such as omega(0.3) or "x(1) - x(0)". By default all states.
    about
        "steady": at rest in equilibrium, or in straight flight, as natural_modes does; "start": the
        state at the start; or a state (states,) in SI units, in the order of the module's STATE.
    t
        Time whose loads are taken [s]; by default the start of the span.
    speed
        Speed of a free rod in steady flight along its axis, nose first [m/s]; by default the part
        of the scene's initial velocity along it.
    after
        Linearise about the state of a run of the scene after this time [s].

    Returns
    -------
    LinearModel
        Matrices with names and units; reduced models and other libraries' by its methods.

    Raises
    ------
    InputError
        For names and values that cannot be used.
    AnalysisError
        If there is no steady state.

    Examples
    --------
    >>> import rodgen
    >>> column = rodgen.Scene.example("becks_column").replace({"rod.links": 4})
    >>> model = rodgen.linearise(column, ["loads.follower.angle"], ["phi(1)"])
    >>> model.static_gain.shape, model.input_units, model.output_units
    ((1, 1), ('rad',), ('rad',))
    """
    system = System.of(system)
    keys = check_names(inputs, "inputs")
    measured = None if outputs is None else check_names(outputs, "outputs")
    check_analysis_memory(LINEAR, system)
    found = _find_point(system, about, t, speed, after)
    names = tuple(found.system.model("numpy").STATE)
    taken = [key.removeprefix(f"{ADDED}.") for key in keys if key.startswith(f"{ADDED}.")]
    kept = np.array([at for at, name in enumerate(names) if name not in taken], dtype=np.intp)
    states = tuple(names[at] for at in kept)
    measured = [*states] if measured is None else measured
    point = LinearPoint.of(found.system, measured, found.t, found.state)
    into, out = [*map(point.input, keys)], [*map(point.output, measured)]
    size, n_inputs = len(point.state), len(point.model.INPUTS)
    moved = _rows([one.states for one in into], size).T
    weights = _rows([one.weights for one in into], n_inputs).T
    more = _rows([one.rates for one in into], size).T
    by_state = _rows([one.by_state for one in out], size)
    by_inputs = _rows([one.by_inputs for one in out], n_inputs)
    by_rates = _rows([one.by_rates for one in out], size)
    B = point.by_state @ moved + point.by_inputs @ weights + more
    rates = point.rates[kept]
    parts = point.by_state[np.ix_(kept, kept)], B[kept], by_state[:, kept], rates
    if not all(np.isfinite(part).all() for part in parts):
        raise AnalysisError("the equations have no derivative in this state")
    model = LinearModel(
        A=parts[0],
        B=parts[1],
        C=parts[2],
        D=by_state @ moved + by_inputs @ weights + by_rates @ more,
        rates=rates,
        states=states,
        state_units=tuple(map(state_unit, states)),
        point=found.state[kept],
        inputs=tuple(keys),
        input_units=tuple(one.unit for one in into),
        input_values=np.array([one.value for one in into]),
        outputs=tuple(measured),
        output_units=tuple(one.unit for one in out),
        output_values=np.array([one.value for one in out]),
        basis=np.eye(len(kept)),
        about=found.about,
        notes=found.notes,
        system=found.system.steady(found.t),
    )
    return model.with_notes((*_kink_doubts(point), *_motion_remarks(model)))


def _rows(vectors: Sequence[Array], width: int) -> Array:
    """Matrix (vectors, width) of vectors, of which there may be none."""
    return np.reshape(vectors, (len(vectors), width))


def _find_point(
    system: System, about: Any, t: float | None, speed: float | None, after: float | None
) -> _Point:
    """Find the state that is asked for. Raises InputError, AnalysisError."""
    words = isinstance(about, str)
    if words and about not in (STEADY, START):
        raise InputError("about", about, f"{STEADY}, {START} or a state (states,)")
    if after is not None:
        if not (words and about == STEADY):
            raise InputError("after", after, f"absent: the state is that of about = {about!r}")
        system, t = state_after(system, t, speed, after)
        return _given_point(system, t, system.y0, f"the state after {after:g} s")
    if words and about == STEADY:
        return _steady_point(system, t, speed)
    if speed is not None:
        raise InputError("speed", speed, f"absent: the state has one (about = {about!r})")
    if words:
        return _given_point(system, t, system.y0, "the state at the start")
    try:
        y = system.at(y0=[] if about is None else about).y0
    except InputError as error:
        raise InputError("about", about, f"{STEADY}, {START} or {error.allowed}") from None
    return _given_point(system, t, y, "a state that was given")


def _given_point(system: System, t: float | None, y: Array, about: str) -> _Point:
    t = load_time(system.source, t) if system.t is None else system.steady(t).t
    assert t is not None
    here = system.steady(t)
    motion = MotionSlice(here.model("numpy"), here.p, y, np.asarray(t))
    return _Point(system, t, y, about, tuple(air_doubts(here.scene, motion)))


def _steady_point(system: System, t: float | None, speed: float | None) -> _Point:
    rod = SteadyRod.of(system, t, speed)
    state = find_steady_state(rod)
    y = rod.state_in_flight(state.at)
    if rod.n_base and not (rod.has_supports or rod.has_feedback):
        y[: rod.n_base] = rod.system.y0[: rod.n_base]
    return _Point(system, rod.t, y, state.description, state.notes)


def _kink_doubts(point: LinearPoint) -> Iterator[Note]:
    """Yield the doubt about loads that have no derivative at rest."""
    half = len(point.system.y0) - len(point.system.structure.state_names)
    if point.state[half // 2 : half].any():
        return
    for name in kinked_loads(point.system, point.system.p):
        text = f"loads.{name} has no derivative at rest, where its force depends on the direction "
        yield doubt(f"{text}of the motion: it is left out")


def _motion_remarks(model: LinearModel) -> tuple[Note, ...]:
    """Remarks on what changes where it is linearised."""
    if model.in_equilibrium:
        return ()
    moved = {"m", "rad"}  # units of positions, whose rates are velocities
    gained = [
        abs(rate)
        for rate, unit in zip(model.rates.tolist(), model.state_units, strict=True)
        if unit not in moved
    ]
    if max(gained, default=0.0) <= ROUNDED * np.abs(model.A).max(initial=0.0):
        return ()
    text = "it accelerates in this state: rates are what it does without inputs, and A is of this "
    return remarks((f"{text}instant",))
