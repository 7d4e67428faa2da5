"""Scenes to text: asks rodgen.derive, fills rodgen.templates. Nothing else imports derive."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rodgen.derive import REMEMBERED  # noqa: F401  before SymPy is imported

if TYPE_CHECKING:
    from rodgen.emit.module import module_files, module_text

__all__ = ["module_files", "module_text"]


def __getattr__(name: str) -> object:
    """What needs SymPy is imported when it is asked for; names of parts need nothing."""
    if name in __all__:
        from rodgen.emit import module

        return getattr(module, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
