"""Critical forces from simulations, whose growth is read off by dynamic mode decomposition."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np

from rodgen.analyse.analysis_guard import (
    OpenBounds,
    check_open_bounds,
    check_positive,
    guard_analysis,
)
from rodgen.analyse.load_family import HIGHEST, LoadFamily
from rodgen.analyse.scene_family import load_family
from rodgen.analyse.steady_rod import Unknowns
from rodgen.arrays import Array
from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.simulate import simulate
from rodgen.integrate.solution import RunError, Solution
from rodgen.progress import report_stage
from rodgen.result import Note, Result, Row, doubt, omit_from_tables
from rodgen.scene import Scene
from rodgen.scene.expression import Expression
from rodgen.scene.integration import IntegrationSettings, check_settings_used
from rodgen.system import System

FAINT = 1e-6  # of the strongest direction: weaker ones are lost in errors of the run
NOISE = 4.0  # times the tolerance, what the steps of a run may be off by together
FIRST = 4.0  # EI/L^2, doubled until a motion grows
PIECES = 20  # of a run
SAMPLES = 4000  # of a run
MEASURED = 1.01  # times, by which a motion has to grow where its growth is measured
FAR = 1e4  # times the bending of the start: no more has to be measured
# What is measured has to stand out against errors, what grows a hundredfold does so by itself.
TOLERANCES = {True: {"rtol": 1e-10, "atol": 1e-12}, False: {"rtol": 1e-6, "atol": 1e-8}}
# Small angles [rad], without a moment at free ends.
AMPLITUDE = {True: 1e-6, False: 1e-4}
DISTURBED = "{:g}*(cos(pi*s) + cos(2*pi*s) + cos(3*pi*s))"
DISTURBED_CLAMPED = "{:g}*(sin(pi*s/2) + sin(3*pi*s/2))"
TOLERANCE = 1e-4  # relative, of the force
APART = 0.05  # relative: where forces differ by more, one is not to be trusted


def dmd_growth(parts: Sequence[Array], faint: float = FAINT) -> float:
    """Growth factor, over all evenly spaced samples, of the motion that grows most.

    Dynamic mode decomposition: the linear map that takes every sample to the one half a run later
    is fitted in the few directions in which the samples move; its largest eigenvalue says by how
    much a motion has grown in that time (P. J. Schmid, Dynamic mode decomposition of numerical and
    experimental data, J. Fluid Mech. 656, 2010). So long a step makes slow growth stand out against
    the errors of the run, and does not care how fast anything oscillates. parts: quantities
    (samples, k) that are linear in the motion, such as angles and their rates; each part is
    scaled by its own size; faint: share of the strongest direction below which errors prevail.
    Zero where nothing moves.
    """
    sizes = [float(np.linalg.norm(part)) for part in parts]
    moving = [part / size for part, size in zip(parts, sizes, strict=True) if size > 0]
    if not moving:
        return 0.0
    samples = np.concatenate(moving, axis=1).T
    lag = samples.shape[1] // 2
    directions, strengths, course = np.linalg.svd(samples[:, :-lag], full_matrices=False)
    kept = strengths > faint * strengths[0]
    later = directions[:, kept].T @ samples[:, lag:]
    carried = later @ course[kept].T / strengths[kept]
    most = float(np.abs(np.linalg.eigvals(carried)).max())
    return float(most ** ((samples.shape[1] - 1) / lag))


@dataclass(frozen=True, repr=False)
class SimulatedCritical(Result):
    """A critical load found by simulations.

    low: largest force whose motion did not grow [N]; high: smallest force whose motion grew [N];
    value: between them [N]; span: simulated time of a run [s]; growth: factor by which the bending
    of the start had to be exceeded, dimensionless, None if the growth was measured; runs: their
    number; seconds: time of all runs [s]; target: of the module, "c" or "numpy"; speed: with which
    a free rod starts along its axis [m/s]; notes: what is doubtful about the runs.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("ziegler")
    >>> found = rodgen.simulated_critical_load(scene, span=40.0, tolerance=1e-2)
    >>> (found.high - found.low) / found.value < 0.02, found.growth_threshold > 1
    (True, True)
    """

    value: float
    low: float
    high: float
    span: float
    growth: float | None
    runs: int
    seconds: float
    target: str
    speed: float = 0.0
    notes: tuple[Note, ...] = ()

    ROWS = (
        Row("value", "critical force", "N"),
        Row("low", "did not grow", "N"),
        Row("high", "grew", "N"),
        Row("span", "length of a run", "s"),
        Row("growth", "growth", text=lambda found: found._growth_text),
        Row("runs", "simulations", text=lambda found: found._cost_text),
        Row("seconds", "time taken", "s", ".3g", text=omit_from_tables),
        Row("target", "module", text=omit_from_tables),
        Row("speed", "speed", "m/s", text=omit_from_tables),
    )

    @property
    def unit(self) -> str:
        """Unit of the force."""
        return "N"

    def __repr__(self) -> str:
        between = f"between {self.low:.8g} and {self.high:.8g} N"
        return f"<SimulatedCritical: {self.value:.8g} N, {between}; {self.runs} runs>"

    @property
    def _growth_text(self) -> str:
        if self.growth:
            return f"bending beyond {self.growth:g} times its start"
        return "growth of 1 %, measured"

    @property
    def _cost_text(self) -> str:
        module = "C" if self.target == "c" else "NumPy"
        return f"{self.runs} of {self.span:g} s in {self.seconds:.3g} s, in {module}"

    @property
    def growth_threshold(self) -> float:
        """Factor by which a motion has to grow within the span to be seen, dimensionless."""
        return MEASURED if self.growth is None else self.growth


def comparison_rows(found: SimulatedCritical, value: float) -> dict[str, str]:
    """Rows of a table, in comparison with the force by eigenvalues [N]."""
    away = found.value / value - 1 if value else 0.0
    low, high = f"{found.low:.6g} N (no growth)", f"{found.high:.6g} N (growth)"
    return {
        "by simulation": f"{found.value:.6g} N, {away:+.2%}",
        "between": f"{low} and {high}",
        "growth": found._growth_text,
        "simulations": found._cost_text,
    }


@guard_analysis
def simulated_critical_load(
    system: System | Scene,
    *,
    span: float = 200.0,
    growth: float | None = None,
    tolerance: float = TOLERANCE,
    t: float | None = None,
    speed: float | None = None,
    after: float | None = None,
    bounds: OpenBounds = (None, None),
    disturbance: str | None = None,
    progress: Callable[[float, bool], None] = lambda force, grew: None,
    target: str | None = None,
    method: str | None = None,
    step: float | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    max_steps: int | None = None,
) -> SimulatedCritical:
    """Find a critical force by bisection, with runs in which a small motion grows or does not.

    Each run starts from the steady state under its force, with a small disturbance. Of the scene's
    initial state only the speed is used. By default the growth is measured: a linear map is fitted
    to samples of the angles between links, their rates and added states (also the mean angle of a
    free rod that loads steer), as differences from the steady state. Its largest eigenvalue is the
    growth, and 1 % within the span counts.

    Parameters
    ----------
    system
        The scene, or a System.
    span
        Length of every run [s].
    growth
        With a number (dimensionless), a motion has grown when the largest angle between two links
        exceeds that of the start by this factor, as in the thesis. In a finite time this finds too
        large a force, because growth is slow near the onset. A small factor finds too small a
        force, because frequencies that nearly meet beat.
    tolerance
        Relative tolerance of the force, dimensionless.
    t, speed, after
        Times [s] and speed [m/s] as in `critical_load`, but the speed changes during the run.
    bounds
        Forces (a, b) between which the critical one lies [N]. By default, or where it is None, a is
        zero, and b is found by doubling, from 4 EI/L^2 on.
    disturbance
        Angles [rad], an expression in s as in a scene. By default about 1e-6, or 1e-4 if ``growth``
        is given.
    progress
        A function that is called with every force [N], and with whether the motion grew.
    target
        "c" or "numpy". By default C if it can be built.
    method, step, rtol, atol, max_steps
        As in [integrate] of a scene: the step [s], and tolerances of numbers in SI units. By
        default rtol is 1e-10 and atol 1e-12, or 1e-6 and 1e-8 if ``growth`` is
        given.

    Returns
    -------
    SimulatedCritical
        The force [N], and those between which it lies.

    Raises
    ------
    InputError
        For values that cannot be used.
    AnalysisError
        If there is no steady state, or if no motion grows up to 1000 EI/L^2.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("ziegler")
    >>> found = rodgen.simulated_critical_load(scene, span=40.0, tolerance=1e-2)
    >>> found.low <= found.value <= found.high
    True
    """
    # Refuses a scene without a follower force, or without a stiffness.
    family = load_family(system, t, speed, after)
    given: IntegrationSettings = {
        "method": method,
        "step": step,
        "rtol": rtol,
        "atol": atol,
        "max_steps": max_steps,
    }
    check_settings_used(family.rod.system.with_settings(**given).settings, given)
    over = 1.0 if growth is None else growth - 1
    for name, value in (("span", span), ("growth - 1", over), ("tolerance", tolerance)):
        check_positive(value, name, "positive")
    settings = {name: value for name, value in given.items() if value is not None}
    run = GrowthTest(family, span, growth, disturbance, progress, target, settings)
    return bisect_growth(run, tolerance, bounds)


def bisect_growth(
    run: GrowthTest, tolerance: float = TOLERANCE, bounds: OpenBounds = (None, None)
) -> SimulatedCritical:
    """Find the smallest force under which a motion grows, as `simulated_critical_load` does."""
    begun, family = time.perf_counter(), run.family
    if run.model.PROVENANCE["target"] == "numpy":
        report_stage("simulating with NumPy, which takes long: no C module can be built")
    lower, upper = _bracket(run, bounds, family.unit)
    while upper - lower > tolerance * upper:
        middle = (lower + upper) / 2
        lower, upper = (lower, middle) if run.has_growth(middle) else (middle, upper)
    return SimulatedCritical(
        value=(lower + upper) / 2,
        low=lower,
        high=upper,
        span=run.span,
        growth=run.growth,
        runs=run.count,
        seconds=time.perf_counter() - begun,
        target=run.model.PROVENANCE["target"],
        speed=family.rod.speed,
    )


def find_difference(
    force: float, simulated: SimulatedCritical, family: LoadFamily
) -> Iterator[Note]:
    """Yield the doubt about forces by eigenvalues (``force`` [N]) and by simulations that differ by
    more than 5 %, with the reason as far as it is known."""
    if abs(simulated.value - force) <= APART * abs(force):
        return
    figures = {"by_eigenvalues": force, "by_simulations": simulated.value}
    words = (
        "the forces by eigenvalues and by simulations differ by more than 5 %: one of them is not "
        "to be trusted"
    )
    of_speed = family.steady_state(force).notes
    if of_speed:
        words = "; ".join((words, *map(str, of_speed)))
        yield doubt(f"{words}; the runs have the speed that they gain", **figures)
        return
    rate = float(
        np.nanmax(family.elastic_eigenvalues(np.array([simulated.low]), family.n_modes).real)
    )
    if 0 < rate * simulated.span < np.log(simulated.growth_threshold):
        words += (
            f"; under {simulated.low:.6g} N motions grow with {rate:.3g} 1/s by eigenvalues, too "
            f"slowly to be seen in {simulated.span:g} s: simulate for longer"
        )
        figures["rate"] = rate
    yield doubt(words, **figures)


def _bracket(run: GrowthTest, bounds: OpenBounds, unit: float) -> tuple[float, float]:
    """Bracket the critical force by one without and one with growth."""
    low, high = check_open_bounds(bounds)
    lower = low or 0.0
    if high is not None and not high > lower:
        raise InputError("bounds", bounds, f"({lower:g}, b) with b above that")
    if run.has_growth(lower):
        raise AnalysisError(f"the motion grows already at {lower:g} N within {run.span:g} s")
    upper = lower + FIRST * unit if high is None else high
    while not run.has_growth(upper):
        if high is not None or upper > HIGHEST * unit:
            raise AnalysisError(
                f"no motion grows {run.seen:g} times within {run.span:g} s up to {upper:g} N "
                f"({run.count} simulations)"
            )
        lower, upper = upper, 2 * upper
    return lower, upper


class GrowthTest:
    """Simulations of a scene, each under another size of a load; given: settings in [integrate]."""

    def __init__(
        self,
        family: LoadFamily,
        span: float,
        growth: float | None = None,
        disturbance: str | None = None,
        progress: Callable[[float, bool], None] = lambda force, grew: None,
        target: str | None = None,
        given: Mapping[str, Any] = MappingProxyType({}),
    ):
        self.family, self.span, self.growth, self.progress = family, span, growth, progress
        settings = self.settings = TOLERANCES[growth is None] | {**given}
        self.count = 0
        system = family.rod.system
        self.model = system.model(target)
        self.seen = growth or MEASURED
        self.start = _disturbance_angles(system.scene, disturbance, AMPLITUDE[growth is None])
        self.ends = np.linspace(0.0, span, PIECES + 1)
        complete = system.with_settings(**settings).settings
        if complete.has_fixed_step and (step := complete.step):
            # A piece of whole steps: every shortened one would disturb the fastest motions.
            piece = max(1, round(span / PIECES / step)) * step
            self.ends = np.append(np.arange(0.0, span - piece / 2, piece), span)
        settings["output_every"] = self.ends[1] * PIECES / SAMPLES

    def has_growth(self, force: float) -> bool:
        """Whether a motion grows under a force; in a run that blows up it does."""
        self.count += 1
        grew = self._has_growth(force)
        self.progress(force, grew)
        return grew

    def _has_growth(self, force: float) -> bool:
        """Simulate piece by piece and stop at growth, as large motions cost the most."""
        rod, at = self.family.rod, self.family.steady_state(force).at
        y = rod.state_in_flight(at)
        y[rod.n_base : rod.n_base + rod.n_moving] += self.start
        load = self.family.load.parts.items()
        system = rod.system.at({rod.system.key_of(name): force * part for name, part in load})
        most, bent = np.inf, []
        for start, end in pairwise(self.ends.tolist()):
            try:
                piece = system.with_settings(span=[start, end], **self.settings).at(y0=y)
                solution = simulate(piece, model=self.model)
            except RunError:
                return True
            angles, rates = _relative_angles(solution, rod.all_angles(at.phi))
            states = solution.y[:, solution.y.shape[1] - len(at.added) :] - at.added
            if start == 0:
                most = (self.growth or FAR) * np.abs(angles[0]).max()
            if np.abs(angles).max() > most:
                return True
            y = solution.y[-1]
            # The last sample of a piece is the first of the next.
            turned = self._mean_rotation(solution, at.phi)
            bent.append((angles[:-1], rates[:-1], states[:-1], turned[:-1]))
        if self.growth:
            return False
        parts = [np.concatenate(part) for part in zip(*bent, strict=True)]
        return dmd_growth(parts, self._noise_share(at)) > self.seen

    def _mean_rotation(self, solution: Solution, steady: Array) -> Array:
        """Mean angle of the links [rad], less that of the steady state, and its rate [rad/s], of a
        free rod whose loads depend on the motion (samples, 2); else (samples, 0)."""
        if not (self.family.rod.n_base and self.family.rod.has_feedback):
            return np.zeros((len(solution.t), 0))
        means = solution.phi.mean(axis=1) - steady.mean(), solution.omega.mean(axis=1)
        return np.stack(means, axis=1)

    def _noise_share(self, at: Unknowns) -> float:
        """Share of the strongest direction that is lost in errors of a run: where angles or added
        states of the steady state are not zero, errors are relative to these, not to the
        disturbance."""
        span = [0.0, float(self.ends[-1])]
        integrate = self.family.rod.system.with_settings(span=span, **self.settings).settings
        size = float(max(np.abs(at.phi).max(initial=0.0), np.abs(at.added).max(initial=0.0)))
        small = float(np.abs(self.start).max())
        if integrate.has_fixed_step or size <= small:
            return FAINT
        return max(FAINT, NOISE * (integrate.atol + integrate.rtol * size) / small)


def _disturbance_angles(scene: Scene, disturbance: str | None, amplitude: float) -> Array:
    """Disturbance of the angles of the moving links at the start [rad]."""
    default = (DISTURBED_CLAMPED if scene.boundary_condition.is_clamped else DISTURBED).format(
        amplitude
    )
    text = disturbance or default
    s = scene.mesh.middles[scene.n_fixed_links :]
    values = np.broadcast_to(Expression(text, "s", "disturbance")(s), s.shape)
    if not (np.isfinite(values).all() and values.any()):
        raise InputError("disturbance", disturbance, "finite, and not zero on every link")
    return np.asarray(values, dtype=float)


def _relative_angles(solution: Solution, steady: Array) -> tuple[Array, Array]:
    """Angles between neighbouring links, or a link and its clamp, at every sample [rad], less those
    of the steady state, and their rates [rad/s]."""

    def differences(links: Array) -> Array:
        if solution.scene.boundary_condition.root:
            links = np.concatenate((np.zeros((len(links), 1)), links), axis=1)
        return links if links.shape[1] == 1 else np.diff(links, axis=1)

    return differences(solution.phi - steady), differences(solution.omega)
