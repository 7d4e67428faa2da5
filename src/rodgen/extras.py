"""Installation of optional dependencies."""


def install_command(extra: str) -> str:
    """The command that installs an extra, such as "view", as messages name it."""
    return f'pip install ".[{extra}]" in a clone of rodgen'
