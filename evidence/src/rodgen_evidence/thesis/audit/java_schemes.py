"""The claims of the listing's getters and steppers, lines 617-681 and 705-1002.

Of a stepper: what it calls, and which scheme that is. In place of the accelerations, which are
claimed elsewhere, every evaluation gives letters: a1_i the first, a2_i the second. The truth is
rodgen's own method, run with the same letters.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from sympy import Rational, S, Symbol

from rodgen.derive.symbols import x0, y0
from rodgen.integrate.methods.python_steppers import explicit_step
from rodgen.model.methods import TABLEAUX
from rodgen_evidence.thesis.audit.claim import READ, Claim, Entries
from rodgen_evidence.thesis.audit.java_equation import MISSPELLED, FreeRodModel
from rodgen_evidence.thesis.audit.java_equation_claims import RESISTED, velocity_angles
from rodgen_evidence.thesis.audit.java_letters import (
    H,
    Symbolic,
    centre,
    indexed_symbols,
    joint_velocities,
    joints,
    state_letters,
)
from rodgen_evidence.thesis.audit.java_object import ARRAYS
from rodgen_evidence.thesis.audit.java_steps import (
    EVALUATE_C,
    EVALUATE_D,
    FINISH,
    MOVE_FRESH,
    complete,
    stepClassical,
    stepEuler,
    stepImprovedEuler,
    stepRungeKutta,
)
from rodgen_evidence.thesis.audit.truth import Column, omega, phi, truth

Step = Callable[[FreeRodModel], None]
STEPPERS: tuple[Step, ...] = (stepEuler, stepImprovedEuler, stepRungeKutta)


def filled_object(n: int) -> Symbolic:
    """The object with its joints, centre of gravity, energy of the springs and forces as they are
    for the letters of the truth."""
    it = Symbolic(
        n,
        aeroDampingCoef=lambda n: indexed_symbols("a", n + 1),
        velocityAngles=velocity_angles,
        **RESISTED,
    )
    it.coordinates[0], it.coordinates[1] = x0, y0
    complete(it)
    it.call("updateCG", "updatePotentialEnergy")
    return it


def _got(n: int) -> Column:
    it = filled_object(n)
    by_index = [get(at) for get in (it.getCoordinate, it.getVelocity) for at in range(2 * n + 2)]
    arrays = [value for name in ARRAYS for value in it.getArray(name)]
    return [*by_index, it.getPotentialEnergy(), *arrays]


def _got_true(n: int) -> Column:
    by_index = [*joints(n), *joint_velocities(n), truth(n).spring_energy]
    motion = [*joints(n), *phi[:n], *centre(n), *omega[:n]]
    of_joints = [*indexed_symbols("a", n + 1), *velocity_angles(n)]
    return [*by_index, *motion, *of_joints, *(f for forces in RESISTED.values() for f in forces(n))]


def _velocities(lines: str, axis: int) -> Claim:
    name = "XY"[axis]
    return Claim(
        lines,
        f"velocities of the joints along {name.lower()}",
        {READ: lambda n: getattr(filled_object(n), f"getVelocities{name}")()},
        lambda n: joint_velocities(n)[axis::2],
        note="The method returns a new array, so a caller may write into it.",
        printed=f"velocities{name}[i]=velocities[2*i{'+1' * axis}];",
        label=lambda n, at: f"joint {at}",
    )


class CallRecorder(Symbolic):
    """An object whose methods do nothing but be called by their names, as the listing has them."""

    def __init__(self) -> None:
        super().__init__(1, solution=lambda n: [S.Zero] * 3)
        self.called: list[str] = []

    def call(self, *names: str) -> None:
        self.called += names


def method_calls() -> list[str]:
    """Names of the methods that the steppers call, in order."""
    recorder = CallRecorder()
    for step in STEPPERS:
        step(recorder)
    return recorder.called


def _definitions(n: int) -> Column:
    """Names of the methods that the listing defines, for every call."""
    right = (name if hasattr(FreeRodModel, name) else MISSPELLED[name] for name in method_calls())
    return [Symbol(name) for name in right]


class Staged(Symbolic):
    """An object of which an evaluation notes the state and gives letters."""

    def __init__(self, n: int) -> None:
        super().__init__(n)
        self.seen: list[Column] = []
        self.coordinates[0], self.coordinates[1] = x0, y0
        complete(self)

    def call(self, *names: str) -> None:
        super().call(*(name for name in names if name not in IDLE))

    def getSolution(self) -> None:
        self.seen.append(self.state())
        self.solution = indexed_symbols(f"a{len(self.seen)}", self.elementCount + 2)

    def state(self) -> Column:
        """State in rodgen's order."""
        start, velocity = list(self.coordinates)[:2], list(self.velocities)[:2]
        return [*start, *self.angles, *velocity, *self.omegas]


