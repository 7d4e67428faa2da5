"""The user's cache: generated modules and records of proofs, by content hash.

Everything in it can be made again; whatever cannot be read is a miss, and a cache that cannot be
written only costs time. Texts of it are run as Python: a file or folder that another user owns, or
that others can write, is no entry.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from rodgen.native.library import ROOT_OTHERS, cache_root, is_ours, read_own

# What a generated module follows from.
PACKAGES = (
    *("rodgen.model", "rodgen.scene", "rodgen.derive"),
    *("rodgen.templates", "rodgen.emit", "rodgen.native"),
)


@lru_cache
def source_hash(*packages: str) -> str:
    """Content hash of the sources of packages, and of the libraries that they derive with."""
    digest = hashlib.sha256()
    for package in ("rodgen", "sympy", "mpmath", "jinja2"):
        digest.update(f"{package} {version(package)}\n".encode())
    for package in packages:
        # Found, not imported: importing emit would import SymPy.
        spec = find_spec(package)
        folders = spec.submodule_search_locations if spec else None
        if not folders:
            raise ImportError(f"{package} is not installed")
        folder = Path(folders[0])
        for file in sorted(folder.rglob("*")):
            if file.suffix in (".py", ".jinja", ".c", ".h"):
                name = file.relative_to(folder).as_posix()
                digest.update(name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def key(*parts: object, packages: tuple[str, ...] = PACKAGES) -> str:
    """Name of an entry: it depends on the parts and on the sources of the packages."""
    content = "\0".join([source_hash(*packages), *map(str, parts)])
    return hashlib.sha256(content.encode()).hexdigest()[:32]


_noted: ContextVar[dict[tuple[str, ...], str] | None] = ContextVar("noted", default=None)


@contextmanager
def record_texts() -> Iterator[dict[tuple[str, ...], str]]:
    """Record the texts that are read or stored inside the context, by their entries."""
    entries: dict[tuple[str, ...], str] = {}
    token = _noted.set(entries)
    try:
        yield entries
    finally:
        _noted.reset(token)


def _record(text: str, *parts: str) -> None:
    entries = _noted.get()
    if entries is not None:
        entries[parts] = text


def read_text(*parts: str) -> str | None:
    """Text of an entry, or None where there is none, or it is not what was stored, or others may
    have written it."""
    try:
        root = cache_root()
        path = root.joinpath(*parts)
        if not all(is_ours(folder.stat()) for folder in _folders(root, path)):
            return None
        stored = read_own(path).decode("utf-8")
    except (OSError, RuntimeError, UnicodeDecodeError):  # RuntimeError: a user without a home
        return None
    digest, _, text = stored.partition("\n")
    if digest != _digest(text):
        return None
    _record(text, *parts)
    return text


def _folders(root: Path, path: Path) -> list[Path]:
    """Folders between the root of the cache and a file in it, the outer first. Raises OSError where
    others can write into the root."""
    if not is_ours(root.stat(), ROOT_OTHERS):
        raise PermissionError(root)
    return [one for one in reversed(path.parents) if one != root and one.is_relative_to(root)]


def store_text(text: str, *parts: str) -> bool:
    """Write an entry whole or not at all, for this user alone; False if that cannot be done."""
    _record(text, *parts)
    try:
        root = cache_root()
        path = root.joinpath(*parts)
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
        for folder in _folders(root, path):
            folder.mkdir(mode=0o700, exist_ok=True)
            if not is_ours(folder.stat()):
                folder.chmod(0o700)  # what others have put there stays theirs, and is no entry
        write_whole(path, f"{_digest(text)}\n{text}", 0o600)
    except (OSError, RuntimeError):
        return False
    return True


def _digest(text: str) -> str:
    return "# sha256 " + hashlib.sha256(text.encode()).hexdigest()


def write_whole(path: Path, text: str, mode: int = 0o666) -> None:
    """Write a file so that it is never seen half written; mode: less what the user's mask takes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        os.chmod(name, mode & ~_umask())
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
