"""Text of generated modules: equations of rodgen.derive, put into rodgen.templates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rodgen.derive import REMEMBERED  # noqa: F401  before SymPy is imported

if TYPE_CHECKING:
    from rodgen.emit.module_writer import module_files, module_text

__all__ = ["module_files", "module_text"]


def __getattr__(name: str) -> object:
    """Import what needs SymPy on access, so that names of parts can be had without it."""
    if name in __all__:
        from rodgen.emit import module_writer

        return getattr(module_writer, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
