"""Functions of compiled modules, for callers without Python in between.

Compiled modules use it: here, and beside modules where rodgen is not installed, so that it needs
Python's own library and nothing of rodgen.
"""

import ctypes
from typing import Any

_TYPES = {"double": ctypes.c_double, "size_t": ctypes.c_size_t}


class Function:
    """A C function of a module, such as `rhs.compiled`.

    address: where it lies in this process, as a whole number; signature: as C has it.
    """

    def __init__(self, ffi: Any, library: Any, name: str):
        pointer = getattr(library, name)
        kind = ffi.typeof(pointer)
        self._library = library  # which is unloaded when nobody holds it
        self._arguments: list[Any] = [_TYPES.get(one.cname) for one in kind.args]
        self.address = int(ffi.cast("uintptr_t", pointer))
        self.signature = str(ffi.getctype(kind, name))

    def __repr__(self) -> str:
        return f"<Function {self.signature} at {self.address:#x}>"

    def ctypes_pointer(self) -> Any:
        """Function pointer of ctypes, which functions compiled by Numba can call with arrays as
        `array.ctypes`."""
        array: Any = ctypes.POINTER(ctypes.c_double)
        made: Any = ctypes.CFUNCTYPE(None, *[kind or array for kind in self._arguments])(
            self.address
        )
        made.library = self._library  # what it points into
        return made

    def low_level_callable(self) -> Any:
        """Function as a `scipy.LowLevelCallable`."""
        from scipy import LowLevelCallable

        return LowLevelCallable(self.ctypes_pointer())
