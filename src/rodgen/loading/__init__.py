"""Text of generated modules to callables, through a cache."""

from rodgen.loading.build import build, build_fastest, companions, fastest, sources
from rodgen.loading.module import load_files, load_module, load_text
from rodgen.native.library import BuildError

__all__ = [
    "BuildError",
    "build",
    "build_fastest",
    "companions",
    "fastest",
    "load_files",
    "load_module",
    "load_text",
    "sources",
]
