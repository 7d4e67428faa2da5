"""Classic NetCDF files (64-bit offset) that grow by records, and what their headers say.

Everything over the first dimension is a record variable. The bytes of a record lie together, one
variable after the other, behind all else in the file, and four bytes at NUMRECS say how many
records there are. They are written last: what they count is whole at every moment.
https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html
"""

from __future__ import annotations

import io
import math
import os
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodgen.integrate.files import Closing

NUMRECS = 4  # where the number of records lies in a file, in four bytes
DIMENSION, VARIABLE, ATTRIBUTE = 10, 11, 12
TYPES = {1: ">i1", 2: "S1", 3: ">i2", 4: ">i4", 5: ">f4", 6: ">f8"}
MOST = 2**31 - 4  # bytes of a variable or a record, and records: SciPy reads sizes as signed
PAGE = 4096  # what begins at a multiple of it and is no longer is written in one piece
Values = tuple[tuple[str, ...], NDArray[Any], Mapping[str, str]]  # dimensions, values, attributes


class NetcdfVariable(NamedTuple):
    """Entry of a variable in a header. size: bytes of it, in each record where it is over records;
    begin: where they start; place: where the header says so."""

    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    size: int
    begin: int
    place: int
    record: bool


@dataclass(frozen=True)
class Header:
    """Header of a file; attributes are those of text, others are left out."""

    records: int
    attributes: dict[str, str]
    variables: dict[str, NetcdfVariable]

    @cached_property
    def record(self) -> np.dtype[Any]:
        """Type of a record as a structure of NumPy's, by name of the variable."""
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
        """Position of the first record."""
        return min(v.begin for v in self.variables.values() if v.record)


def read_header(file: BinaryIO) -> Header:
    """Read the header of a CDF-2 file. Raises ValueError unless its parts lie in order, one after
    the other. (Whether the file has all its records is not looked at.)"""
    at = _HeaderReader(file)
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


class _HeaderReader:
    """Reader of a header from its start."""

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

    def take_padded(self, count: int) -> bytes:
        return self.take(count + -count % 4)[:count]

    def name(self) -> str:
        return self.take_padded(self.integer()).decode()

    def entries(self, tag: int) -> range:
        """Range of the entries of a list with this tag."""
        found, count = self.integer(), self.integer()
        if (found, count) != (0, 0) and (found != tag or count < 0):
            raise ValueError("its header is not one")
        return range(count)

    def attributes(self) -> dict[str, str]:
        found = {}
        for _ in self.entries(ATTRIBUTE):
            name, dtype, count = self.name(), np.dtype(TYPES[self.integer()]), self.integer()
            content = self.take_padded(count * dtype.itemsize)
            if dtype.kind == "S":
                found[name] = content.decode()
        return found

    def variable(self, lengths: list[tuple[str, int]]) -> tuple[str, NetcdfVariable]:
        name = self.name()
        over = [lengths[self.integer()] for _ in range(self.integer())]
        self.attributes()
        dtype, size = np.dtype(TYPES[self.integer()]), self.integer()
        record = bool(over) and over[0][1] == 0
        shape = tuple(length for _, length in over[record:])
        place, begin = self.file.tell(), self.integer(">q")
        return name, NetcdfVariable(
            tuple(d for d, _ in over), shape, dtype, size, begin, place, record
        )


def empty_file(
    dimensions: Mapping[str, int | None],
    variables: Mapping[str, Values],
    attributes: Mapping[str, str],
    aligned: str,
) -> bytes:
    """Bytes of a file without records.

    dimensions: the first is None, that of the records; variables: those of it have one record,
    which only tells their type; aligned: the variable that is to begin at a multiple of PAGE.
    """
    from scipy.io import netcdf_file

    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w", version=2)
    for name, length in dimensions.items():
        file.createDimension(name, length)
    for name, (over, values, notes) in variables.items():
        made = file.createVariable(name, values.dtype, over)
        made[:] = values
        for key, text in notes.items():
            setattr(made, key, text.encode())
    for key, text in attributes.items():
        setattr(file, key, text.encode())
    file.flush()
    header, image = read_header(buffer), bytearray(buffer.getvalue())
    # SciPy leaves no gaps: all from the aligned variable on moves up.
    first = header.variables[aligned].begin
    gap = -first % PAGE
    for variable in header.variables.values():
        if variable.begin >= first:
            struct.pack_into(">q", image, variable.place, variable.begin + gap)
    struct.pack_into(">i", image, NUMRECS, 0)
    return bytes(image[:first] + bytes(gap) + image[first : header.start])


class RecordFile(Closing):
    """A file that `empty_file` made, open to be read and, unless mode is "r", to grow; count: its
    records."""

    def __init__(self, path: Path, header: Header, mode: str = "r+"):
        self.path, self.header, self.count = path, header, header.records
        self._file = io.FileIO(path, mode)

    def append(self, records: NDArray[Any]) -> None:
        """Write records (K,) of type header.record behind those that count; `count_to` counts
        them."""
        self._write(self._end, records.tobytes())

    def count_to(self, count: int) -> None:
        """Write the number of records in the file."""
        self._write(NUMRECS, struct.pack(">i", count))
        self.count = count

    def read_count(self) -> int:
        """Read how many records the file says are there by now."""
        (count,) = struct.unpack(">i", self.read(NUMRECS, 4))
        return int(count)

    def truncate(self) -> None:
        """Cut off what is behind the last record."""
        self._file.truncate(self._end)

    def surplus(self) -> int:
        """Number of bytes behind the last record; of a file that is too short, negative."""
        return self._file.seek(0, os.SEEK_END) - self._end

    def records(self) -> NDArray[Any]:
        """Records, (K,), read from the disk as they are asked for."""
        if not self.count:
            return np.empty(0, self.header.record)
        start, shape = self.header.start, (self.count,)
        mapped: NDArray[Any] = np.memmap(self.path, self.header.record, "r", start, shape)
        return mapped

    def read_fixed(self, name: str) -> NDArray[Any]:
        """Values of a variable that is not over records."""
        v = self.header.variables[name]
        return np.ndarray(v.shape, v.dtype, self.read(v.begin, v.size))

    def put(self, name: str, at: int, value: ArrayLike) -> None:
        """Write one entry along the first dimension of a variable that is not over records."""
        v = self.header.variables[name]
        entry = np.empty(v.shape[1:], v.dtype)
        entry[...] = value
        self._write(v.begin + at * entry.nbytes, entry.tobytes())

    def put_text(self, name: str, text: bytes) -> None:
        """Write all letters of a variable that is not over records."""
        self._write(self.header.variables[name].begin, text)

    def sync(self) -> None:
        """Wait until all of it is on the disk."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @property
    def _end(self) -> int:
        return self.header.start + self.count * self.header.record.itemsize

    def read(self, at: int, size: int) -> bytes:
        """Read so many bytes from a place; raises ValueError where the file ends before."""
        self._file.seek(at)
        content = self._file.read(size)
        if len(content) < size:
            raise ValueError("it ends too early")
        return content

    def _write(self, at: int, content: bytes) -> None:
        self._file.seek(at)
        rest = memoryview(content)
        while rest:
            rest = rest[self._file.write(rest) :]
