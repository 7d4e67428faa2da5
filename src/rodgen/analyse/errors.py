"""Errors of an analysis, its warnings, and how every one runs: on one BLAS thread, and without a
traceback for numbers beyond range."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

if TYPE_CHECKING:
    import xarray
    from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
R = TypeVar("R")


class AnalysisError(ArithmeticError):
    """An analysis has no result; the message says what was searched.

    Examples
    --------
    >>> import rodgen
    >>> try:
    ...     rodgen.critical_force(rodgen.Scene.example("ziegler"), highest=1.0)
    ... except rodgen.AnalysisError as error:
    ...     print("none below 1 N")
    none below 1 N
    """


class BranchInterrupted(KeyboardInterrupt):
    """Ctrl-C while a branch, a boundary or a family of motions was followed.

    found: the Dataset of the points so far. Give it as ``resume`` to continue.

    Examples
    --------
    >>> import rodgen
    >>> scene, key = rodgen.Scene.example("euler_column"), "loads.tip.y"
    >>> try:
    ...     branch = rodgen.continue_equilibria(scene, key, (0, -5))
    ... except rodgen.BranchInterrupted as stopped:
    ...     branch = rodgen.continue_equilibria(scene, key, (0, -5), resume=stopped.found)
    """

    def __init__(self, found: xarray.Dataset):
        super().__init__(f"interrupted after {found.sizes['point']} points")
        self.found = found

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.found,)


class MeshWarning(UserWarning):
    """Results for several numbers of links do not belong to the same rod.

    Examples
    --------
    >>> import rodgen, warnings
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", rodgen.MeshWarning)
    ...     limit = rodgen.richardson([10, 20, 40], [1.03, 1.0075, 1.001875])
    """


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
