"""Analyses of points, one after the other."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from rodgen.errors import AnalysisError, InputError
from rodgen.integrate.run_status import FAILED
from rodgen.integrate.solution import RunError
from rodgen.studies.analysis_results import analyse, kept_value
from rodgen.studies.kept_quantities import analysis_rows
from rodgen.studies.point_arrays import PointArrays
from rodgen.studies.sampling import Point
from rodgen.studies.time_limit import TimeLimitExceeded, time_limit

if TYPE_CHECKING:
    from rodgen.studies.study import Study


def compute(study: Study, points: list[Point], made: PointArrays) -> None:
    """Analyse every point, and fill in its results."""
    asked = analysis_rows(study)
    count = max((one.count for one in asked), default=0)
    for at, point in enumerate(points):
        start = time.process_time()
        try:
            system = study.system_at(point)
            with time_limit(study.time_limit, system):
                result = analyse(study.what, system, study.options, count)
            made.set_point(
                at,
                {one.text: kept_value(one.row, result, one.count) for one in asked},
                float("nan"),
                "",
                len(result.doubts),
            )
        except (InputError, AnalysisError, RunError) as error:
            made.fail(at, str(error), getattr(error, "status", FAILED))
        except TimeLimitExceeded:
            made.time_out(at, study.time_limit)
        made.arrays["seconds"][at] = time.process_time() - start
