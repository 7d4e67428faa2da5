"""Growth of small errors in a run: a neighbouring motion beside it is brought back again and again.

G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9-20.
"""

from __future__ import annotations

import math

import numpy as np

from rodgen.arrays import Array
from rodgen.integrate.dense_output import DenseOutput
from rodgen.integrate.stepper import StepError
from rodgen.integrate.trajectory import ErrorGrowth, Trajectory
from rodgen.scene.integration import IntegrationTable

SHARE = 0.01  # of the run's tolerance, that of both motions
ABOVE = 1e3  # times that tolerance: what sets them apart is not the error of their steps
NEAR = 1e-6, 1e-3  # rad: the neighbour at first, at least and at most
FAR = 1e-2  # rad: from here on what is not linear counts
PIECES = 16  # of the run, at least
SHORTEST = 1e-6  # of the run, a piece
LOOKS = 32  # times in a piece at which they are compared, as what swings passes through zero
WAVES = 4  # of a smooth disturbance along the rod
VISIBLE = 1e-3  # rad: errors that are seen,
EXPECTED = 100.0  # where they are more than so many times the tolerance
LARGEST = math.log(np.finfo(float).max)


UNKNOWN = ErrorGrowth(math.nan, math.nan, math.nan)


def error_growth(trajectory: Trajectory) -> ErrorGrowth:
    """Find how fast small errors grow in the motion of a run, from its start to its last state.

    Two motions are followed by the method of the run, with a hundredth of its tolerance or with its
    fixed step, which costs some three to six times the run. Events are not looked for: none but the
    end of the run changes the motion. Not-a-number where a step fails. Raises InputError for a run
    that was changed while it went on, or has no samples.
    """
    run, settings = DenseOutput(trajectory, SHARE), trajectory.scene.integrate
    seen = math.inf if settings.has_fixed_step else visible_error(settings.rtol) / settings.rtol
    try:
        base, added = (
            2 * trajectory.scene.boundary_condition.translates,
            len(trajectory.scene.states),
        )
        angles = slice(base, (run.y.shape[1] - added) // 2)
        return _follow_neighbour(run, angles, math.log(seen))
    except StepError:
        return UNKNOWN


def visible_error(rtol: float) -> float:
    """Error [rad] from which on it counts as seen in a run with this tolerance."""
    return max(VISIBLE, EXPECTED * rtol)


def _follow_neighbour(run: DenseOutput, angles: slice, seen: float) -> ErrorGrowth:
    """Follow both motions; angles: which states are; seen: logarithm of a visible factor."""
    at, y = run.first, run.y[0]
    near, least = _initial_distance(run.settings), SHORTEST * (run.last - at)
    off = start = _disturbance(len(y), angles, near)
    piece = (run.last - at) / PIECES
    grown, most, when = 0.0, 0.0, math.inf  # logarithms, and a time
    while run.last - at > least:
        times = np.linspace(at, min(at + piece, run.last), LOOKS + 1)[1:]
        here, there = (run.integrate_from(at, state, times) for state in (y, y + off))
        apart = np.linalg.norm((there - here)[:, angles], axis=1)
        largest = apart.max()
        if largest > FAR and piece > least:
            piece /= 2
            continue
        over = apart > near * math.exp(min(seen - grown, LARGEST))
        if over.any():
            when = min(when, float(times[over][0]))
        at, y = float(times[-1]), here[-1]
        # New errors come all the time: what has died out does not keep them from growing.
        grown = max(0.0, grown + math.log(largest / near)) if largest else 0.0
        most = max(most, grown)
        off = (there[-1] - here[-1]) * (near / largest) if largest else start
    factor = math.exp(most) if most < LARGEST else math.inf
    decades = most / math.log(10.0)
    tenfold = (run.last - run.first) / decades if decades else math.inf
    return ErrorGrowth(factor, tenfold, when)


def _initial_distance(settings: IntegrationTable) -> float:
    """Initial distance of the neighbour [rad]."""
    least, largest = NEAR
    if settings.has_fixed_step:  # both make the same errors
        return least
    return min(largest, max(least, ABOVE * max(settings.rtol, settings.atol)))


def _disturbance(states: int, angles: slice, size: float) -> Array:
    """Disturbance of the angles, (states,), of this norm [rad]: half smooth along the rod, half
    rough, as either may be what grows."""
    links = angles.stop - angles.start
    random = np.random.default_rng(1)
    s = (np.arange(links) + 0.5) / links
    smooth = random.standard_normal(WAVES) @ np.cos(np.pi * np.outer(np.arange(WAVES), s))
    rough = random.standard_normal(links)
    shape = smooth / np.linalg.norm(smooth) + rough / np.linalg.norm(rough)
    off = np.zeros(states)
    off[angles] = shape * (size / np.linalg.norm(shape))
    return off
