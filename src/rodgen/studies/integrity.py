"""Integrity of stores: whatever is read is as it was written, or the damaged file is named.

Chunks end with a checksum (Zarr's crc32c). Checksums of the descriptions of the arrays are among
the attributes of the store, which have one of their own. A block that is marked has all its chunks:
Zarr would read missing ones as empty.
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
from rodgen.studies.sampling import CHUNKS, MARK

SUMS, OWN = "checksums", "sha256"  # attributes: checksums of descriptions, and of the others
DESCRIPTION = "zarr.json"
CODECS = [ZstdCodec(level=0), Crc32cCodec()]


class ChecksumStore(LocalStore):
    """A folder of Zarr whose files are checked as they are read. Raises InputError, which names the
    file, where one is not as it was written.

    blocked: names of the arrays that blocks are written to, once they are known; dims: number of
    dimensions along which blocks are told apart.
    """

    def __init__(self, root: Path | str, *, read_only: bool = False):
        super().__init__(root, read_only=read_only)
        self._sums = _read_sums(Path(root))
        self.blocked: set[str] = set()
        self.dims = 0

    def with_read_only(self, read_only: bool = False) -> ChecksumStore:
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
        if found is None and self._has_to_exist(key):  # else it was written meanwhile
            found = await super().get(key, prototype, byte_range)
        return found if byte_range else self._verify(key, found)

    def get_sync(self, key: str, **how: Any) -> Buffer | None:
        found = super().get_sync(key, **how)
        if found is None and self._has_to_exist(key):
            found = super().get_sync(key, **how)
        return found if how.get("byte_range") else self._verify(key, found)

    def _verify(self, key: str, found: Buffer | None) -> Buffer | None:
        """Return a file that was read. Raises InputError where it is not what was written."""
        if found is None:
            right = not self._has_to_exist(key)
        elif key in self._sums:
            right = _digest(found.to_bytes()) in self._sums[key]
        elif self._array_name(key):
            right = _has_checksum(found.to_bytes())
        else:
            right = True
        if not right:
            raise damage_error(Path(self.root), key)
        return found

    def _has_to_exist(self, key: str) -> bool:
        """Whether a file has to exist: a description, or a chunk, of a block that is marked."""
        name = self._array_name(key)
        if not (name and self.blocked):
            return key in self._sums
        place = key.split("/")[2 : 2 + self.dims]
        return name not in self.blocked or self.root.joinpath(MARK, CHUNKS, *place).exists()

    def _array_name(self, key: str) -> str:
        """Return the name of the array of a chunk, "" where it has no checksums."""
        name, folder, *_ = f"{key}/".split("/")
        return name if folder == CHUNKS and f"{name}/{DESCRIPTION}" in self._sums else ""


def damage_error(root: Path, key: str) -> InputError:
    """Return the error for a store in which a file is damaged or missing."""
    return InputError("store", str(root), f"as it was written ({key} is damaged or missing)")


def is_intact(chunk: Path) -> bool:
    """Whether the file of a chunk is as it was written."""
    return chunk.is_file() and _has_checksum(chunk.read_bytes())


def write_checksums(folder: Path, change: Callable[[Path], None] = lambda _: None) -> None:
    """Change the descriptions in a store, and write their checksums. Those from before count until
    the change is made, so that the store can be read at every moment."""
    keys = [f"{one.parent.name}/{DESCRIPTION}" for one in sorted(folder.glob(f"*/{DESCRIPTION}"))]
    before = {key: [_digest((folder / key).read_bytes())] for key in keys}
    with tempfile.TemporaryDirectory() as made:
        for key in (DESCRIPTION, *keys):
            (Path(made) / key).parent.mkdir(exist_ok=True)
            shutil.copyfile(folder / key, Path(made) / key)
        change(Path(made))
        after = {key: [_digest((Path(made) / key).read_bytes())] for key in keys}
    if after != before:
        _write_sums(folder, {key: before[key] + after[key] for key in keys})
        change(folder)
    _write_sums(folder, after)


def _write_sums(folder: Path, sums: dict[str, list[str]]) -> None:
    """Write checksums into the attributes of a store."""
    described = json.loads((folder / DESCRIPTION).read_bytes())
    others = {k: v for k, v in described["attributes"].items() if k != OWN} | {SUMS: sums}
    described["attributes"] = others | {OWN: _json_digest(others)}
    write_whole(folder / DESCRIPTION, json.dumps(described, indent=2))


def _read_sums(root: Path) -> dict[str, list[str]]:
    """Read the checksums of the descriptions in a store, by file; none where there are none yet, or
    the store is of the first format, which had none. Raises InputError where its attributes are not
    as they were written, or a description is missing."""
    try:
        found = json.loads((root / DESCRIPTION).read_bytes())
        attributes = dict(found["attributes"].items())
        if "digest" not in attributes or attributes.get("format") == "1":
            return {}
        own = attributes.pop(OWN)
        sums: dict[str, list[str]] = attributes[SUMS]
        whole = own == _json_digest(attributes)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        whole = False
    if not whole:
        raise damage_error(root, DESCRIPTION)
    for key in sums:
        if not (root / key).is_file():
            raise damage_error(root, key)
    return sums


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _json_digest(sums: Any) -> str:
    return _digest(json.dumps(sums, sort_keys=True).encode())


def _has_checksum(chunk: bytes) -> bool:
    """Whether a chunk ends with its crc32c, in Zarr's byte order."""
    return len(chunk) >= 4 and google_crc32c.value(chunk[:-4]) == int.from_bytes(
        chunk[-4:], "little"
    )
