"""What ends a study before it is done."""

from rodgen.extras import how_to_have


class StudyError(RuntimeError):
    """A study that could not be finished; what is marked in its store is kept."""


MISSING = f"studies need more: {how_to_have('study')}"
