"""A kick: the jump of the rates under an impulse."""

from __future__ import annotations

import math
from functools import lru_cache
from types import ModuleType

import numpy as np
from threadpoolctl import ThreadpoolController

from rodgen.integrate.stepper import Array
from rodgen.scene import SceneError


def kicked(
    model: ModuleType,
    y: Array,
    p: Array,
    link: int,
    share: float,
    impulse: tuple[float, float],
) -> Array:
    """The state (states,) after an impulse [N s] at a share of a link, from 0 at its start to 1 at
    its end: M du is its generalised force. Raises SceneError."""
    if isinstance(link, bool) or not isinstance(link, int) or not 0 <= link < model.N:
        raise SceneError("kick.link", link, f"the number of a link, from 0 to {model.N - 1}")
    if not 0 <= _number("kick.share", share) <= 1:
        raise SceneError("kick.share", share, "from 0 at the start of the link to 1 at its end")
    force = np.array([_number("kick.impulse", part) for part in impulse])
    if force.shape != (2,):
        raise SceneError("kick.impulse", impulse, "two numbers, in N s")
    # On one thread: others would be waited for longer than they help.
    with np.errstate(all="ignore"), _threads().limit(limits=1, user_api="blas"):
        M, pushed = model.mass_matrix(y, p), model.generalised_force(y, p, link, share, force)
        try:
            jump = np.linalg.solve(M, pushed)
        except np.linalg.LinAlgError:
            jump = np.full(len(pushed), math.nan)
        after: Array = y + np.concatenate((np.zeros(len(y) - len(jump)), jump))
        finite = np.isfinite(after).all() and np.isfinite(model.energy(after, p)).all()
    if not finite:
        raise SceneError("kick.impulse", impulse, "such that rates and energy stay finite")
    return after


@lru_cache(maxsize=1)
def _threads() -> ThreadpoolController:
    return ThreadpoolController()


def _number(field: str, value: object) -> float:
    """A finite number. Raises SceneError."""
    if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
        return float(value)
    raise SceneError(field, value, "a finite number")
