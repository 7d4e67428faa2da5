"""Lyapunov exponents: growth rates of neighbouring motions in every direction of the state.

Tangents of a motion are brought back to an orthonormal frame again and again, and the logarithms of
their growth in between are averaged (G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn,
Meccanica 15 (1980) 9-30; I. Shimada, T. Nagashima, Prog. Theor. Phys. 61 (1979) 1605).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import ModuleType

import numpy as np

from rodgen.analyse.analysis_guard import (
    EXPONENTS,
    check_analysis_memory,
    check_positive,
    check_whole_number,
    guard_analysis,
)
from rodgen.analyse.chaos.metrics import Metric, zero_exponents
from rodgen.analyse.chaos.poincare import LEAST, decimate, zero_one_test
from rodgen.arrays import Array
from rodgen.display import Plottable
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.stepper import ChatterError, StepError
from rodgen.integrate.stretches import with_span
from rodgen.integrate.variations import METHODS, PARTS, StepSettings, Variations
from rodgen.model.methods import COLLOCATION
from rodgen.result import FLAG, USUAL, Note, Result, Row, StudyStorage, omit_from_tables, remarks
from rodgen.scene import Scene
from rodgen.scene.integration import AUTO
from rodgen.system import System

PIECES = 2000  # of the time that is averaged over, at whose ends there is a sample
NAMED = 3  # exponents in a line of text
BATCHES = 25  # of pieces, whose means the errors are estimated from
TRANSIENT = 0.1  # share of the span that is left out
# Between two frames, logarithms of the ratio of what grows most and least in a frame: more are done
# again in shorter parts, as what grows least is lost in rounding; far less, and parts are longer.
TOO_MUCH, MUCH, LITTLE = 16.0, 8.0, 3.0
SHORTEST = 2.0**-40  # of a piece
# Radians or decays of the fastest motion at the start, in which a step of dop853 makes an error of
# 1e-7 of a tangent; of rods of more states it is not looked for.
FOLLOWED, MOST_STATES = 1.0, 400
REGULAR, CHAOTIC = 0.1, 0.9  # of the 0-1 test, beyond which it is decisive
STABLE = 6.0  # of these radians, about what is stable


@dataclass(frozen=True, eq=False, repr=False)
class Exponents(Result, Plottable):
    """Lyapunov exponents of a motion, the largest first.

    exponents, errors (k,): growth rates [1/s]; t (T,): times [s]; running (T, k): the means up to
    these times [1/s]; rates (T, k): of the pieces between these [1/s]; transient: time left out at
    the start [s]; zero_one: the 0-1 test of the velocity of the tail's link, dimensionless, about 0
    for regular and about 1 for chaotic motion, not-a-number where the samples are too few;
    divergence: mean of the trace of the Jacobian [1/s], at which volumes of the state's numbers
    grow, not-a-number unless all exponents were asked for; zeros: how many exponents are zero for
    every motion, by reason; notes: what else to know; scene: the scene that moves.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.lyapunov_exponents(rodgen.Scene.example("falling_chain"), count=1, span=20.0)
    >>> found.chaotic, found.running.shape == (len(found.t), 1)
    (True, True)
    """

    exponents: Array
    errors: Array
    t: Array
    running: Array
    rates: Array
    transient: float
    zero_one: float
    divergence: float
    zeros: dict[str, int]
    notes: tuple[Note, ...]
    scene: Scene = field(kw_only=True)

    ROWS = (
        Row(
            "exponents",
            "exponent",
            "1/s",
            ".6g",
            along="exponent",
            kept=StudyStorage(True, several=1),
        ),
        Row("errors", "error", "1/s", ".2g", along="exponent", kept=StudyStorage(True, several=1)),
        Row("zero_within_error", "zero within its error", along="exponent"),
        Row("chaotic", "the motion", text=lambda found: found._verdict, kept=FLAG),
        Row("zero_one", "0-1 test", text=lambda found: found._zero_one, kept=USUAL),
        Row("zeros", "zero by {}, unless it comes to rest"),
        Row("sum", "sum of them", "1/s", ".3g", text=lambda found: found._sum),
        Row("divergence", "mean divergence", "1/s", ".3g", text=omit_from_tables),
        Row("transient", "left out at the start", "s", ".6g"),
    )

    @property
    def zero_within_error(self) -> list[bool]:
        """Whether each exponent is zero, as far as its error tells."""
        return [bool(one) for one in np.abs(self.exponents) <= 2 * self.errors]

    @property
    def sum(self) -> float:
        """Sum of the exponents [1/s]."""
        return float(self.exponents.sum())

    @property
    def _verdict(self) -> str:
        largest, error = float(self.exponents[0]), float(self.errors[0])
        if self.chaotic:
            return f"chaotic: errors grow tenfold in {math.log(10) / largest:.3g} s"
        if self.chaotic is None:
            return "cannot be told; take a longer span"
        return f"not chaotic: no exponent is above {largest + error:.2g} 1/s by {self.t[-1]:.4g} s"

    @property
    def _zero_one(self) -> str:
        if not math.isfinite(self.zero_one):
            return "too few independent samples"
        return f"{self.zero_one:.3f} (0: regular, 1: chaotic)"

    @property
    def _sum(self) -> str | None:
        if not math.isfinite(self.divergence):
            return None
        return f"{self.sum:.3g} 1/s, by the mean divergence {self.divergence:.3g} 1/s"

    def __repr__(self) -> str:
        pairs = zip(self.exponents[:NAMED], self.errors, strict=False)
        said = ", ".join(f"{mean:.4g} ± {error:.2g}" for mean, error in pairs)
        count = f" (of {len(self.exponents)})" if len(self.exponents) > NAMED else ""
        words = {True: "chaotic", False: "not chaotic", None: "chaotic or not: cannot be told"}
        return f"<Exponents of {self.scene.name}: {said} 1/s{count}; {words[self.chaotic]}>"

    @property
    def chaotic(self) -> bool | None:
        """Whether neighbours come apart exponentially; None where that cannot be told. An exponent
        one to three errors above zero is judged by the 0-1 test where that is decisive."""
        largest, error = float(self.exponents[0]), float(self.errors[0])
        if largest > 3 * error or (largest > error and self.zero_one > CHAOTIC):
            return True
        if self.zero_one < REGULAR:
            return False
        return None if largest > 1.5 * error or self.zero_one > 0.5 else False


@guard_analysis
def lyapunov_exponents(
    system: System | Scene,
    *,
    count: int | None = None,
    span: float | None = None,
    transient: float | None = None,
    model: ModuleType | None = None,
    progress: Callable[[float], None] = lambda t: None,
) -> Exponents:
    """Return the Lyapunov exponents of the motion of a scene from its initial state on.

    Tangents are measured by the numbers of the state. If all exponents are computed, tangents are
    measured by kinetic energy, and a motion without damping then keeps volumes. The error of an
    exponent is a standard error, for the limit of long spans: of other spans of a chaotic motion,
    some four fifths lie within one error of that limit, and 19 in 20 within two. It has three
    parts: the standard error of batch means, larger if these are correlated; half the difference
    between both halves of the time; and the size that an exponent of zero may have after such a
    span.

    Parameters
    ----------
    system
        The scene, or a System.
    count
        Number of exponents, from the largest on. By default all are computed.
    span
        Length of the motion [s]. By default it is the span of the scene.
    transient
        Time at the start that is left out of the means [s], while tangents find their directions.
        By default it is a tenth of the span.
    model
        A module that `build` has made before.
    progress
        A function that is called with the time [s].

    Returns
    -------
    Exponents
        Exponents and errors (k,) [1/s], the largest first.

    Raises
    ------
    InputError
        For values that cannot be used.
    AnalysisError
        If the motion cannot be continued.

    Examples
    --------
    >>> import rodgen
    >>> found = rodgen.lyapunov_exponents(rodgen.Scene.example("falling_chain"), count=1, span=20.0)
    >>> bool(found.exponents[0] > 10)
    True
    """
    system = System.of(system)
    start, end = system.settings.span
    length = end - start if span is None else check_positive(span, "span", "seconds above 0")
    states = len(system.y0)
    allowed = f"from 1 to {states}, the numbers of the state"
    count = states if count is None else check_whole_number(count, "count", 1, states, allowed)
    skipped = TRANSIENT * length if transient is None else transient
    if not 0 <= skipped < length:
        raise InputError("transient", transient, f"from 0 to below the span, {length:g} s")
    check_analysis_memory(EXPONENTS, system, count=count)
    over = with_span(system.scene, start, start + length)
    model = model if model is not None else system.model(parts=PARTS)
    course = _TangentMotion(over, system.p, model, count, progress)
    progress(start)
    try:
        if skipped:
            course.integrate(start, start + skipped, max(1, round(PIECES * skipped / length)))
        before = course.log_volume
        rates, signal = course.integrate(start + skipped, start + length, PIECES)
    except StepError as error:
        raise AnalysisError(f"{system.name}: the motion cannot go on: {error}") from None
    return _average_rates(over, course, rates, signal, skipped, before)


class _TangentMotion:
    """A motion with a frame of tangents, integrated piece by piece."""

    def __init__(
        self,
        scene: Scene,
        p: Array,
        model: ModuleType,
        count: int,
        progress: Callable[[float], None],
    ):
        self.model, self._progress = model, progress
        self._p = p
        y = scene.initial_state()
        self.volumes = count == len(y)
        self._form = Metric(model if self.volumes else None, self._p)
        frame = np.linalg.qr(np.random.default_rng(0).standard_normal((len(y), count)))[0].T
        start, steps = scene.integrate.span[0], StepSettings.of(scene)
        # Implicit steps need not follow what dies out at once, unless its own rate is asked for.
        free = steps.method in COLLOCATION and not self.volumes
        fastest = 0.0 if free else _fastest_rate(model, start, y, self._p)
        if not steps.step:
            _check_budget(scene, fastest, count)
        if count > 1 and fastest:
            steps = replace(steps, longest=min(steps.longest, FOLLOWED / fastest))
        self._steps = steps
        frame = self._form.from_components(start, y, frame)
        self.on = Variations(model, self._p, start, y, frame, self._steps)
        self._parts = 1.0  # of a piece, between two frames

    @property
    def log_volume(self) -> float:
        """Logarithm of the density of the volumes that a motion without damping keeps."""
        return self._form.log_density(self.on.t, self.on.y)

    def integrate(self, start: float, end: float, pieces: int) -> tuple[Array, Array]:
        """Integrate over equal pieces of time; return growth rates [1/s] (pieces, count), and the
        velocity of the tail's link at the ends of the pieces."""
        times = np.linspace(start, end, pieces + 1)
        grown = np.empty((pieces, len(self.on.tangents)))
        signal = np.empty(pieces)
        where = len(self.on.y) - 1 - len(getattr(self.model, "STATES", ()))
        for at, (left, right) in enumerate(pairwise(times)):
            grown[at] = self._integrate_piece(left, right)
            signal[at] = self.on.y[where]
            self._progress(float(right))
        return grown / ((end - start) / pieces), signal

    def _integrate_piece(self, start: float, end: float) -> Array:
        """Integrate over one piece; return the logarithmic growth of every direction."""
        total = np.zeros(len(self.on.tangents))
        t = start
        while t < end:
            length = self._parts * (end - start)
            goal = end if t + 1.5 * length > end else t + length
            t_, y, frame = self.on.t, self.on.y, self.on.tangents
            try:
                self.on.advance_to(goal)
                grown, found = self._orthonormalise()
                spread = float(np.ptp(np.append(grown, 0.0)))
            except ChatterError:  # in shorter pieces, too
                raise
            except StepError:
                spread = math.inf
                if self._parts * 0.5 < SHORTEST:
                    raise
            if not spread < TOO_MUCH:
                self._parts *= 0.5
                if self._parts < SHORTEST:
                    raise StepError(f"tangents grow beyond all bounds at t = {t_:.9g} s")
                self.on = Variations(self.model, self._p, t_, y, frame, self._steps)
                continue
            total += grown
            self.on.tangents = found
            t = goal
            if spread > MUCH:
                self._parts *= 0.5
            elif spread < LITTLE:
                self._parts = min(1.0, 2.0 * self._parts)
        return total

    def _orthonormalise(self) -> tuple[Array, Array]:
        """Orthonormalise the tangents; return the logarithms of their growth, and the frame."""
        t, y = self.on.t, self.on.y
        q, r = np.linalg.qr(self._form.to_components(t, y, self.on.tangents).T)
        return np.log(np.abs(np.diag(r))), self._form.from_components(t, y, q.T)


