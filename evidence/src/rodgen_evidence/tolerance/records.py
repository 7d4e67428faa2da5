"""Records of scenes by number, kept in a file of JSON lines so that a campaign can go on."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from rodgen.loading.cache import source_hash
from rodgen_evidence.tolerance.measure.scene_record import measure_scene

FILE = "tolerance.jsonl"
SOURCES = (
    *("rodgen", "rodgen.derive", "rodgen.templates"),
    *("rodgen_evidence.tolerance.measure", "rodgen_evidence.verdicts"),
)
Record = dict[str, Any]


def records(
    numbers: Iterable[int], folder: Path, measure: Callable[[int], Record] = measure_scene
) -> Iterator[Record]:
    """Yield the record of every scene; those in the file, of the present source, are not made
    again."""
    file, source = folder / FILE, source_hash(*SOURCES)
    folder.mkdir(parents=True, exist_ok=True)
    done = {one["seed"]: one for one in _whole(file) if one["source"] == source}
    for seed in numbers:
        if seed not in done:
            begun = time.perf_counter()
            found = measure(seed)
            known = {"seed": seed, "source": source, "seconds": time.perf_counter() - begun}
            done[seed] = json.loads(json.dumps(known | found))
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(done[seed]) + "\n")
        yield done[seed]


def _whole(file: Path) -> list[Record]:
    """Lines of the file; one that was cut off is taken out of it."""
    text = file.read_text(encoding="utf-8") if file.exists() else ""
    if text and not text.endswith("\n"):
        text = text[: text.rfind("\n") + 1]
        file.write_text(text, encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]
