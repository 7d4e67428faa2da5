"""Text of generated modules to callables, through a cache."""

from rodgen.loading.build import build, build_fastest, fastest, sources
from rodgen.loading.module import BuildError, load_files, load_module, load_text

__all__ = [
    "BuildError",
    "build",
    "build_fastest",
    "fastest",
    "load_files",
    "load_module",
    "load_text",
    "sources",
]