IDLE = {*EVALUATE_C, *EVALUATE_D, *FINISH} - {"getSolution"}  # what a stage does without


def _take_step(step: Step, n: int) -> Staged:
    it = Staged(n)
    step(it)
    return it


def scheme(step: Step) -> Entries:
    """States at every evaluation and at the end of a step."""

    def entries(n: int) -> Column:
        it = _take_step(step, n)
        return [entry for stage in (*it.seen, it.state()) for entry in stage]

    return entries


def method(name: str) -> Entries:
    """States at every evaluation and at the end of a step of a method of rodgen."""
    step = explicit_step(TABLEAUX[name], Rational)

    def entries(n: int) -> Column:
        seen: list[Column] = []

        def rhs(t: Any, y: Any) -> Any:
            seen.append(list(y))
            letters = indexed_symbols(f"a{len(seen)}", n + 2)
            return np.array([*y[n + 2 :], *letters], dtype=object)

        y = np.array(state_letters(n), dtype=object)
        end = step(rhs, S.Zero, y, rhs(S.Zero, y), H)
        return [entry for stage in (*seen, list(end)) for entry in stage]

    return entries


def _joint_velocities(step: Step) -> Entries:
    """Velocities of the joints after a step."""
    return lambda n: list(_take_step(step, n).velocities)


def _from_state(step: Step) -> Entries:
    """Velocities of the joints that belong to the state after the step."""

    def entries(n: int) -> Column:
        values = dict(zip(state_letters(n), _take_step(step, n).state(), strict=True))
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
        "Java 617-663",
        "what the other getters hand out",
        {READ: _got},
        _got_true,
        note=(
            "The methods return the arrays themselves, so a caller that writes into one changes "
            "the motion. The potential energy is that of the springs."
        ),
        printed="return coordinates[index]; return velocities[index]; return angles; ...",
    ),
    _velocities("Java 665-672", 0),
    _velocities("Java 674-681", 1),
    Claim(
        "Java 705-1002, names",
        "methods that the steppers call and the listing defines",
        {READ: lambda n: [Symbol(name) for name in method_calls()]},
        _definitions,
        corrected=_definitions,
        links=(1,),
        note="assembleMatrixD is in the list of methods of section 4.1 too, which hints that the "
        "appendix is another version of the program.",
        printed="assembleMatrixD(); ... updateOmeegas();",
        correction="assembleMatrixC(); ... updateOmegas();",
        label=lambda n, at: method_calls()[at],
    ),
    Claim(
        "Java 705-730",
        "Euler's method (1.78)",
        {READ: scheme(stepEuler)},
        method("euler"),
        repairs=(_D,),
        printed="updateAngles(); updateCoords(); updateOmegas(); updateVelocities();",
    ),
    Claim(
        "Java 747-772",
        "semi-implicit Euler method (1.83)",
        {READ: scheme(stepImprovedEuler)},
        method("semi_implicit_euler"),
        repairs=(_D,),
        printed="updateOmegas(); updateVelocities(); updateAngles(); updateCoords();",
    ),
    Claim(
        "Java 800-1002",
        "Runge-Kutta method (1.85)",
        {READ: scheme(stepRungeKutta)},
        method("rk4"),
        corrected=scheme(stepClassical),
        repairs=(_OMEEGAS,),
        note=(
            "Only the accelerations are averaged. Angles move by a whole step with velocities "
            "that are already updated, so no stage is at a midpoint. This is not (1.85), and its"
            " order is 1."
        ),
        printed="solution.setValue(row, RKsolutionK1.getValue(row)/2d); ... updateOmegas(); "
        "updateVelocities(); updateAngles(); updateCoords();",
        correction="every stage keeps omegas and velocities beside solution; angles and "
        "coordinates move by (k1+2*k2+2*k3+k4)/6 of them",
        label=_scheme_label,
    ),
    Claim(
        "Java 705-730, joints",
        "velocities of the joints after a step of Euler's method",
        {READ: _joint_velocities(stepEuler)},
        _from_state(stepEuler),
        links=_FEW,
        repairs=(_D,),
        printed="updateAngles(); ... updateVelocities();",
    ),
    Claim(
        "Java 747-772, joints",
        "velocities of the joints after a step of the semi-implicit Euler method",
        {READ: _joint_velocities(stepImprovedEuler)},
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
        {READ: _joint_velocities(stepRungeKutta)},
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
