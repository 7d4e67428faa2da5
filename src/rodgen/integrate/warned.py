"""What a run is warned of before its first step: a step or a tolerance that will not do."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

from rodgen.integrate.methods.choose import warn_of_tolerance
from rodgen.integrate.stability import warn_of_step
from rodgen.integrate.stepper import Array
from rodgen.scene import Scene
from rodgen.scene.errors import short

PULSE = 4  # steps that a pulse takes at least to be felt
MANY = 10**4  # steps over which a method that does not keep energy feeds what nothing damps
DAMPS = {"internal_damping", "external_damping"}
SWING = 3  # steps that a period takes at least, not to be taken for a longer one


def step_warnings(scene: Scene, model: ModuleType, p: Array) -> Iterator[str]:
    """What is wrong with step or tolerance of a scene, in sentences; its method is chosen."""
    settings = scene.integrate
    for load in scene.timed.values():
        if not load.followed(*settings.span):
            yield (
                f"{load.field} = {short(load.text)}: changes more often in the span than can be "
                "looked at, and may be taken for another load; give it a shorter span"
            )
    if not settings.fixed:
        text = warn_of_tolerance(scene, model)
        if text:
            yield text
    if settings.step is None or not settings.fixed:
        return
    (start, end), y0 = settings.span, scene.initial_state()
    text = warn_of_step(settings.method, settings.step, end - start, model, start, y0, p)
    if text:
        yield text
    yield from _passed_over(scene, settings.step)
    half = scene.swing()
    if 2 * half < SWING * settings.step:
        yield (
            f"a load swings with a period of {2 * half:.2g} s, for which the step of "
            f"{settings.step:g} s is too long; take a smaller step, or dop853"
        )


def drift_warning(scene: Scene) -> str | None:
    """That a method will not keep the energy of a scene in which nothing is damped, in a sentence,
    or None."""
    settings = scene.integrate
    if settings.method != "semi_implicit_euler" or DAMPS & set(scene.structure.terms):
        return None
    assert settings.step is not None
    steps = (settings.span[1] - settings.span[0]) / settings.step
    if steps < MANY:
        return None
    return (
        f"semi_implicit_euler over {steps:.2g} steps: nothing damps this rod, and the method does "
        "not keep its energy (its mass matrix changes with the angles); take gauss with a step, or "
        "dop853"
    )


def _passed_over(scene: Scene, step: float) -> Iterator[str]:
    """The first pulse of a load that is too short for a fixed step [s]."""
    breaks, pole = scene.breaks(), scene.pole()
    for begin, peak, over in () if pole else scene.pulses():
        met = any(begin <= at <= over for at in breaks)  # and stepped onto
        if begin < peak < over < begin + PULSE * step and not met:
            yield (
                f"a load changes within {over - begin:.2g} s at t = {begin:.6g} s, for which "
                f"the step of {step:g} s is too long; take a smaller step, or dop853"
            )
            return
