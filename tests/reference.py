"""What is written from the sources and kept beside them: the reference modules in generated/, the
headers of the step loops, and the tables of the docs.

    python -m tests.reference            writes all of it anew
    python -m tests.reference --check    writes nothing; prints which files differ, with status 1

Texts of modules depend on the version of SymPy: they are left out if it is not that of
requirements.lock.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import sympy

from rodgen.emit import module_files
from rodgen.scene.structure import Structure
from tests.tableaux import headers
from tests.tables import pages

ROOT = Path(__file__).parents[1]
GENERATED = ROOT / "generated"
NATIVE = ROOT / "src" / "rodgen" / "native"
# Structure, target and form of every reference module, by the stem of its files.
MODULES = {
    "rod_free_n5": (Structure(5), "numpy", "chain"),
    "rod_free_n5_conservative": (Structure(5, terms=()), "numpy", "chain"),
    "rod_free_n5_dense": (Structure(5), "numpy", "dense"),
    "rod_free_n5_c": (Structure(5), "c", "chain"),
    "rod_cantilever_n5": (Structure(5, "cantilever"), "numpy", "chain"),
    "rod_clamped_n5_tip_load_lumped": (
        Structure(5, "clamped", "lumped", ("tip_load",)),
        "numpy",
        "chain",
    ),
}


def texts() -> Iterator[tuple[Path, str]]:
    """Yield files and what each is to hold; headers first, of which modules hold a hash."""
    yield from ((NATIVE / name, text) for name, text in headers().items())
    yield from pages().items()
    locked = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    if f"sympy=={sympy.__version__}" not in locked:
        print(f"without modules: SymPy {sympy.__version__} is not that of requirements.lock")
        return
    for structure, target, form in MODULES.values():
        files = module_files(structure, target, form)
        yield from ((GENERATED / name, text) for name, text in files.items())


def main(*arguments: str) -> None:
    """Write, or compare."""
    parser = argparse.ArgumentParser(prog="python -m tests.reference", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing, name what differs")
    given = parser.parse_args(arguments)
    differing = []
    for path, text in texts():
        wanted = text.encode()
        if path.is_file() and path.read_bytes() == wanted:
            continue
        differing.append(path)
        if not given.check:
            path.write_bytes(wanted)
    for path in differing:
        print(path.relative_to(ROOT) if path.is_relative_to(ROOT) else path)
    if differing and given.check:
        sys.exit(1)


if __name__ == "__main__":
    main(*sys.argv[1:])
