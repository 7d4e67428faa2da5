"""The commands report, thesis and audit."""
