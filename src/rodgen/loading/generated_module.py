"""Generated modules, loaded from text or made part by part."""

from __future__ import annotations

import linecache
import tempfile
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any, Self

import numpy as np

from rodgen.emit.targets import PART_OF, PARTS, available_parts, target_of
from rodgen.errors import InputError
from rodgen.native import native_run
from rodgen.native.library import BuildError
from rodgen.scene.structure import Structure

Namespace = Mapping[str, Any]
ModuleFunction = Callable[..., Any]
CONTRACT = (
    *("N", "BOUNDARY", "INERTIA", "TERMS", "STATE", "PARAMETERS", "PROVENANCE"),
    *("parameters", "rhs", "jac", "mass_matrix", "energy"),
    *("joints", "centre_of_gravity", "inertia"),
    *("bending_moments", "forces", "generalised_force"),
)


# Names that not every structure and target has: offered once they are there.
SOME_HAVE = {
    "VARIATIONS",
    "air",
    "contacts",
    "signals",
    "start_loads",
    "support_forces",
    "velocities",
}


class Model(ModuleType):
    """A generated module.

    One that `build` made has the parts that were asked for; the others are made when one of their
    names is asked for. Its copy is itself; where it is unpickled, it is built again.
    """

    def __init__(
        self, name: str, more: Callable[[Iterable[str]], dict[str, Namespace]] | None = None
    ):
        """more: makes namespaces of parts by part; none for what is loaded whole."""
        super().__init__(name)
        self.__dict__.update(_more=more, _made=set(), _lock=RLock())

    def make(self, parts: Iterable[str]) -> None:
        """Make missing parts. Raises InputError and BuildError where one cannot be made."""
        with self._lock:
            missing = [part for part in parts if part not in self._made]
            for part, names in self._more(missing).items() if missing else ():
                first = not self._made
                self._made.add(part)
                operations = self.__dict__.get("PROVENANCE", names["PROVENANCE"])["operations"]
                operations.update(names["PROVENANCE"]["operations"])
                kept = (
                    names.keys() - self.__dict__.keys() if first else {*PARTS[part]} & names.keys()
                )
                self.__dict__.update((name, names[name]) for name in kept)
                if part == "flow":
                    self.Run.equations.newton = lambda: self.NEWTON
                if part == "tangents" and "VARIATIONS" in names:
                    self.VARIATIONS.newton = lambda: self.NEWTON

    def __getattr__(self, name: str) -> Any:
        if self.__dict__.get("_more") is not None:
            if name in native_run.STATUSES or name == "COMPILED":
                if target_of(self.PROVENANCE["target"]).compiled:
                    return native_run.STATUSES.get(name, native_run.METHODS)
            elif name in PART_OF and PART_OF[name] in available_parts(self.PROVENANCE["target"]):
                self.make((PART_OF[name],))
                if name in self.__dict__:
                    return self.__dict__[name]
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        more = () if self._more is None else available_parts(self.PROVENANCE["target"])
        later = {name for part in more for name in PARTS[part]} - SOME_HAVE
        names = {*super().__dir__(), *later}
        return sorted(names - self.__dict__.get("_INSIDE", set()))

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, _: object) -> Self:
        return self


def structure_of(module: ModuleType) -> Structure:
    """Structure to which a generated module is specialised."""
    rod = module.N, module.BOUNDARY, module.INERTIA, module.TERMS
    expressions = tuple(getattr(module, "EXPRESSIONS", {}).items())
    states = tuple(getattr(module, "STATES", {}).items())
    spring, masses = getattr(module, "SPRING", ""), getattr(module, "MASSES", ())
    nonuniform, tables = (
        getattr(module, "NONUNIFORM", ()),
        tuple(getattr(module, "TABLES", {}).items()),
    )
    places = getattr(module, "SENSOR_PLACES", ())
    return _cached_structure(*rod, expressions, nonuniform, states, spring, masses, tables, places)


@lru_cache(maxsize=64)
def _cached_structure(*of: Any) -> Structure:
    """Structure, cached: it is asked for again and again as a run is watched."""
    return Structure(*of)


def call_module(model: ModuleType, function: str | ModuleFunction, t: Any, *arrays: Any) -> Any:
    """Call a function of a module, or a function of (module, t, *arrays), on arrays of states and
    parameters; t: times [s] of the states, passed on where the masses of the module or its base are
    functions of time. A function that asks for the rates of the states gets them."""
    if not isinstance(function, str):
        return function(model, t, *arrays)
    made = getattr(model, function)
    if function in getattr(model, "BY_RATES", ()):
        return made(*arrays, rates_of(model, *arrays))
    return made(*arrays, t) if function in getattr(model, "IN_TIME", ()) else made(*arrays)


def rates_of(model: ModuleType, t: Any, y: Any, p: Any) -> Any:
    """Rates of many states, (..., states); t: times [s], (...); y: states, (..., states)."""
    y = np.asarray(y, dtype=float)
    times, rates = np.broadcast_to(t, y.shape[:-1]), np.empty(y.shape)
    for at in np.ndindex(y.shape[:-1]):
        rates[at] = model.rhs(float(times[at]), y[at], p)
    return rates


def load_files(texts: dict[str, str], whole: bool = True) -> ModuleType:
    """Load a generated module from its texts by file name, the Python module first; whole: all of
    its contract is to be there."""
    (name, text), *beside = texts.items()
    if not beside:
        return load_text(text, Path(name).stem, whole=whole)
    with tempfile.TemporaryDirectory(prefix="rodgen-", ignore_cleanup_errors=True) as folder:
        for other, content in beside:
            Path(folder, other).write_text(content, encoding="utf-8", newline="\n")
        return load_text(text, Path(name).stem, str(Path(folder, name)), whole)


def load_module(path: Path) -> ModuleType:
    """Load a generated module from its file; raises InputError if it is not one."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise InputError("module", str(path), "the path of a generated Python module") from None
    return load_text(text, path.stem, str(path))


def load_text(text: str, name: str, origin: str | None = None, whole: bool = True) -> ModuleType:
    """Run the text of a generated module.

    It is not entered into sys.modules: two modules of one name do not get in each other's way.
    """
    origin = origin or f"<{name}>"
    module = Model(name)
    module.__file__ = origin
    linecache.cache[origin] = (len(text), None, text.splitlines(keepends=True), origin)
    try:
        exec(compile(text, origin, "exec"), module.__dict__)
    except (MemoryError, BuildError):
        raise
    except RuntimeError as error:
        if type(error).__name__ == "BuildError":  # of what lies beside the module
            raise BuildError(str(error)) from error
        raise InputError("module", origin, f"a module that loads ({error!r})") from error
    except (Exception, SystemExit) as error:
        raise InputError("module", origin, f"a module that loads ({error!r})") from error
    missing = [needed for needed in CONTRACT if not hasattr(module, needed)]
    if missing and whole:
        raise InputError("module", origin, f"generated by rodgen (no {', '.join(missing)})")
    return module
