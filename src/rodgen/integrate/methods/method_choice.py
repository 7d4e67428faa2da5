"""Choice of the method for a scene, its own or by `auto`'s rule, and of its integrator."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType

from rodgen.arrays import Array
from rodgen.integrate.methods.compiled_integrator import CompiledIntegrator
from rodgen.integrate.methods.python_integrator import PythonIntegrator
from rodgen.integrate.stability import Dominant, dominant, step_limit
from rodgen.integrate.stepper import StepError
from rodgen.integrate.stretches import Integrator
from rodgen.model.methods import COLLOCATION
from rodgen.result import Note, doubt
from rodgen.scene import Scene
from rodgen.scene.integration import AUTO, MOST_ADAPTIVE, IntegrationTable
from rodgen.system import System

# Measured at equal error on random scenes, see docs/methods.md.
FEW = 4e3  # radians or decays, at FEW_AT, of a fastest motion that explicit steps follow in no time
FEW_AT, FEW_POWER = 1e-4, 0.11  # a tolerance; radau's steps shrink more with it than dop853's
TRANSIENT = 0.6  # damping ratio from which the fastest motion dies out soon after the start
LONG, GONE = 100.0, 1e3  # times FEW, and e-folds, after which one with less damping is gone too
GROWS = 1e-3  # share of the rate from which a motion is taken to grow by itself
MANY = 1e6  # radians beyond which following an oscillation takes long
LOOSE = 1e-4  # tolerance from which on it is then taken for noise
# Damping ratio and radians of a fastest motion of which gauss gives wrong rates in most runs.
SWINGS, SOME = 0.1, 500.0
LEAST_NEWTON = 1e-13  # tolerance below which rounding in the iterations is larger


@dataclass(frozen=True)
class Choice:
    """A method, and why."""

    method: str
    reason: str


def choose(system: System | Scene, model: ModuleType) -> Choice:
    """Return the method of a scene: its own, or what `auto` takes it to need.

    What counts is the fastest motion at the start, its frequency and damping, against the span and
    the tolerance. With the number of links n, that frequency grows as n^2.

    Parameters
    ----------
    system
        The scene, or a System.
    model
        Its module, from `build`.

    Returns
    -------
    Choice
        `method`, and why.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("missile")
    >>> rodgen.choose(scene, rodgen.build(scene)).method
    'dop853'
    """
    system = System.of(system)
    return choose_from(system.settings, model, system.p, system.y0)


def choose_from(settings: IntegrationTable, model: ModuleType, p: Array, y: Array) -> Choice:
    """Choose the method for a run from a state under parameters."""
    if settings.method != AUTO:
        return Choice(settings.method, "the scene asks for it")
    start, end = settings.span
    try:
        fastest = dominant(model, _after_start(settings), y, p)
    except StepError:
        return Choice("dop853", "the rates at the start are not finite, of which the run will tell")
    return choose_by_rule(fastest, end - start, settings.rtol, settings.step_limit)


def choose_by_rule(
    fastest: Dominant, span: float, rtol: float, budget: int = MOST_ADAPTIVE
) -> Choice:
    """Choose a method by the rule from fastest motion, span [s], tolerance and budget of steps."""
    cycles = fastest.rate * span
    words = describe_motion(fastest)
    motion = f"the fastest motion ({words}) makes {cycles:.2g} radians in the span"
    if cycles < _few(rtol):
        return Choice("dop853", f"{motion}, few enough to follow")
    grows = max(fastest.value.real, fastest.partner.real) > GROWS * fastest.rate
    gone = cycles > LONG * _few(rtol) and fastest.damping * cycles > GONE
    if (fastest.damping > TRANSIENT or gone) and not grows:
        return Choice("radau", f"{motion}; it decays, and need not be followed")
    if rtol >= LOOSE and cycles > MANY:
        return Choice("gauss", f"{motion}, too many to follow at rtol {rtol:g}")
    steps = span / step_limit("dop853", fastest.value, fastest.partner)
    if steps > budget:
        why = f"more than explicit steps can follow ({steps:.2g}, of {budget:.2g} allowed)"
        return Choice("gauss", f"{motion}, {why}; if it is at rest, there is nothing to follow")
    return Choice("dop853", f"{motion}, and has to be followed")


def tolerance_doubt(system: System, model: ModuleType) -> Note | None:
    """Return the doubt whether a method with error control keeps to its tolerance, or None."""
    settings = system.settings
    method, rtol = settings.method, settings.rtol
    if method in COLLOCATION and rtol < LEAST_NEWTON:
        words = f"{method} at rtol {rtol:g}: its iterations leave rounding errors that are larger; "
        return doubt(f"{words}take {LEAST_NEWTON:g}, or dop853", rtol=rtol, least=LEAST_NEWTON)
    if method != "gauss":
        return None
    try:
        fastest = fastest_motion(system, model)
    except StepError:  # the run itself will say so
        return None
    span = settings.span[1] - settings.span[0]
    cycles = fastest.rate * span
    swings = fastest.damping < SWINGS and cycles > SOME
    if not swings and not (rtol >= LOOSE and cycles > FEW):
        return None
    better = choose_by_rule(fastest, span, rtol, settings.step_limit).method
    advice = f"; take {better}" if better != method else ""
    words = (
        f"gauss passes over the fastest motion ({describe_motion(fastest)}), in steps that keep "
        f"positions alone to rtol {rtol:g}: rates may be off by hundreds of tolerances, and angles "
        f"by tens{advice}"
    )
    return doubt(words, rtol=rtol, rate=fastest.rate, radians=cycles)


def _few(rtol: float) -> float:
    """Radians or decays of a fastest motion that explicit steps follow in no time."""
    return float(FEW * (FEW_AT / rtol) ** FEW_POWER)


def describe_motion(fastest: Dominant) -> str:
    """Describe a motion in words."""
    growth = max(fastest.value.real, fastest.partner.real)
    if growth > GROWS * fastest.rate:
        return f"{fastest.rate:.3g} 1/s, growing by itself"
    return f"{fastest.rate:.3g} rad/s, {max(0.0, 100 * fastest.damping):.3g} % of critical damping"


def fastest_motion(system: System, model: ModuleType) -> Dominant:
    """Find the fastest motion about the start of a scene. Raises StepError."""
    return dominant(model, _after_start(system.settings), system.y0, system.p)


def _after_start(settings: IntegrationTable) -> float:
    """Time just after the start of the span."""
    start, end = settings.span
    return start + 1e-9 * (end - start)


def make_integrator(
    model: ModuleType, p: Array, settings: IntegrationTable, t: float, y: Array
) -> Integrator:
    """Create the integrator of a run: compiled where the module has the method, else in Python."""
    kind = (
        CompiledIntegrator
        if settings.method in getattr(model, "COMPILED", ())
        else PythonIntegrator
    )
    return kind(model, p, settings, t, y)