def _fastest_rate(model: ModuleType, t: float, y: Array, p: Array) -> float:
    """Modulus [1/s] of the fastest motion about a state; zero where it is not looked for.

    It bounds the steps of several tangents: where the fastest motions are at rest, their error lets
    steps grow up to the limit of stability, where the steps themselves damp fast motions by several
    1/s. The largest exponent is not affected by that.
    """
    if len(y) > MOST_STATES:
        return 0.0
    matrix = model.tangents(t, y, p, np.eye(len(y))).T
    return float(np.abs(np.linalg.eigvals(matrix)).max()) if np.isfinite(matrix).all() else 0.0


def _check_budget(scene: Scene, fastest: float, count: int) -> None:
    """Raise AnalysisError where explicit steps would be too many for the motion of a scene."""
    start, end = scene.integrate.span
    steps = (end - start) * fastest / (FOLLOWED if count > 1 else STABLE)
    if steps > scene.integrate.step_limit:
        raise AnalysisError(
            f"{scene.name}: {steps:.2g} steps, more than integrate.max_steps "
            f"({scene.integrate.step_limit:.2g}): the fastest motion, {fastest:.2g} 1/s, bounds "
            "those of dop853, and those in which all exponents are found; take a shorter span, or "
            "radau for fewer exponents"
        )


