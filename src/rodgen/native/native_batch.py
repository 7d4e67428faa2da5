"""Many runs of a C module side by side, each in a lane of its own until it ends."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .native_run import (
    HEADERS,
    STATUSES,
    NativeFunctions,
    aligned_bytes,
    header_numbers,
    header_text,
    loop_library,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NUMBERS = header_numbers("lanes.h")
LANES, HUNGRY = NUMBERS["LANES"], NUMBERS["HUNGRY"]
REACHED, REFUSED = STATUSES["REACHED"], STATUSES["REFUSED"]
STOPPED = NUMBERS["STOPPED"]
# What is made of the samples of a number, by name.
KEEPS = {name[5:].lower(): at for name, at in NUMBERS.items() if name.startswith("KEEP_")}
FILES = (
    *("lanes.c", "lane_steps.c", "lane_dense.c", "crossings.c", "reductions.c"),
    *("lanes.h", "lane_moves.h", "many.h", *HEADERS),
)
ROUNDS = 64  # steps of all lanes between two looks at whether to stop


def _structures(header: str) -> dict[str, np.dtype[Any]]:
    """Types of the structures of a header, by name: their numbers, and addresses of arrays."""
    kinds = {"long long": "i8", "size_t": "u8", "double": "f8"}
    text = re.sub(r"/\*.*?\*/", "", header_text(header), flags=re.S)
    found = {}
    for structure, body in re.findall(r"struct rodgen_(\w+) \{(.*?)\};", text, flags=re.S):
        fields = re.findall(r"(long long|size_t|double|struct \w+) ([^;()]+);", body)
        found[structure] = np.dtype(
            [
                (name.strip(" *"), "u8" if "*" in name else kinds[kind])
                for kind, names in fields
                for name in names.split(",")
            ]
        )
    return found


_TYPES = _structures("lanes.h")
KEPT, STRETCH, COURSE = _TYPES["kept"], _TYPES["stretch"], _TYPES["course"]
OUTCOME, NUMBER, WATCHED, JOB = (_TYPES[name] for name in ("outcome", "number", "watched", "many"))


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
        ffi, library = loop_library("lanes", FILES, "methods.h", "steps.h", "lanes.h")
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
        names = ("state", "values", "crossed", "traces", "outcome")
        own = SharedArrays(p=p, y=y, **{name: getattr(self, name) for name in names})
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
        memory = ffi.from_buffer(aligned_bytes(library.rodgen_many_size(system, job)))
        on, status = library.rodgen_many_on, HUNGRY
        while status not in (REACHED, REFUSED) and not self.stopped:
            if status == HUNGRY:
                taken = take()
                job.more = taken is not None
                if taken:
                    job.next, job.end = taken
            status = on(system, job, memory, ROUNDS)
        return bool(status == REACHED)
