"""Errors of an analysis, its warnings, and how every one runs: on one BLAS thread, and without a
traceback for numbers beyond range."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from rodgen.errors import AnalysisError

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
    """The function with BLAS held to one thread, since for small problems it would wake all cores
    and wait for the last, and with AnalysisError where a number leaves the range of doubles."""

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
