"""Points of which a scene is analysed, one after the other."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.endings import FAILED
from rodgen.integrate.solution import RunError
from rodgen.studies.block_arrays import Made
from rodgen.studies.findings import analysed, kept_value
from rodgen.studies.keep import found
from rodgen.studies.points import Point
from rodgen.studies.time_limit import TooLong, time_limit

if TYPE_CHECKING:
    from rodgen.studies.study import Study


def compute(study: Study, points: list[Point], made: Made) -> None:
    """Fill in what the analysis of every point finds."""
    asked = found(study)
    count = max((one.count for one in asked), default=0)
    for at, point in enumerate(points):
        start = time.process_time()
        try:
            system = study.system_at(point)
            with time_limit(study.time_limit, system):
                result = analysed(study.what, system, study.options, count)
            made.set(
                at,
                {one.text: kept_value(one.row, result, one.count) for one in asked},
                float("nan"),
                "",
                len(result.doubts),
            )
        except (InputError, AnalysisError, RunError) as error:
            made.fail(at, str(error), getattr(error, "status", FAILED))
        except TooLong:
            made.stop(at, study.time_limit)
        made.arrays["seconds"][at] = time.process_time() - start
