"""What an installation costs: seconds of its imports, and bytes of what it consists of."""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

import rodgen
from rodgen.judge.cases import Case
from rodgen.judge.costs.caches import scratch
from rodgen.judge.costs.rod import THRUST, why
from rodgen.judge.unit import Row, Unit
from rodgen.loading import sources

ROUNDS, QUICK_ROUNDS = 5, 1
LINKS = 10  # a module that the costs have made already
NAME = "rodgen"
BUILT = (
    "from rodgen import Structure, build, simulate; "
    f"build(Structure({LINKS}, terms={THRUST!r}), '{{}}')"
)
# Besides the interpreter's own start, which is taken off.
IMPORTS = {
    "import numpy": "import numpy",
    "import rodgen": "import rodgen",
    "from rodgen import Scene": "from rodgen import Scene",
    "plain install: a module in NumPy from the cache": BUILT.format("numpy"),
    "with [c]: a module in C from the cache": BUILT.format("c"),
    "with [c,cvode]: the same, and CVODE": BUILT.format("c") + "; import sksundae.cvode",
    "import sympy": "import sympy",
}
_REQUIREMENT = re.compile(r"([A-Za-z0-9][A-Za-z0-9._-]*)\s*(?:\[([^\]]*)\])?([^;]*)(?:;(.*))?$")
_EXTRA = re.compile(r"""extra\s*==\s*["']([^"']+)["']""")
Find = Callable[[str], Distribution]


def units(_: list[Case], quick: bool) -> list[Unit]:
    """The imports, and the sizes."""
    call = {"rounds": QUICK_ROUNDS if quick else ROUNDS}
    return [
        Unit("install", "install-imports", f"{__name__}:imports", call, limit=90.0),
        Unit("install", "install-sizes", f"{__name__}:sizes", {}, timed=False, limit=60.0),
    ]


def imports(rounds: int = ROUNDS) -> list[Row]:
    """Medians of fresh processes that take turns, without the start of the interpreter."""
    for target in ("c", "numpy"):  # so that the cache has it
        rodgen.build(rodgen.Structure(LINKS, terms=THRUST), target)
    with scratch() as folder:
        texts = sources(rodgen.Structure(LINKS, terms=THRUST))
        name, text = next(iter(texts.items()))
        Path(folder, name).write_text(text, encoding="utf-8")
        alone = f"a generated module alone, NumPy, n = {LINKS}"
        codes = {**IMPORTS, alone: f"import {Path(name).stem}"}
        return _timed(codes, folder, rounds)


def _timed(codes: dict[str, str], folder: str, rounds: int) -> list[Row]:
    start, failures = "", {}
    seconds: dict[str, list[float]] = {name: [] for name in ["", *codes]}
    reads = rounds > 1  # a first round, which is not kept, reads the files
    for _ in range(rounds + reads):
        for name, code in {start: "pass", **codes}.items():
            try:
                seconds[name].append(process(code, folder))
            except RuntimeError as error:
                failures[name] = why(error)
    plain = statistics.median(seconds[start][reads:])
    rows = [_row("the interpreter itself", seconds=plain)]
    for name in codes:
        failed = failures.get(name, "")
        # What costs less than the interpreter's start varies costs nothing that can be told.
        taken = None if failed else max(0.0, statistics.median(seconds[name][reads:]) - plain)
        rows.append(_row(name, seconds=taken, failed=failed))
    return rows


def process(code: str, folder: str) -> float:
    """Seconds of a Python process; RuntimeError with what it says last if it fails."""
    path = os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH", "")]))
    start = time.perf_counter()
    made = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path},
    )
    taken = time.perf_counter() - start
    if made.returncode:
        raise RuntimeError((made.stderr.splitlines() or [f"exit status {made.returncode}"])[-1])
    return taken


def _row(what: str, **more: str | float | None) -> Row:
    return {"what": what, "seconds": None, "bytes": None, "failed": "", **more}


# Sizes ------------------------------------------------------------------------------------------


