"""Callables to Solutions: methods, samples, events, work, storage."""

from rodgen.integrate.methods.choose import Choice, choose
from rodgen.integrate.simulate import resume, simulate
from rodgen.integrate.solution import Interrupted, RunError, Solution
from rodgen.integrate.trajectory import Event

__all__ = [
    "Choice",
    "Event",
    "Interrupted",
    "RunError",
    "Solution",
    "choose",
    "resume",
    "simulate",
]
