"""The claims of the listing's steppers: what they call, and which scheme that is.

In place of the accelerations, which are claimed elsewhere, every evaluation gives letters: a1_i
the first, a2_i the second. The truth is rodgen's own method, run with the same letters.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np
from sympy import Expr, S, Symbol

from rodgen.derive.symbols import x0, y0
from rodgen.integrate.methods import euler, rk4, semi_implicit_euler

from .claim import Claim, Entries
from .java_members import FreeRodModel, symbolic
from .java_steps import (
    EVALUATE_C,
    EVALUATE_D,
    FINISH,
    METHODS,
    MOVE_FRESH,
    REPAIRED,
    Methods,
    complete,
    stepClassical,
    stepEuler,
    stepImprovedEuler,
    stepRungeKutta,
)
from .java_truth import H, indexed, joint_velocities, state_letters

Step = Callable[..., None]
STEPPERS: tuple[Step, ...] = (stepEuler, stepImprovedEuler, stepRungeKutta)


class Recorder(dict[str, Callable[[FreeRodModel], None]]):
    """Methods that do nothing but be called."""

    def __init__(self) -> None:
        super().__init__()
        self.called: list[str] = []

    def __missing__(self, name: str) -> Callable[[FreeRodModel], None]:
        self.called.append(name)
        return lambda it: None


def called(step: Step) -> list[str]:
    """Names of the methods that a stepper calls, in order."""
    it, recorder = symbolic(1), Recorder()
    it.solution = [S.Zero] * 3
    step(it, recorder)
    return recorder.called


def _defined(methods: Methods) -> Entries:
    """Of every call the name of the method that answers, or the name that none has."""
    names = [name for step in STEPPERS for name in called(step)]
    answers = [methods[name].__name__ if name in methods else name for name in names]
    return lambda n: [Symbol(answer) for answer in answers]


def _with_letters(seen: list[list[Expr]]) -> Methods:
    """Methods in which an evaluation notes the state and gives letters."""

    def getSolution(it: FreeRodModel) -> None:
        seen.append(_state(it))
        it.solution = indexed(f"a{len(seen)}", it.elementCount + 2)

    idle: dict[str, Any] = {name: lambda it: None for name in (*EVALUATE_C, *EVALUATE_D, *FINISH)}
    return {**REPAIRED, **idle, "getSolution": getSolution}


def _state(it: FreeRodModel) -> list[Expr]:
    return [*list(it.coordinates)[:2], *it.angles, *list(it.velocities)[:2], *it.omegas]


def _stepped(step: Step, n: int) -> tuple[FreeRodModel, list[list[Expr]]]:
    """The object after a step, and the states at which it was evaluated."""
    it, seen = symbolic(n), list[list[Expr]]()
    it.coordinates[0], it.coordinates[1] = x0, y0
    complete(it)
    step(it, _with_letters(seen))
    return it, seen


def scheme(step: Step) -> Entries:
    """States at every evaluation and at the end of a step."""

    def entries(n: int) -> list[Expr]:
        it, seen = _stepped(step, n)
        return [entry for stage in (*seen, _state(it)) for entry in stage]

    return entries


def method(module: ModuleType) -> Entries:
    """The same of a method of rodgen."""

    def entries(n: int) -> list[Expr]:
        seen: list[list[Expr]] = []

        def rhs(t: Any, y: Any) -> Any:
            seen.append(list(y))
            letters = indexed(f"a{len(seen)}", n + 2)
            return np.array([*y[n + 2 :], *letters], dtype=object)

        y = np.array(state_letters(n), dtype=object)
        end = module.advance(rhs, S.Zero, y, rhs(S.Zero, y), H)
        return [entry for stage in (*seen, list(end)) for entry in stage]

    return entries


def _joint_velocities(step: Step) -> Entries:
    """Velocities of the joints after a step."""
    return lambda n: list(_stepped(step, n)[0].velocities)


def _from_state(step: Step) -> Entries:
    """Velocities of the joints that belong to the state after the step."""

    def entries(n: int) -> list[Expr]:
        after = _state(_stepped(step, n)[0])
        values = dict(zip(state_letters(n), after, strict=True))
        return [v.xreplace(values) for v in joint_velocities(n)]

    return entries


def _scheme_label(n: int, at: int) -> str:
    stage, entry = divmod(at, 2 * (n + 2))
    return f"{state_letters(n)[entry]} of state {stage + 1}"


_D = "lines 711 and 753: assembleMatrixD, which the appendix calls assembleMatrixC"
_OMEEGAS = "lines 905 and 946: updateOmeegas for updateOmegas"
_FEW = (1, 2)  # sines of sums grow fast, and a joint is like the other
_FRESH = "updateOmegas(); updateAngles(); updateVelocities(); updateCoords();"
_STALE = (
    "updateVelocities takes the sines and cosines of the last updateAngles. Only external damping "
    "reads these velocities. "
)

CLAIMS = (
    Claim(
        "Java 705-1002, names",
        "methods that the steppers call and the listing defines",
        {"as printed": _defined(METHODS)},
        _defined(REPAIRED),
        corrected=_defined(REPAIRED),
        links=(1,),
        note="assembleMatrixD is in the list of methods of section 4.1 too, which hints that the "
        "appendix is another version of the program.",
        printed="assembleMatrixD(); ... updateOmeegas();",
        correction="assembleMatrixC(); ... updateOmegas();",
        label=lambda n, at: [name for step in STEPPERS for name in called(step)][at],
    ),
    Claim(
        "Java 705-730",
        "Euler's method (1.78)",
        {"as printed": scheme(stepEuler)},
        method(euler),
        repairs=(_D,),
        printed="updateAngles(); updateCoords(); updateOmegas(); updateVelocities();",
        label=_scheme_label,
    ),
    Claim(
        "Java 747-772",
        "semi-implicit Euler method (1.83)",
        {"as printed": scheme(stepImprovedEuler)},
        method(semi_implicit_euler),
        repairs=(_D,),
        printed="updateOmegas(); updateVelocities(); updateAngles(); updateCoords();",
        label=_scheme_label,
    ),
    Claim(
        "Java 800-1002",
        "Runge-Kutta method (1.85)",
        {"as printed": scheme(stepRungeKutta)},
        method(rk4),
        corrected=scheme(stepClassical),
        repairs=(_OMEEGAS,),
        note="The accelerations alone are averaged. Angles move by a whole step with velocities "
        "that are updated already, so that no stage is at a midpoint: not (1.85), and of order 1.",
        printed="solution.setValue(row, RKsolutionK1.getValue(row)/2d); ... updateOmegas(); "
        "updateVelocities(); updateAngles(); updateCoords();",
        correction="every stage keeps omegas and velocities beside solution; angles and "
        "coordinates move by (k1+2*k2+2*k3+k4)/6 of them",
        label=_scheme_label,
    ),
    Claim(
        "Java 705-730, joints",
        "velocities of the joints after a step of Euler's method",
        {"as printed": _joint_velocities(stepEuler)},
        _from_state(stepEuler),
        links=_FEW,
        repairs=(_D,),
        printed="updateAngles(); ... updateVelocities();",
    ),
    Claim(
        "Java 747-772, joints",
        "velocities of the joints after a step of the semi-implicit Euler method",
        {"as printed": _joint_velocities(stepImprovedEuler)},
        _from_state(stepImprovedEuler),
        corrected=_joint_velocities(partial(stepImprovedEuler, move=MOVE_FRESH)),
        links=_FEW,
        repairs=(_D,),
        note=_STALE + "Here these are the angles before the step.",
        printed="updateVelocities(); updateAngles();",
        correction=_FRESH,
    ),
    Claim(
        "Java 800-1002, joints",
        "velocities of the joints after a step of the Runge-Kutta method",
        {"as printed": _joint_velocities(stepRungeKutta)},
        _from_state(stepRungeKutta),
        corrected=_joint_velocities(partial(stepRungeKutta, move=MOVE_FRESH)),
        links=_FEW,
        repairs=(_OMEEGAS,),
        note=_STALE + "Here these are the angles of the fourth stage; in every stage, those of the "
        "stage before, as lines 850-859 restore the angles and not their sines.",
        printed="updateVelocities(); updateAngles();",
        correction=_FRESH,
    ),
)