def _average_rates(
    scene: Scene, course: _TangentMotion, rates: Array, signal: Array, skipped: float, before: float
) -> Exponents:
    """Average the rates of pieces to exponents, and estimate their errors."""
    start, end = scene.integrate.span
    mean = rates.mean(axis=0)
    order = np.argsort(-mean, kind="stable")
    rates, mean = rates[:, order], mean[order]
    running = np.cumsum(rates, axis=0) / np.arange(1, len(rates) + 1)[:, None]
    t = np.linspace(start + skipped, end, len(rates) + 1)[1:]
    spread = (
        standard_errors(rates),
        half_differences(rates),
        _rate_of_zero_exponent(start, start + skipped, end),
    )
    errors = np.sqrt(sum(np.square(one) for one in spread))
    divergence = math.nan
    if course.volumes:
        divergence = float(mean.sum()) - (course.log_volume - before) / (end - start - skipped)
    signal = decimate(signal)
    return Exponents(
        *(mean, errors, t, running, rates, skipped),
        zero_one=zero_one_test(signal) if len(signal) >= LEAST else math.nan,
        divergence=divergence,
        zeros=zero_exponents(scene, course.model),
        notes=remarks(_limitations(scene)),
        scene=scene,
    )


def standard_errors(rates: Array) -> Array:
    """Standard errors (k,) of the means of rates (pieces, k) that are correlated in time: by the
    means of BATCHES longer parts. If their correlation from one to the next is r, they count as
    BATCHES (1 - r)/(1 + r) independent ones. So few of them show an r that is too small, and spread
    too little about their own mean; both are corrected (F. H. C. Marriott, J. A. Pope, Biometrika
    41 (1954) 390-402)."""
    batches = np.stack([part.mean(axis=0) for part in np.array_split(rates, BATCHES)])
    off = batches - batches.mean(axis=0)
    squares = (off**2).sum(axis=0)
    seen = (off[1:] * off[:-1]).sum(axis=0) / np.maximum(squares, np.finfo(float).tiny)
    together = np.clip((BATCHES * seen + 1) / (BATCHES - 3), 0.0, 0.9)
    alike = (1 + together) / (1 - together)  # batches that count as one
    errors: Array = np.sqrt(squares / BATCHES / (BATCHES / alike - 1))
    return errors


def half_differences(rates: Array) -> Array:
    """Half of the difference between the means of both halves of rates (pieces, k), (k,): the
    directions of the slowest exponents converge slowly."""
    half = len(rates) // 2
    return np.asarray(rates[:half].mean(axis=0) - rates[-half:].mean(axis=0)) / 2


def _rate_of_zero_exponent(start: float, begin: float, end: float) -> float:
    """Apparent rate of an exponent of zero over a finite span: tangents of regular motions grow in
    proportion to the time since the start, which is a mean rate of ln(end/begin)/(end - begin) from
    begin to end, and turn among one another, which is a few logarithms more or less."""
    grown = math.log((end - start) / max(begin - start, TRANSIENT * (end - start)))
    return grown / (end - begin)


def _limitations(scene: Scene) -> list[str]:
    """Remarks on the method, and on laws that switch."""
    method, notes = scene.integrate.method, list[str]()
    if method not in (*METHODS, AUTO):
        notes.append(f"by dop853: {method} takes no tangents along")
    if scene.time_laws.switches():
        notes.append("a law switches as it follows the motion: where it jumps, tangents do not")
    return notes
