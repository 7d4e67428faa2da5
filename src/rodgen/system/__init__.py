"""A scene made ready to compute with, and the same with other numbers."""

from rodgen.system.parameter_map import ParameterMap, ParameterSlot
from rodgen.system.parameter_range import ParameterLine, ParameterRange, start_at
from rodgen.system.system import System

__all__ = [
    "ParameterLine",
    "ParameterMap",
    "ParameterRange",
    "ParameterSlot",
    "System",
    "start_at",
]
