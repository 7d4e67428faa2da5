"""Scenes as text: TOML to save, and an address that reproduces one."""

from __future__ import annotations

import base64
import binascii
import zlib
from pathlib import Path

import tomli_w

from rodgen.scene import Scene, SceneError
from rodgen.scene.toml import read_text

LARGEST = 2**20  # bytes of a scene, unpacked
MOST_SCENES = 500  # of a folder


def to_toml(scene: Scene) -> str:
    """The text of a file from which `Scene.from_toml` makes the same scene."""
    return tomli_w.dumps(scene.model_dump(exclude_none=True))


def from_toml_text(text: bytes) -> Scene:
    """A scene from the bytes of a file, checked as files are. Raises SceneError."""
    if len(text) > LARGEST:
        raise SceneError("scene", f"{len(text)} bytes", f"at most {LARGEST} bytes")
    return Scene.from_dict(read_text(text, "this file"))


def packed(scene: Scene) -> str:
    """A scene in letters, digits, - and _, for an address."""
    return base64.urlsafe_b64encode(zlib.compress(to_toml(scene).encode(), 9)).decode().rstrip("=")


def unpacked(text: str) -> Scene:
    """A scene from `packed`. Raises SceneError for anything else."""
    try:
        data = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
        inflate = zlib.decompressobj()
        content = inflate.decompress(data, LARGEST + 1)
    except (binascii.Error, zlib.error, ValueError):
        raise SceneError("scene", text[:40], "a scene as the link button gives it") from None
    return from_toml_text(content)


class Folder:
    """The scenes of a folder: nothing outside of it, and nothing but its own files, is opened."""

    def __init__(self, path: Path):
        self._path = path.resolve()

    def names(self) -> list[str]:
        """File names of its scenes, without the ending."""
        try:
            found = sorted(p.stem for p in self._path.glob("*.toml") if self._inside(p))
        except OSError:
            return []
        return found[:MOST_SCENES]

    def scene(self, name: str) -> Scene:
        """One of them. Raises SceneError."""
        if name not in self.names():
            raise SceneError("scene", name, f"one of the folder: {', '.join(self.names())}")
        return Scene.from_toml(self._path / f"{name}.toml")

    def _inside(self, path: Path) -> bool:
        """Whether a file is in the folder itself, not a link that leads out of it."""
        return path.is_file() and path.resolve().parent == self._path
