"""What ends a study before it is done."""


class StudyError(RuntimeError):
    """A study that could not be finished; what is marked in its store is kept."""


MISSING = 'studies need more: pip install "rodgen[study]"'
