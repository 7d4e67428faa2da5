"""Costs of an installation: seconds of its imports, and bytes of what it consists of."""

from __future__ import annotations

import os
import statistics
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import rodgen
from rodgen.analyse.precision.contestant import Measurement, describe_error
from rodgen.loading import sources
from rodgen_evidence.report.costs.cold import scratch
from rodgen_evidence.report.costs.cost_rows import THRUST
from rodgen_evidence.report.interleaved_timing import process
from rodgen_evidence.report.unit import Unit

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
Find = Callable[[str], Distribution]


def units(_: object, quick: bool, *__: object) -> list[Unit]:
    """The imports, and the sizes."""
    call = {"rounds": QUICK_ROUNDS if quick else ROUNDS}
    return [
        Unit("install", "install-imports", f"{__name__}:imports", call, limit=90.0),
        Unit("install", "install-sizes", f"{__name__}:sizes", {}, timed=False, limit=60.0),
    ]


def imports(rounds: int = ROUNDS) -> list[Measurement]:
    """Medians of fresh processes that take turns, without the start of the interpreter."""
    for target in ("c", "numpy"):  # so that the cache has it
        rodgen.build(rodgen.Structure(LINKS, terms=THRUST), target)
    with scratch() as folder:
        texts = sources(rodgen.Structure(LINKS, terms=THRUST))
        name, text = next(iter(texts.items()))
        Path(folder, name).write_text(text, encoding="utf-8")
        alone = f"a generated module alone, NumPy, n = {LINKS}"
        codes = {**IMPORTS, alone: f"import {Path(name).stem}"}
        return _time_imports(codes, folder, rounds)


def _time_imports(codes: dict[str, str], folder: str, rounds: int) -> list[Measurement]:
    start, failures = "", dict[str, str]()
    path = os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH", "")]))
    seconds: dict[str, list[float]] = {name: [] for name in ["", *codes]}
    reads = rounds > 1  # a first round, which is not kept, reads the files
    for _ in range(rounds + reads):
        for name, code in {start: "pass", **codes}.items():
            try:
                seconds[name].append(process([sys.executable, "-c", code], PYTHONPATH=path))
            except RuntimeError as error:
                failures[name] = describe_error(error)
    plain = statistics.median(seconds[start][reads:])
    rows = [_row("the interpreter itself", seconds=plain)]
    for name in codes:
        failed = failures.get(name, "")
        # What costs less than the interpreter's start varies costs nothing that can be told.
        taken = None if failed else max(0.0, statistics.median(seconds[name][reads:]) - plain)
        rows.append(_row(name, seconds=taken, failed=failed))
    return rows


def _row(what: str, **more: str | float | None) -> Measurement:
    return {"what": what, "seconds": None, "bytes": None, "failed": "", **more}


# Sizes ------------------------------------------------------------------------------------------


def sizes(find: Find = distribution) -> list[Measurement]:
    """Bytes of rodgen, of it with what it needs, and with that of every extra."""
    own = find(NAME)
    extras = sorted(own.metadata.get_all("Provides-Extra") or [])
    rows = [_row("rodgen itself", bytes=own_bytes(own))]
    plain = dependencies(NAME, frozenset(), find)
    rows.append(_sum("rodgen with what it needs", plain, find))
    for extra in extras:
        whole = dependencies(NAME, frozenset({extra}), find)
        rows.append(_sum(f"rodgen[{extra}] with what it needs", whole, find))
        rows.append(_sum(f"what [{extra}] adds", whole - plain, find))
    rows += [_sum(name, {name}, find) for name in sorted(plain - {NAME})]
    return rows


def dependencies(name: str, extras: frozenset[str], find: Find = distribution) -> set[str]:
    """Names of a distribution and all that it requires, directly or not, extras followed."""
    seen: set[tuple[str, frozenset[str]]] = set()
    open_ = [(str(canonicalize_name(name)), extras)]
    while open_:
        at = open_.pop()
        if at not in seen:
            seen.add(at)
            with suppress(PackageNotFoundError):
                open_ += requirements(find(at[0]), at[1])
    return {name for name, _ in seen}


def requirements(own: Distribution, extras: frozenset[str]) -> Iterator[tuple[str, frozenset[str]]]:
    """Yield what a distribution requires with some of its extras, by name and extras of theirs."""
    for one in map(Requirement, own.requires or []):
        holds = one.marker is None or any(
            one.marker.evaluate({"extra": extra}) for extra in extras or {""}
        )
        if holds:
            yield canonicalize_name(one.name), frozenset(one.extras)


def _sum(what: str, names: set[str], find: Find) -> Measurement:
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
    """Bytes of a distribution's files; of one that is edited in place, of its package's: rodgen's
    own folder, and derive and templates beside it, without what Python compiled."""
    files = [Path(str(own.locate_file(file))) for file in own.files or []]
    held = any(file.parts[-2:] == (NAME, "__init__.py") for file in files)
    if canonicalize_name(own.metadata["Name"]) == NAME and not held:
        specs = [find_spec(name) for name in (NAME, f"{NAME}.derive", f"{NAME}.templates")]
        places = {Path(spec.origin).parent for spec in specs if spec and spec.origin}
        inside = {file for place in places for file in place.rglob("*")}
        files += [file for file in inside if "__pycache__" not in file.parts]
    return sum(file.stat().st_size for file in files if file.is_file())
