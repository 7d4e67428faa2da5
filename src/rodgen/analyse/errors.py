"""Errors of an analysis that was asked for rightly, and what it warns of."""


class AnalysisError(ArithmeticError):
    """An analysis has no result; the message says what was searched."""


class MeshWarning(UserWarning):
    """Results of several numbers of links are not those of one and the same rod."""
