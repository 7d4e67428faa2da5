"""A scene to a live module: emitted if it is not in the cache yet, then loaded."""

from __future__ import annotations

import json
import os
from functools import lru_cache
from types import ModuleType

from rodgen.loading import cache
from rodgen.loading.module import BuildError, load_files
from rodgen.progress import COMPILING, DERIVING, tell, working
from rodgen.scene import Scene, SceneError, Structure
from rodgen.scene.errors import check_type
from rodgen.scene.structure import check_output

# The dense form holds a few matrices of this many links squared.
MOST_DENSE_LINKS = 5000
SURROUNDINGS = ("CC", "RODGEN_CFLAGS", "RODGEN_CACHE", "XDG_CACHE_HOME", "PATH")


def build(scene: Scene | Structure, target: str = "numpy", form: str = "chain") -> ModuleType:
    """The generated module of a scene (rhs, energy, ... as in its docstrings).

    target: "numpy" or "c"; form: "chain", O(n), or for NumPy "dense". Terminals and notebooks show
    a bar of what takes more than a second. Raises SceneError for what is not offered and for more
    links than the dense form can hold, BuildError where a C module cannot be compiled or loaded.
    """
    structure = _structure(scene)
    if form == "dense" and structure.links > MOST_DENSE_LINKS:
        allowed = f"at most {MOST_DENSE_LINKS} in the dense form: it holds links^2 numbers"
        raise SceneError("rod.links", structure.links, allowed)
    with working("generating"):
        texts = sources(structure, target, form)
        if target == "c":
            tell(COMPILING)
        # What a C module is compiled by belongs to it, and so does where it would be kept.
        return _load(tuple(texts.items()), *(os.environ.get(name) for name in SURROUNDINGS))


@lru_cache(maxsize=16)
def _load(texts: tuple[tuple[str, str], ...], *_: str | None) -> ModuleType:
    """A module that is loaded once in a process."""
    return load_files(dict(texts))


def build_fastest(scene: Scene | Structure) -> ModuleType:
    """The C module of a scene where it can be built, else its NumPy module."""
    return fastest(scene)[0]


def fastest(scene: Scene | Structure) -> tuple[ModuleType, str]:
    """The same, and why it is not the C module: in a line, empty where it is."""
    try:
        return build(scene, "c"), ""
    except BuildError as error:
        return build(scene, "numpy"), str(error).partition("\n")[0]


def sources(scene: Scene | Structure, target: str = "numpy", form: str = "chain") -> dict[str, str]:
    """Texts of the generated module of a scene by file name, the Python module first; from the
    cache where they are there."""
    structure = _structure(scene)
    check_output(target, form)
    stem = structure.module_stem(target, form)
    entry = ("modules", cache.key(target, form, structure.hash), f"{stem}.json")
    texts = _recall(cache.read_text(*entry))
    if texts is None:
        tell(DERIVING)
        from rodgen.emit import module_files  # SymPy is imported only where it is needed

        texts = module_files(structure, target, form)
        cache.store_text(json.dumps(texts), *entry)
    return texts


def _structure(scene: Scene | Structure) -> Structure:
    """What the module of a scene is specialised to. Raises TypeError for what has no structure."""
    check_type("scene", scene, Scene, Structure, see="Scene.from_toml")
    return scene.structure if isinstance(scene, Scene) else scene


def _recall(text: str | None) -> dict[str, str] | None:
    """Texts as they were stored, or None where there are none."""
    return {str(name): str(value) for name, value in json.loads(text).items()} if text else None
