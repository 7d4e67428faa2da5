"""Many runs of a C module side by side, each in a lane of its own until it ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .library import library_environment, load_library
from .native_run import HEADERS, STATUSES, NativeFunctions, cffi_declarations, header_numbers

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NUMBERS = header_numbers("lanes.h")
LANES, HUNGRY = NUMBERS["LANES"], NUMBERS["HUNGRY"]
REACHED, REFUSED = STATUSES["REACHED"], STATUSES["REFUSED"]
STOPPED = NUMBERS["STOPPED"]
# What is made of the samples of a number, by name.
KEEPS = {name[5:].lower(): at for name, at in NUMBERS.items() if name.startswith("KEEP_")}
FILES = (
    *("lanes.c", "lane_steps.c", "lane_dense.c", "lane_samples.c", "crossings.c", "reductions.c"),
    *("lanes.h", "lane_moves.h", "many.h", *HEADERS),
)
ROUNDS = 64  # steps of all lanes between two looks at whether to stop

# Structures of lanes.h.
KEPT = np.dtype(
    {
        "names": ["reduction", "less_start", "first", "terms", "from", "to"],
        "formats": ["i8", "i8", "u8", "u8", "f8", "f8"],
    }
)
STRETCH = np.dtype([("end", "f8"), ("low", "f8"), ("high", "f8")])
COURSE = np.dtype([("first", "u8"), ("count", "u8"), ("longest", "f8"), ("pole", "i8")])
OUTCOME = np.dtype(
    [
        *(("t", "f8"), ("status", "i8"), ("steps", "i8"), ("rejected", "i8"), ("rhs", "i8")),
        ("stopped", "i8"),
    ]
)
NUMBER = np.dtype([("first", "u8"), ("terms", "u8")])
WATCHED = np.dtype(
    {
        "names": [
            *("rising", "falling", "looks", "stops", "level", "from", "to"),
            *("first", "terms", "place", "most", "first_number", "numbers"),
        ],
        "formats": ["i8"] * 4 + ["f8"] * 3 + ["u8"] * 6,
    }
)
JOB = np.dtype(
    [
        *(("method", "i8"), ("start", "f8"), ("step", "f8"), ("rtol", "f8"), ("atol", "f8")),
        *(("budget", "i8"), ("stride", "i8"), ("creep", "f8"), ("p", "u8"), ("y", "u8")),
        *(("p_stride", "u8"), ("y_stride", "u8"), ("samples", "u8"), ("times", "u8")),
        *(("course_of", "u8"), ("courses", "u8"), ("stretches", "u8"), ("observes", "i8")),
        *(("energies", "u8"), ("kept", "u8"), ("keep", "u8"), ("rows", "u8"), ("weights", "u8")),
        *(("watched", "u8"), ("looks", "i8"), ("watch", "u8"), ("numbers", "u8")),
        *(("crossed_width", "u8"), ("traced", "u8"), ("trace", "u8"), ("traces", "u8")),
        *(("state", "u8"), ("values", "u8")),
        *(("crossed", "u8"), ("outcome", "u8")),
        *(("next", "u8"), ("end", "u8"), ("more", "i8")),
    ]
)


def lane_library() -> tuple[Any, Any]:
    """cffi's FFI object and the library of steps of many rods, built once a machine.

    Raises BuildError where there is none to be had.
    """
    return _lane_library(library_environment())


@lru_cache(maxsize=4)
def _lane_library(_: tuple[str | None, ...]) -> tuple[Any, Any]:
    folder = Path(__file__).parent
    told = "".join(cffi_declarations(folder / name) for name in ("methods.h", "steps.h", "lanes.h"))
    return load_library("lanes", folder, told, FILES)


@dataclass(frozen=True, eq=False)
class Lanes:
    """Equations of rods side by side, for the steps of many rods.

    states: of y; base: numbers of y before the angles; added: behind positions and velocities;
    parameters: numbers of p; works: names of the loads without potential; observed: names of what
    is observed.
    """

    part: NativeFunctions
    states: int
    base: int
    added: int
    parameters: int
    works: tuple[str, ...]
    observed: tuple[str, ...]

    @classmethod
    def from_library(cls, ffi: Any, library: Any, stem: str, *sizes: Any) -> Lanes:
        """Lanes of a generated module."""
        return cls(
            NativeFunctions.from_library(
                ffi, library, f"{stem}_lanes", "work", ("flow", "observed")
            ),
            *sizes,
        )

    @cached_property
    def handles(self) -> tuple[Any, Any, Any]:
        """cffi's FFI object, the library of the steps, and a struct rodgen_lanes."""
        ffi, library = lane_library()
        system = ffi.new("struct rodgen_lanes *")
        system.states, system.base, system.added = self.states, self.base, self.added
        system.parameters = self.parameters
        system.works, system.observed = len(self.works), len(self.observed)
        system.work_size = self.part.size
        flow, observe = (self.part.functions[name] for name in ("flow", "observed"))
        system.flow = ffi.cast(ffi.typeof(system.flow), flow)
        system.observe = ffi.cast(ffi.typeof(system.observe), observe)
        return ffi, library, system


