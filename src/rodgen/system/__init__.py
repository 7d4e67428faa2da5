"""Systems: scenes prepared for computation, and copies of them with other numbers."""

from rodgen.system.parameter_map import ParameterMap, ParameterSlot
from rodgen.system.parameter_range import ParameterLine, ParameterRange, system_at_start
from rodgen.system.system import System
