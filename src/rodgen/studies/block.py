"""Blocks of points, computed in one go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.integrate.endings import FAILED, FINISHED
from rodgen.integrate.simulate import simulate
from rodgen.scene import SceneError
from rodgen.studies.keep import variables

if TYPE_CHECKING:
    from rodgen.studies.specification import Study


@dataclass(frozen=True)
class Block:
    """What came out of points: arrays by the names of the variables, first axis the points."""

    arrays: Mapping[str, NDArray[Any]]


def evaluate(study: Study, points: Sequence[Mapping[str, Any]], indices: Sequence[int]) -> Block:
    """Compute points of a study."""
    kept = variables(study)
    arrays = {
        one.name: np.full(
            (len(points), *one.shape),
            one.fill,
            np.dtypes.StringDType() if one.dtype.startswith("U") else one.dtype,
        )
        for one in kept
    }
    for at, point in enumerate(points):
        begun = process_time()
        try:
            solution = simulate(study.scene_at(point))
            for one, how in zip(kept, study.keep, strict=False):
                arrays[one.name][at] = how(solution) if callable(how) else solution.energy_error
            arrays["energy_error"][at] = np.nan
            arrays["status"][at] = FINISHED
        except SceneError as error:
            arrays["status"][at], arrays["message"][at] = FAILED, str(error)
        arrays["seconds"][at] = process_time() - begun
    return Block(arrays)