class SharedArrays:
    """Arrays by the names that struct rodgen_many has for them, and their addresses."""

    def __init__(self, **arrays: NDArray[Any]):
        self._arrays = arrays  # which live as long as their addresses are in use
        self.fields: dict[str, float] = {
            name: array.ctypes.data if array.size else 0 for name, array in arrays.items()
        }


class RunBatch:
    """Runs of many rods; what they share is given once, and any number of threads may work on it.

    p: parameters (rods or 1, parameters); y: states (rods or 1, states) at the start; shared: all
    other arrays; fields: all other numbers of struct rodgen_many, by name. state (rods, states +
    works), values (rods, kept), crossed (rods, crossed_width), traces (rods, traced, samples + 1)
    and outcome (rods,) are filled as runs go and end.
    """

    def __init__(
        self,
        lanes: Lanes,
        rods: int,
        p: Array,
        y: Array,
        shared: Sequence[SharedArrays],
        fields: Mapping[str, float],
    ):
        self.state = np.empty((rods, lanes.states + len(lanes.works)))
        self.values = np.empty((rods, int(fields["kept"])))
        self.crossed = np.zeros((rods, int(fields["crossed_width"])))
        self.traces = np.empty((rods, int(fields["traced"]), int(fields["samples"]) + 1))
        self.outcome = np.zeros(rods, OUTCOME)
        self.stopped = False
        self._loops = lanes.handles
        own = SharedArrays(
            p=p,
            y=y,
            state=self.state,
            values=self.values,
            crossed=self.crossed,
            traces=self.traces,
            outcome=self.outcome,
        )
        self._shared = (*shared, own)
        known = {"next": 0, "end": 0, "more": 1, **fields}
        known["p_stride"] = p.shape[1] if len(p) > 1 else 0
        known["y_stride"] = y.shape[1] if len(y) > 1 else 0
        for arrays in self._shared:
            known |= arrays.fields
        self._job = tuple(map(known.__getitem__, JOB.names or ()))

    def run(self, take: Callable[[], tuple[int, int] | None]) -> bool:
        """Run rods of the ranges that ``take`` gives, until there are none or the batch is stopped;
        False where they did not come to their end."""
        ffi, library, system = self._loops
        record = np.array([self._job], dtype=JOB)
        job = ffi.from_buffer("struct rodgen_many *", record, require_writable=True)
        size = library.rodgen_many_size(system, job)
        # On a cache line of its own, so that vectors do not lie across two.
        room = np.zeros(size + 64, dtype=np.uint8)
        memory = ffi.from_buffer(room)
        memory += -int(ffi.cast("uintptr_t", memory)) % 64
        on, status = library.rodgen_many_on, HUNGRY
        while status not in (REACHED, REFUSED) and not self.stopped:
            if status == HUNGRY:
                taken = take()
                job.more = taken is not None
                if taken:
                    job.next, job.end = taken
            status = on(system, job, memory, ROUNDS)
        return bool(status == REACHED)
