"""Callables to Solutions: one method a file, sampling, work, storage."""

from rodgen.integrate.simulate import Interrupted, RunError, simulate
from rodgen.integrate.solution import Solution

__all__ = ["Interrupted", "RunError", "Solution", "simulate"]
