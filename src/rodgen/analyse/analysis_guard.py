"""Decorator of every analysis: one BLAS thread, doubts as warnings, overflow as AnalysisError."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from rodgen.errors import AnalysisError
from rodgen.result import warns_of_doubts

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


@lru_cache(maxsize=1)
def _thread_controller() -> ThreadpoolController:
    import scipy.linalg  # noqa: F401, whose BLAS has to be loaded to be found
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def guard_analysis(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate an analysis to warn of every doubt about its result, to run on one BLAS thread
    (waking others costs more than they save on small problems), and to raise AnalysisError where a
    number leaves the range of doubles."""

    @warns_of_doubts
    @wraps(function)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
        import numpy as np  # here, as commands need the errors alone

        try:
            with _thread_controller().limit(limits=1, user_api="blas"), np.errstate(all="ignore"):
                return function(*args, **kwargs)
        except (np.linalg.LinAlgError, ZeroDivisionError, OverflowError) as error:
            raise AnalysisError(
                f"numbers too large or too small for double precision ({error})"
            ) from error

    return wrapper
