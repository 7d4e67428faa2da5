"""How fast the motion that grows most grows, read off the samples of a run.

Dynamic mode decomposition: the linear map that takes every sample to the one half a run later is
fitted in the few directions in which the samples move; its largest eigenvalue says by how much a
motion has grown in that time (P. J. Schmid, Dynamic mode decomposition of numerical and
experimental data, J. Fluid Mech. 656, 2010). So long a step makes slow growth stand out against
the errors of the run, and does not care how fast anything oscillates.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rodgen.integrate.stepper import Array

FAINT = 1e-6  # of the strongest direction: what is weaker is lost in errors of the run


def growth_in(parts: Sequence[Array]) -> float:
    """Factor by which the motion that grows most grows over all samples, evenly spaced in time.

    parts: quantities (samples, k) that are linear in the motion, such as angles and their rates;
    each part is measured by its own size. Zero where nothing moves.
    """
    sizes = [float(np.linalg.norm(part)) for part in parts]
    moving = [part / size for part, size in zip(parts, sizes, strict=True) if size > 0]
    if not moving:
        return 0.0
    samples = np.concatenate(moving, axis=1).T
    lag = samples.shape[1] // 2
    directions, strengths, course = np.linalg.svd(samples[:, :-lag], full_matrices=False)
    kept = strengths > FAINT * strengths[0]
    later = directions[:, kept].T @ samples[:, lag:]
    carried = later @ course[kept].T / strengths[kept]
    most = float(np.abs(np.linalg.eigvals(carried)).max())
    return float(most ** ((samples.shape[1] - 1) / lag))
