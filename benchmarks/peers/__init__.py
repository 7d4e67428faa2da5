"""What a user would pick instead: the same rod, free, uniform, with a follower force.

Every file offers NAME, SIZES (numbers of links) and prepare(n).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

from problem import Vector
from timing import Batch

FILES = ("numba_chain", "casadi_c", "pinocchio_aba", "mujoco_forward", "pydy_kane")


@dataclass(frozen=True)
class Prepared:
    """A peer for one number of links.

    rhs: state to derivative, both in rodgen's order; what is checked.
    batch: calls of the peer's own function at the state last given to rhs, without any
        conversion from rodgen's state; what is timed.
    in_c: whether the calls are made from C.
    """

    rhs: Callable[[Vector], Vector]
    batch: Batch
    in_c: bool = False


def peers() -> Iterator[tuple[str, ModuleType | ImportError]]:
    """Every peer's file by name; the error where it cannot be imported."""
    for name in FILES:
        try:
            yield name, import_module(f"peers.{name}")
        except ImportError as error:
            yield name, error
