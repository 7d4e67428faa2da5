"""Results that a folder holds already: to go on with, or to be replaced."""

from __future__ import annotations

from pathlib import Path

from rodgen.cli.console import err
from rodgen.cli.generated import is_generated
from rodgen.integrate.files.checkpoint import beside
from rodgen.integrate.files.status import RUNNING
from rodgen.integrate.files.stored import INTERRUPTED, Stored, open_header
from rodgen.scene import Scene, SceneError
from rodgen.scene.tables import AUTO


def check_same(scene: Scene, file: Path) -> None:
    """Refuse to go on with the run of another scene, or with other options."""
    if not file.exists():
        raise SceneError("--resume", str(file), "a run that was begun; there is none")
    with Stored(file) as begun:
        status = begun.run.status
    method = scene.integrate.method
    if method == AUTO:
        method = begun.scene.integrate.method
    if other := _differing(scene.with_integrate(method=method), begun.scene):
        allowed = f"the run of this scene with the same options (changed: {', '.join(other)})"
        raise SceneError("--resume", str(file), allowed)
    # One that has ended is refused where it is taken up.
    if status in (RUNNING, INTERRUPTED) and not beside(file).exists():
        err.print("rodgen: there is no state to go on from; the run starts again")


def to_replace(scene: Scene, file: Path) -> list[Path]:
    """The module's files of the run in a result file that the run of a scene will replace.

    Says so where that was the run of another scene: both have the name of the folder.
    """
    if not file.exists():
        return []
    try:
        header, before = open_header(file)
        how = (header.attributes[key] for key in ("target", "form"))
        stem = before.structure.module_stem(*how)
    except (KeyError, SceneError):
        err.print(f"rodgen: warning: {file} is no result of this version; it is replaced")
        return []
    other = [field for field in _differing(scene, before) if not field.startswith("integrate.")]
    if other:
        what = f"a run of another scene of this name (changed: {', '.join(other)})"
        err.print(f"rodgen: warning: {file} held {what}; it is replaced")
    files = (file.with_name(f"{stem}.{ending}") for ending in ("py", "c", "h"))
    return [path for path in files if is_generated(path)]


def _differing(scene: Scene, other: Scene) -> list[str]:
    """Keys and tables in which two scenes differ."""
    now, then = (s.model_dump() for s in (scene, other))
    return [
        f"{table}.{key}" if key else table
        for table in now
        for key in (now[table] if isinstance(now[table], dict) else [""])
        if (now[table][key] != then[table][key] if key else now[table] != then[table])
    ]
