"""Header of a NetCDF classic file in 64-bit offset format: where the bytes of each variable lie.

https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html
"""

from __future__ import annotations

import io
import math
import struct
from dataclasses import dataclass
from functools import cached_property
from typing import Any, BinaryIO, NamedTuple

import numpy as np

DIMENSION, VARIABLE, ATTRIBUTE = 10, 11, 12
TYPES = {1: ">i1", 2: "S1", 3: ">i2", 4: ">i4", 5: ">f4", 6: ">f8"}


class Variable(NamedTuple):
    """dimensions and type; size: its bytes, in each record where it is one of a record; begin:
    where they start; place: where the header says so."""

    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    size: int
    begin: int
    place: int
    record: bool


@dataclass(frozen=True)
class Header:
    """What a file says about itself; attributes are text alone, others are left out."""

    records: int
    attributes: dict[str, str]
    variables: dict[str, Variable]

    @cached_property
    def record(self) -> np.dtype[Any]:
        """A record as a structure of NumPy's, by name of the variable."""
        inside = {name: v for name, v in self.variables.items() if v.record}
        return np.dtype(
            {
                "names": list(inside),
                "formats": [(v.dtype, v.shape) for v in inside.values()],
                "offsets": [v.begin - self.start for v in inside.values()],
                "itemsize": sum(v.size for v in inside.values()),
            }
        )

    @cached_property
    def start(self) -> int:
        """Where the first record begins."""
        return min(v.begin for v in self.variables.values() if v.record)


def read_header(file: BinaryIO) -> Header:
    """Header of a CDF-2 file; raises ValueError unless it is one whose parts lie in order, one
    after the other. (Whether it has all its records is not looked at.)"""
    at = _Cursor(file)
    if at.take(4) != b"CDF\x02":
        raise ValueError("not in NetCDF's 64-bit offset format")
    try:
        records = at.integer()
        lengths = [(at.name(), at.integer()) for _ in at.entries(DIMENSION)]
        attributes = at.attributes()
        variables = dict(at.variable(lengths) for _ in at.entries(VARIABLE))
    except (KeyError, IndexError):
        raise ValueError("a type or a dimension that is not there") from None
    header = Header(records, attributes, variables)
    _check(header, file.tell())
    return header


def _check(header: Header, position: int) -> None:
    inside = [v for v in header.variables.values() if v.record]
    for v in header.variables.values():
        least = v.dtype.itemsize * math.prod(v.shape)
        if v.size != least + -least % 4:
            raise ValueError("a variable of another size than its dimensions say")
    if not inside:
        raise ValueError("nothing in it changes with time")
    for v in (*(v for v in header.variables.values() if not v.record), *inside):
        if v.begin < position or (v.record and v is not inside[0] and v.begin != position):
            raise ValueError("variables that do not lie one after the other")
        position = v.begin + v.size
    if header.records < 0 or not header.record.itemsize:
        raise ValueError("records without a number or a size")


class _Cursor:
    """Reads a header from its start."""

    def __init__(self, file: BinaryIO):
        self.file, self.end = file, file.seek(0, io.SEEK_END)
        file.seek(0)

    def take(self, count: int) -> bytes:
        if not 0 <= count <= self.end - self.file.tell():
            raise ValueError("its header is cut short")
        return self.file.read(count)

    def integer(self, code: str = ">i") -> int:
        (number,) = struct.unpack(code, self.take(struct.calcsize(code)))
        return int(number)

    def padded(self, count: int) -> bytes:
        return self.take(count + -count % 4)[:count]

    def name(self) -> str:
        return self.padded(self.integer()).decode()

    def entries(self, tag: int) -> range:
        """As many as a list with this tag has."""
        found, count = self.integer(), self.integer()
        if (found, count) != (0, 0) and (found != tag or count < 0):
            raise ValueError("its header is not one")
        return range(count)

    def attributes(self) -> dict[str, str]:
        found = {}
        for _ in self.entries(ATTRIBUTE):
            name, dtype, count = self.name(), np.dtype(TYPES[self.integer()]), self.integer()
            content = self.padded(count * dtype.itemsize)
            if dtype.kind == "S":
                found[name] = content.decode()
        return found

    def variable(self, lengths: list[tuple[str, int]]) -> tuple[str, Variable]:
        name = self.name()
        over = [lengths[self.integer()] for _ in range(self.integer())]
        self.attributes()
        dtype, size = np.dtype(TYPES[self.integer()]), self.integer()
        record = bool(over) and over[0][1] == 0
        shape = tuple(length for _, length in over[record:])
        place, begin = self.file.tell(), self.integer(">q")
        return name, Variable(tuple(d for d, _ in over), shape, dtype, size, begin, place, record)
