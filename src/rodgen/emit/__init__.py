"""Scenes to text: asks rodgen.derive, fills rodgen.templates. Nothing else imports derive."""

from rodgen.emit.module import module_files, module_text

__all__ = ["module_files", "module_text"]
