"""rodgen: equations of motion of planar flexible rods, derived, proven, generated, integrated.

    scene = rodgen.Scene.example("missile")
    model = rodgen.build(scene)
    sol = rodgen.simulate(scene, method="dop853", rtol=1e-8)

Everything is imported when it is first used: a plain ``import rodgen`` costs nothing. The names and
their modules are those of ``__init__.pyi``.
"""

from functools import cache
from importlib import import_module
from typing import Any


@cache
def _homes() -> dict[str, str]:
    """The module of every public name, as the imports of the stub have it."""
    import ast
    from pathlib import Path

    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    return {one.name: str(node.module) for node in imports for one in node.names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("rodgen")
    if name == "__all__":
        return list(_homes())
    if name.startswith("__") or name not in _homes():
        raise AttributeError(f"module 'rodgen' has no attribute {name!r}")
    return getattr(import_module(_homes()[name]), name)


def __dir__() -> list[str]:
    return [*_homes(), "__version__"]
