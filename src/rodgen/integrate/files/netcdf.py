"""NetCDF classic files (64-bit offset) that grow by records.

Everything over the first dimension is a record variable. The bytes of a record lie together, one
variable after the other, behind all else in the file, and four bytes at NUMRECS say how many
records there are. They are written last: what they count is whole at every moment.
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rodgen.integrate.files.checks import NUMRECS
from rodgen.integrate.files.header import Header, read_header

MOST = 2**31 - 4  # bytes of a variable or a record, and records: SciPy reads sizes as signed
PAGE = 4096  # what begins at a multiple of it and is no longer is written in one piece

Values = tuple[tuple[str, ...], NDArray[Any], Mapping[str, str]]  # dimensions, values, attributes


def empty_file(
    dimensions: Mapping[str, int | None],
    variables: Mapping[str, Values],
    attributes: Mapping[str, str],
    aligned: str,
) -> bytes:
    """A file without records.

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


class RecordFile:
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
        """Say that so many records are there."""
        self._write(NUMRECS, struct.pack(">i", count))
        self.count = count

    def counted(self) -> int:
        """How many records the file says are there by now."""
        (count,) = struct.unpack(">i", self.read(NUMRECS, 4))
        return int(count)

    def cut(self) -> None:
        """Leave nothing behind the last record."""
        self._file.truncate(self._end)

    def surplus(self) -> int:
        """Bytes behind the last record; of a file that is too short, negative."""
        return self._file.seek(0, os.SEEK_END) - self._end

    def records(self) -> NDArray[Any]:
        """Its records, (K,), from the disk as they are asked for."""
        if not self.count:
            return np.empty(0, self.header.record)
        start, shape = self.header.start, (self.count,)
        mapped: NDArray[Any] = np.memmap(self.path, self.header.record, "r", start, shape)
        return mapped

    def fixed(self, name: str) -> NDArray[Any]:
        """Values of a variable that is not of the records."""
        v = self.header.variables[name]
        return np.ndarray(v.shape, v.dtype, self.read(v.begin, v.size))

    def put(self, name: str, at: int, value: ArrayLike) -> None:
        """Write one entry along the first dimension of such a variable."""
        v = self.header.variables[name]
        entry = np.empty(v.shape[1:], v.dtype)
        entry[...] = value
        self._write(v.begin + at * entry.nbytes, entry.tobytes())

    def put_text(self, name: str, text: bytes) -> None:
        """Write all of such a variable of letters."""
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
        """So many bytes from there; raises ValueError where the file ends before."""
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

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
