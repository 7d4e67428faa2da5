"""Errors of an analysis, its warnings, and how every one runs: on one BLAS thread, and without a
traceback for numbers beyond range."""

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
def _controller() -> ThreadpoolController:
    import scipy.linalg  # noqa: F401, whose BLAS has to be loaded to be found
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def guarded(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function with a warning of every doubt about what it returns, on one BLAS thread
    (for small problems others would be woken, and waited for), and with AnalysisError where a
    number leaves the range of doubles."""

    @warns_of_doubts
    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> R:
        import numpy as np  # here, as commands need the errors alone

        try:
            with _controller().limit(limits=1, user_api="blas"), np.errstate(all="ignore"):
                return function(*args, **kwargs)
        except (np.linalg.LinAlgError, ZeroDivisionError, OverflowError) as error:
            raise AnalysisError(
                f"numbers too large or too small for double precision ({error})"
            ) from error

    return run
