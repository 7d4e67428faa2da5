"""Integration of scenes in time: methods, samples, events, work and result files."""

from rodgen.integrate.methods.method_choice import Choice, choose
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
