"""Points of a study to what is kept of them: no Dask, no files, and no exception for a point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rodgen.studies import analyses, runs
from rodgen.studies.block_arrays import Made
from rodgen.studies.keep import RUN, variables

if TYPE_CHECKING:
    from rodgen.studies.study import Study


@dataclass(frozen=True)
class Block:
    """What is kept of some points: arrays by the names of variables, first axis the points."""

    arrays: dict[str, NDArray[Any]]


def evaluate(
    study: Study, points: Sequence[Mapping[str, Any]], indices: Sequence[int] = ()
) -> Block:
    """What a study keeps of some of its points.

    points: values by varied names; indices: their numbers in the study, which nothing depends on.
    A point that cannot be built or computed has status "failed", its reason as message, and fill
    values. But for `seconds`, what comes out of a point does not depend on the others, their
    number or order, to the bit. Raises InputError for a study that keeps what there is not.
    """
    made = Made(variables(study), len(points))
    given = [dict(point) for point in points]
    with np.errstate(all="ignore"):
        (runs if study.what == RUN else analyses).compute(study, given, made)
    return Block(made.arrays)
