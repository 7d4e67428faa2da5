"""Computation of points of a study: no Dask, no files, and no exception where a point fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.studies import point_analyses, point_runs
from rodgen.studies.kept_quantities import RUN, variables
from rodgen.studies.point_arrays import PointArrays

if TYPE_CHECKING:
    from rodgen.studies.study import Study


def evaluate(
    study: Study, points: Sequence[Mapping[str, Any]], indices: Sequence[int] = ()
) -> dict[str, NDArray[Any]]:
    """Compute what a study keeps of some of its points: arrays by the names of variables, whose
    first axis is the points.

    points: values by varied names; indices: their numbers in the study, which nothing depends on. A
    point that cannot be built or computed has status "failed", its reason as message, and fill
    values. But for `seconds`, the results of a point do not depend on the others, their number or
    order, to the bit. Raises InputError for a quantity that cannot be kept.
    """
    made = PointArrays(variables(study), len(points))
    given = [dict(point) for point in points]
    with np.errstate(all="ignore"):
        (point_runs if study.what == RUN else point_analyses).compute(study, given, made)
    return made.arrays
