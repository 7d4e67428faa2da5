"""Times of runs under a measured thrust, of many rows beside few that tell of the same curve.

python -m rodgen_evidence.benchmarks.thrust_tables
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import tomli_w

import rodgen
from rodgen.scene import Scene
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.report.cases import ROD
from rodgen_evidence.report.interleaved_timing import calls, time_in_turns

KNOTS = np.linspace(0.0, 20.0, 10)
SCENE = {"name": "rod", "rod": ROD | {"links": 1, "boundary": "pinned"}, "initial": {"phi": 0.1}}


def written(folder: Path, rows: int, kind: str) -> Path:
    """A scene with a thrust of so many rows in a file beside it."""
    t = np.linspace(KNOTS[0], KNOTS[-1], rows)
    values = np.interp(t, KNOTS, 20 + 5 * np.sin(KNOTS))
    np.savetxt(folder / f"{rows}.csv", np.column_stack((t, values)), delimiter=",")
    loads = {"follower": {"force": f"interp(t, '{rows}.csv', '{kind}')"}}
    settings = {"span": [0.0, 20.0], "output_every": 0.1}
    path = folder / f"{rows}_{kind}.toml"
    table = SCENE | {"loads": loads, "integrate": settings}
    path.write_text(tomli_w.dumps(table), encoding="utf-8")
    return path


def tables(rows: int = 100_000, rounds: int = 9, target: str = "c") -> Times:
    """Scenes read and run with so many rows, beside ten."""
    table = Times("a thrust from a file, one link")
    with TemporaryDirectory() as folder:
        for kind in ("linear", "cubic"):
            paths = {count: written(Path(folder), count, kind) for count in (rows, 10)}
            scenes = {count: Scene.from_toml(path) for count, path in paths.items()}
            runs = {
                count: partial(rodgen.simulate, one, target=target) for count, one in scenes.items()
            }
            reads = {count: partial(Scene.from_toml, path) for count, path in paths.items()}
            for what, of in (("read", reads), ("run", runs)):
                each = {str(count): calls(function) for count, function in of.items()}
                times = time_in_turns(each, rounds=rounds, seconds=0.2)
                table.add(f"{what}, {kind}, {rows} rows", times[str(rows)], "10", times["10"])
    return table


if __name__ == "__main__":
    tables().show()
