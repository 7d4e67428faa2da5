"""Text of generated modules to callables, through a cache."""

from rodgen.loading.build import build, source
from rodgen.loading.module import load_module, load_text

__all__ = ["build", "load_module", "load_text", "source"]
