"""Errors of an analysis that was asked for rightly."""


class AnalysisError(ArithmeticError):
    """An analysis has no result; the message says what was searched."""
