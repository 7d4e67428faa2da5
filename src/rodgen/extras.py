"""How what is not installed is had."""


def how_to_have(extra: str) -> str:
    """The command that installs an extra, such as "view", as messages name it."""
    return f'pip install ".[{extra}]" in a clone of rodgen'