def sizes(find: Find = distribution) -> list[Row]:
    """Bytes of rodgen, of it with what it needs, and with that of every extra."""
    own = find(NAME)
    extras = sorted(own.metadata.get_all("Provides-Extra") or [])
    rows = [_row("rodgen itself", bytes=own_bytes(own))]
    plain = needed(NAME, frozenset(), find)
    rows.append(_sum("rodgen with what it needs", plain, find))
    for extra in extras:
        whole = needed(NAME, frozenset({extra}), find)
        rows.append(_sum(f"rodgen[{extra}] with what it needs", whole, find))
        rows.append(_sum(f"what [{extra}] adds", whole - plain, find))
    rows += [_sum(name, {name}, find) for name in sorted(plain - {NAME})]
    return rows


def needed(name: str, extras: frozenset[str], find: Find = distribution) -> set[str]:
    """Names of a distribution and all that it requires, directly or not, extras followed."""
    found: set[str] = set()
    seen: set[tuple[str, frozenset[str]]] = set()
    open_ = [(normal(name), extras)]
    while open_:
        at = open_.pop()
        if at in seen:
            continue
        seen.add(at)
        found.add(at[0])
        try:
            own = find(at[0])
        except PackageNotFoundError:
            continue
        open_ += [(normal(other), more) for other, more in required(own, at[1])]
    return found


def required(own: Distribution, extras: frozenset[str]) -> Iterator[tuple[str, frozenset[str]]]:
    """What a distribution requires with some of its extras, by name and extras of theirs."""
    for text in own.requires or []:
        parts = _REQUIREMENT.match(text.strip())
        if parts is None:
            continue
        name, theirs, _, marker = parts.groups()
        if marker and not _holds(marker, extras):
            continue
        more = {extra.strip() for extra in (theirs or "").split(",")} - {""}
        yield name, frozenset(more)


def _holds(marker: str, extras: frozenset[str]) -> bool:
    """Whether a requirement is one here; other conditions than extras by `packaging`, if there."""
    try:
        from packaging.markers import Marker
    except ImportError:  # then what is installed decides
        asked = set(_EXTRA.findall(marker))
        return bool(asked & extras) if asked else True
    return any(Marker(marker).evaluate({"extra": extra}) for extra in (extras or {""}))


def normal(name: str) -> str:
    """A distribution's name as PEP 503 compares it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _sum(what: str, names: set[str], find: Find) -> Row:
    total, missing = 0, []
    for name in sorted(names):
        try:
            own = find(name)
        except PackageNotFoundError:
            missing.append(name)
            continue
        total += own_bytes(own)
    failed = f"not installed, so not counted: {', '.join(missing)}" if missing else ""
    return _row(what, bytes=total, failed=failed) | {"distributions": len(names) - len(missing)}


def own_bytes(own: Distribution) -> int:
    """Bytes of a distribution's files; of one that is edited in place, of its package's."""
    files = [Path(str(own.locate_file(file))) for file in own.files or []]
    total = sum(file.stat().st_size for file in files if file.is_file())
    if normal(own.metadata["Name"]) == NAME and not _holds_package(files):
        total += sum(_tree(folder) for folder in _package())
    return total


def _holds_package(files: list[Path]) -> bool:
    return any(file.parts[-2:] == (NAME, "__init__.py") for file in files)


def _package() -> list[Path]:
    """Folders of rodgen where it lies: its own, and derive and templates beside it."""
    from importlib.util import find_spec

    specs = [find_spec(name) for name in (NAME, f"{NAME}.derive", f"{NAME}.templates")]
    places = [Path(spec.origin).parent for spec in specs if spec and spec.origin]
    inside = places[0] if places else None
    return [p for p in places if p == inside or inside not in p.parents]


def _tree(folder: Path) -> int:
    """Bytes of all files but what Python compiled."""
    files = (file for file in folder.rglob("*") if "__pycache__" not in file.parts)
    return sum(file.stat().st_size for file in files if file.is_file())
