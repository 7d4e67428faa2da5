"""A scene to a live module: emitted if it is not in the cache yet, then loaded."""

from __future__ import annotations

from types import ModuleType

from rodgen.loading import cache
from rodgen.loading.module import load_text
from rodgen.scene import Scene, SceneError, Structure
from rodgen.scene.structure import TARGETS, choose

# The dense form holds a few matrices of this many links squared.
MOST_DENSE_LINKS = 5000


def build(scene: Scene | Structure, target: str = "numpy") -> ModuleType:
    """The generated module of a scene (rhs, energy, ... as in its docstrings).

    Raises SceneError for a target that is not offered and for more links than the dense form
    can hold.
    """
    structure = scene.structure if isinstance(scene, Scene) else scene
    if structure.links > MOST_DENSE_LINKS:
        allowed = (
            f"at most {MOST_DENSE_LINKS} to compute with: the dense form holds links^2 numbers"
        )
        raise SceneError("rod.links", structure.links, allowed)
    return load_text(source(structure, target), structure.stem)


def source(scene: Scene | Structure, target: str = "numpy") -> str:
    """Text of the generated module of a scene; from the cache where it is there."""
    structure = scene.structure if isinstance(scene, Scene) else scene
    choose("target", target, TARGETS)
    entry = ("modules", cache.key(target, structure.hash), f"{structure.stem}.py")
    text = cache.read_text(*entry)
    if text is None:
        from rodgen.emit import module_text  # SymPy is imported only where it is needed

        text = module_text(structure, target)
        cache.store_text(text, *entry)
    return text
