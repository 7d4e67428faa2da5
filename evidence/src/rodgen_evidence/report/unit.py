"""A unit of measurement: what is called with what, the rows that it gave, and its process."""

from __future__ import annotations

import ctypes
import hashlib
import json
import signal
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from importlib import import_module
from typing import Any

from rodgen.analyse.precision.contestant import Measurement
from rodgen_evidence.report.surroundings import sources


@dataclass(frozen=True)
class Unit:
    """One process's work.

    name: of its file, made of letters, digits, - and _; function: "package.module:function", which
    is called with the arguments (what JSON holds) and returns rows; timed: whether it needs the
    machine for itself; limit: seconds after which it is stopped.
    """

    section: str
    name: str
    function: str
    arguments: dict[str, Any]
    timed: bool = True
    limit: float = 120.0

    def fingerprint(self, surroundings: Sequence[str]) -> str:
        """Hash of the call but for its folder, of its sources and surroundings."""
        package = self.function.partition(":")[0].rpartition(".")[0]
        own = sources(package, "rodgen_evidence.report.peers") if package else ""
        given = {name: value for name, value in self.arguments.items() if name != "folder"}
        content = json.dumps([self.function, given, own, *surroundings], sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()[:32]

    def call(self) -> list[Measurement]:
        """The rows, made in this process."""
        module, _, function = self.function.partition(":")
        rows: list[Measurement] = getattr(import_module(module), function)(**self.arguments)
        return rows


@dataclass(frozen=True)
class Measured:
    """Result of a unit; failed: why there are no rows, or only those before it failed."""

    section: str
    name: str
    fingerprint: str
    seconds: float
    rows: list[Measurement] = field(default_factory=list)
    failed: str = ""

    def dump(self) -> str:
        """Return the text of a file."""
        return json.dumps(asdict(self), indent=0) + "\n"

    @classmethod
    def parse(cls, text: str) -> Measured:
        """Read the text of a file. Raises ValueError, TypeError where it is none."""
        return cls(**json.loads(text))


LONGEST = 300  # letters of a reason


PR_SET_PDEATHSIG = 1  # of Linux's prctl


def main() -> None:
    """Call the unit; its rows, or why there are none, as the last line of standard output."""
    with suppress(OSError, AttributeError):  # nobody waits for what a killed report began
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    unit = Unit(**json.load(sys.stdin))
    start = time.perf_counter()
    rows: list[Measurement] = []
    failed = ""
    try:
        rows = unit.call()
    except Exception as error:  # another's library may fail in any way
        failed = " ".join(str(error).split())[:LONGEST] or repr(error)
    seconds = time.perf_counter() - start
    print("\n" + json.dumps({"rows": rows, "failed": failed, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
