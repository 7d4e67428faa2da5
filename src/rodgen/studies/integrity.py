"""Stores of studies that are as they were written, or name the file that is not.

Chunks end with a checksum (Zarr's crc32c). The descriptions of the arrays have theirs among the
attributes of the store, which have one of their own. A block that is marked has all its chunks:
Zarr would read others as empty.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import google_crc32c
from zarr.abc.store import ByteRequest
from zarr.codecs import Crc32cCodec, ZstdCodec
from zarr.core.buffer import Buffer, BufferPrototype
from zarr.storage import LocalStore

from rodgen.errors import InputError
from rodgen.loading.cache import write_whole
from rodgen.studies.layout import CHUNKS, MARK

SUMS, OWN = "checksums", "sha256"  # attributes: of the descriptions of arrays, and of the others
DESCRIPTION = "zarr.json"
CODECS = [ZstdCodec(level=0), Crc32cCodec()]


class WholeStore(LocalStore):
    """A folder of Zarr, of which whatever is read is what was written. Raises InputError, which
    names the file, where it is not.

    blocked: names of the arrays that blocks are written to, once they are known; dims: along how
    many dimensions blocks are told apart.
    """

    def __init__(self, root: Path | str, *, read_only: bool = False):
        super().__init__(root, read_only=read_only)
        self._sums = _sums(Path(root))
        self.blocked: set[str] = set()
        self.dims = 0

    def with_read_only(self, read_only: bool = False) -> WholeStore:
        found = type(self)(self.root, read_only=read_only)
        found.blocked, found.dims = self.blocked, self.dims
        return found

    async def get(
        self,
        key: str,
        prototype: BufferPrototype | None = None,
        byte_range: ByteRequest | None = None,
    ) -> Buffer | None:
        found = await super().get(key, prototype, byte_range)
        if found is None and self._is_due(key):  # else it was written meanwhile
            found = await super().get(key, prototype, byte_range)
        return found if byte_range else self._checked(key, found)

    def get_sync(self, key: str, **how: Any) -> Buffer | None:
        found = super().get_sync(key, **how)
        if found is None and self._is_due(key):
            found = super().get_sync(key, **how)
        return found if how.get("byte_range") else self._checked(key, found)

    def _checked(self, key: str, found: Buffer | None) -> Buffer | None:
        """A file that was read. Raises InputError where it is not what was written."""
        if found is None:
            right = not self._is_due(key)
        elif key in self._sums:
            right = _digest(found.to_bytes()) in self._sums[key]
        elif self._array(key):
            right = _has_its_sum(found.to_bytes())
        else:
            right = True
        if not right:
            raise damaged(Path(self.root), key)
        return found

    def _is_due(self, key: str) -> bool:
        """Whether there has to be a file: a description, or a chunk, of blocks that are marked."""
        name = self._array(key)
        if not (name and self.blocked):
            return key in self._sums
        place = key.split("/")[2 : 2 + self.dims]
        return name not in self.blocked or self.root.joinpath(MARK, CHUNKS, *place).exists()

    def _array(self, key: str) -> str:
        """The array of a chunk, where it has checksums."""
        name, folder, *_ = f"{key}/".split("/")
        return name if folder == CHUNKS and f"{name}/{DESCRIPTION}" in self._sums else ""


def damaged(root: Path, key: str) -> InputError:
    """The error of a store of which a file is not as it was written, or not there."""
    return InputError("store", str(root), f"as it was written ({key} is damaged or missing)")


def is_intact(chunk: Path) -> bool:
    """Whether the file of a chunk is as it was written."""
    return chunk.is_file() and _has_its_sum(chunk.read_bytes())


def sealed(folder: Path, change: Callable[[Path], None] = lambda _: None) -> None:
    """Write the checksums of the descriptions in a store, which a change of them keeps up with: at
    every moment, those that are there are among them."""
    keys = [f"{one.parent.name}/{DESCRIPTION}" for one in sorted(folder.glob(f"*/{DESCRIPTION}"))]
    before = {key: [_digest((folder / key).read_bytes())] for key in keys}
    with tempfile.TemporaryDirectory() as made:
        for key in (DESCRIPTION, *keys):
            (Path(made) / key).parent.mkdir(exist_ok=True)
            shutil.copyfile(folder / key, Path(made) / key)
        change(Path(made))
        after = {key: [_digest((Path(made) / key).read_bytes())] for key in keys}
    if after != before:
        _keep(folder, {key: before[key] + after[key] for key in keys})
        change(folder)
    _keep(folder, after)


def _keep(folder: Path, sums: dict[str, list[str]]) -> None:
    """Put checksums into the attributes of a store."""
    described = json.loads((folder / DESCRIPTION).read_bytes())
    others = {k: v for k, v in described["attributes"].items() if k != OWN} | {SUMS: sums}
    described["attributes"] = others | {OWN: _digest_of(others)}
    write_whole(folder / DESCRIPTION, json.dumps(described, indent=2))


def _sums(root: Path) -> dict[str, list[str]]:
    """The checksums of the descriptions in a store, by file; none where there are none yet, or it
    is of the first format, which had none. Raises InputError where its attributes are not as they
    were written, or a description is missing."""
    try:
        found = json.loads((root / DESCRIPTION).read_bytes())
        attributes = dict(found["attributes"].items())
        if "digest" not in attributes or attributes.get("format") == "1":
            return {}
        own = attributes.pop(OWN)
        sums: dict[str, list[str]] = attributes[SUMS]
        whole = own == _digest_of(attributes)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        whole = False
    if not whole:
        raise damaged(root, DESCRIPTION)
    for key in sums:
        if not (root / key).is_file():
            raise damaged(root, key)
    return sums


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _digest_of(sums: Any) -> str:
    return _digest(json.dumps(sums, sort_keys=True).encode())


def _has_its_sum(chunk: bytes) -> bool:
    """Whether a chunk ends with its crc32c, in the order of bytes that Zarr has."""
    return len(chunk) >= 4 and google_crc32c.value(chunk[:-4]) == int.from_bytes(
        chunk[-4:], "little"
    )
