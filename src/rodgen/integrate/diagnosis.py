"""Doubts about a run before its first step, why it stopped, and advice."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from rodgen.arrays import Array
from rodgen.errors import shorten
from rodgen.integrate.contact_press import all_presses
from rodgen.integrate.methods.method_choice import tolerance_doubt
from rodgen.integrate.stability import step_doubt
from rodgen.integrate.stretches import Integrator, Pole
from rodgen.model.methods import COLLOCATION
from rodgen.model.terms import TERMS
from rodgen.result import Note, doubt
from rodgen.scene import Scene
from rodgen.scene.integration import IntegrationTable
from rodgen.scene.time_laws import MOST_FRONTS
from rodgen.system import System
from rodgen.system.plausibility import count_doubts as of_angles

PULSE = 4  # steps that a pulse takes at least to be felt
SEMI_IMPLICIT = "semi_implicit_euler"
MANY = 10**4  # steps over which a method that does not keep energy feeds what nothing damps
SWING = 3  # steps that a period takes at least, not to be taken for a longer one
MOST_TURNED = 1e15  # rad, where neighbouring doubles are an eighth of a radian apart
NEAR = 1e-3  # share of the way to a pole within which it is what stops a run


def count_doubts(system: System, model: ModuleType, p: Array, y0: Array) -> NDArray[np.intp]:
    """Count the doubts about each of many runs: p (runs, width), y0 (runs, states); steps and
    tolerance are looked at for one of them, system."""
    same = len(system.unused_names) + sum(1 for _ in step_doubts(system, model))
    return of_angles(system.structure, p, y0) + same


def step_doubts(system: System, model: ModuleType) -> Iterator[Note]:
    """Yield the doubts about the steps of a run before the first: about their length or tolerance,
    and thrust whose table is shorter than the span; its method is chosen."""
    settings = system.settings
    yield from _table_doubts(system)
    for load in system.time_laws.loads:
        if not load.is_resolvable(*settings.span):
            yield doubt(
                f"{load.field} = {shorten(load.text)}: changes more often in the span than can be "
                "looked at, and may be taken for another load; give it a shorter span"
            )
    for law in system.time_laws.crowded_expressions():
        yield doubt(
            f"{law.field} = {shorten(law.text)}: it is not smooth at places that pass more points "
            f"of the links than the {MOST_FRONTS} times that steps end at; they are passed over, "
            "and digits are lost there: give it a shorter span, or tighten rtol",
            most=MOST_FRONTS,
        )
    drifts = drift_doubt(system)
    if settings.step is None or not settings.has_fixed_step:
        yield from filter(None, (drifts, tolerance_doubt(system, model)))
        return
    (start, end), y0 = settings.span, system.y0
    long = step_doubt(settings.method, settings.step, end - start, model, start, y0, system.p)
    for near in () if long else all_presses(model, start, y0, system.p):
        of = settings.method, settings.step, end - start, model
        if not long and (touching := step_doubt(*of, start, y0, near)) is not None:
            long = doubt(f"while contacts are pressed, {touching.text}", **touching.figures)
    yield from filter(None, (drifts, long))
    yield from _pulse_doubts(system, settings.step)
    half = system.time_laws.half_period()
    if 2 * half < SWING * settings.step:
        words = f"a load swings with a period of {2 * half:.2g} s, for which the step of "
        words += f"{settings.step:g} s is too long; take a smaller step, or dop853"
        yield doubt(words, period=2 * half, step=settings.step)


def _table_doubts(system: System) -> Iterator[Note]:
    """Doubts about thrusts that keep the first value of a table before it, or the last after it."""
    start, end = system.settings.span
    tables = {name: law for name, law in system.time_dependent_loads.items() if law.has_table}
    loads = map(TERMS.__getitem__, system.load_terms if tables else ())
    thrusts = {one.name for term in loads if term.follows for one in term.size_parameters}
    for name in sorted(thrusts & tables.keys()):
        thrust = tables[name]
        # Breaks of a table of something else than the time itself.
        if not (knots := thrust.knots() or thrust.breaks(start, end)):
            continue
        first, last = knots[0], knots[-1]
        for at, beyond in (first, min(start, first)), (last, max(end, last)):
            value = float(thrust(beyond))
            if at != beyond and value and value == float(thrust((at + beyond) / 2)):
                low, high = sorted((at, beyond))
                words = f"{system.key_of(name)} = {shorten(thrust.text)}: the table has no value "
                words += f"from {low:g} to {high:g} s, where the thrust keeps {value:g} N"
                yield doubt(words, start=low, end=high, force=value)


def drift_doubt(system: System) -> Note | None:
    """Return the doubt whether a method keeps the energy of a scene in which nothing is damped, or
    None."""
    settings = system.settings
    if settings.method != SEMI_IMPLICIT or any(TERMS[one].is_damping for one in system.load_terms):
        return None
    assert settings.step is not None
    steps = (settings.span[1] - settings.span[0]) / settings.step
    if steps < MANY:
        return None
    words = (
        f"semi_implicit_euler over {steps:.2g} steps: nothing damps this rod, and the method does "
        "not keep its energy (its mass matrix changes with the angles); take gauss with a step, or "
        "dop853"
    )
    return doubt(words, steps=steps)


def _pulse_doubts(system: System, step: float) -> Iterator[Note]:
    """Doubt about the first pulse of a load that is too short for a fixed step [s]."""
    laws = system.time_laws
    breaks = laws.breaks()
    for begin, peak, over in () if laws.first_pole() else laws.pulses():
        met = any(begin <= at <= over for at in breaks)  # and stepped onto
        if begin < peak < over < begin + PULSE * step and not met:
            words = f"a load changes within {over - begin:.2g} s at t = {begin:.6g} s, for which "
            words += f"the step of {step:g} s is too long; take a smaller step, or dop853"
            yield doubt(words, lasts=over - begin, t=begin, step=step)
            return


def failure_message(error: ArithmeticError, scene: Scene, machine: Integrator, pole: Pole) -> str:
    """Message of a stopped run: where, why, and what to try; scene: with the span it was in."""
    why = _load_clause(scene, machine, pole)
    tip = advice(str(error), scene.integrate, bool(why))
    why = why or _angle_clause(scene, machine)
    return f"stopped at t = {machine.t:.9g} s: {error}{why}; {tip}"


def _load_clause(scene: Scene, machine: Integrator, pole: Pole) -> str:
    """Clause on the load that is not finite where a run stopped, and when; else empty."""
    asked = machine.load_times
    for force in scene.time_laws.loads:
        broken = [at for at in asked if not np.isfinite(force(at))]
        if broken:
            return f"; {force.not_finite_message(min(broken))} s"
    if pole:
        at, force = pole
        near = at - machine.t <= NEAR * (at - scene.integrate.span[0])
        if near or max(asked, default=at) >= at:
            return f"; {force.not_finite_message(at)} s"
    return ""


def _angle_clause(scene: Scene, machine: Integrator) -> str:
    """Clause on an angle of so many turns that it has no sine; else empty."""
    half = (len(machine.y) - len(scene.states)) // 2
    angles = machine.y[2 * scene.boundary_condition.translates : half]
    beyond = np.abs(angles).max(initial=0.0) > MOST_TURNED
    return f"; an angle is beyond {MOST_TURNED:g} rad, where it has no sine" if beyond else ""


def advice(reason: str, settings: IntegrationTable, load: bool) -> str:
    """Advice for a reason why a run stopped; load: a load was the cause."""
    if "chatters" in reason:
        return "give the law a slope there, as of max(-1, min(1, x/0.01)), or a hysteresis"
    if "bounces" in reason:
        return "soften the contact (stiffness), or end the span where it comes to rest"
    if load:
        return "end the span before that time, or give the load another expression"
    if "budget" in reason:
        other = "dop853" if settings.method in COLLOCATION else "radau or gauss"
        return f"raise max_steps, loosen the tolerance, or try {other}; the motion may be growing"
    if settings.has_fixed_step:
        return (
            "try a smaller step, or a method with error control (auto); if it stops there too, the "
            "motion itself grows without bound"
        )
    if "Newton" in reason:
        return "try a looser tolerance, or the explicit dop853"
    if "too small" in reason or "no further" in reason or "gave up" in reason:
        return "try a looser tolerance, another method (auto, radau, dop853), or a shorter span"
    return "look at the last samples: the motion itself may grow without bound; check the loads"
