"""The text in a result file that says how its run goes."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

from rodgen.integrate.files.checks import SEAL, sealed, unharmed
from rodgen.integrate.files.netcdf import PAGE
from rodgen.integrate.solution import Stats
from rodgen.integrate.stepper import Counts
from rodgen.scene import SceneError

RUNNING = "running"  # status in a file whose run has not ended
NO_STATS = Stats.of(Counts(), 0.0)


class Run(NamedTuple):
    """How a run goes; lost: events for which the file had no room; samples, events: how many of
    them count; fixed: checksum of what in the file does not change."""

    status: str = RUNNING
    message: str = ""
    stats: Stats | None = None
    lost: int = 0
    samples: int = 0
    events: int = 0
    fixed: int = 0

    def text(self) -> bytes:
        """As PAGE bytes of JSON with a checksum; a message that is too long is cut."""
        run = {"checksum": "0" * SEAL[1], **self._asdict()}
        run["stats"] = self.stats and asdict(self.stats)
        message = self.message
        while len(text := json.dumps({**run, "message": message}).encode()) > PAGE:
            if not message:
                raise ValueError(f"{len(text)} bytes of status and stats, more than {PAGE}")
            # In JSON a character needs 12 bytes at most.
            message = message[: -max(1, (len(text) - PAGE) // 12)]
        return sealed(text.ljust(PAGE))

    @classmethod
    def of(cls, text: bytes, path: Path) -> Run:
        """What `text` made; raises SceneError for other text, in the file at path."""
        if not unharmed(text):
            raise SceneError("file", str(path), "as it was written (damaged: how the run went)")
        return cls._of(text)

    @classmethod
    def of_former(cls, text: bytes, samples: int, events: int) -> Run:
        """From a file of the format BEFORE, which counts samples and events elsewhere."""
        return cls._of(text)._replace(samples=samples, events=events)

    @classmethod
    def _of(cls, text: bytes) -> Run:
        run = json.loads(text)
        stats = run["stats"] and Stats(**run["stats"])
        numbers = (int(run.get(name, 0)) for name in ("lost", "samples", "events", "fixed"))
        return cls(str(run["status"]), str(run["message"]), stats, *numbers)
