"""The scenes of a range of numbers, judged one after the other and kept in a file of JSON lines."""

from __future__ import annotations

import json
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from rodgen.loading.cache import source_hash
from rodgen_evidence.verdicts.along_load import AlongLoad
from rodgen_evidence.verdicts.compare import judge
from rodgen_evidence.verdicts.judgement import CONTRADICTED, FOLD, NONE, REFUSED, RIGHT, Judgement
from rodgen_evidence.verdicts.product_answers import Answers
from rodgen_evidence.verdicts.random_scenes import sketch

FILE = "verdicts.jsonl"
SOURCES = "rodgen", "rodgen.derive", "rodgen.templates", "rodgen_evidence.verdicts"
KINDS = RIGHT, CONTRADICTED, REFUSED, FOLD, NONE
Line = dict[str, Any]
Judge = Callable[[int], list[Judgement]]


def judged_scene(seed: int) -> list[Judgement]:
    """The verdicts on the scene of a number."""
    return judge(AlongLoad(sketch(seed)), Answers(sketch(seed)))


def campaign(numbers: Iterable[int], folder: Path, judge: Judge = judged_scene) -> Iterator[Line]:
    """A line for every scene; those in the file, of the present source, are not done again."""
    file, source = folder / FILE, source_hash(*SOURCES)
    folder.mkdir(parents=True, exist_ok=True)
    text = file.read_text(encoding="utf-8") if file.exists() else ""
    # What was cut off in the middle of a line is not there.
    known = [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("}\n")]
    if not text.endswith("\n") and text:
        file.write_text(text[: text.rfind("\n") + 1], encoding="utf-8")
    done = {line["seed"]: line for line in known if line["source"] == source}
    for seed in numbers:
        if seed not in done:
            begun = time.perf_counter()
            verdicts = judge(seed)
            line = {"seed": seed, "source": source, "seconds": time.perf_counter() - begun}
            done[seed] = line | {"verdicts": [list(one) for one in _kept(verdicts)]}
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(done[seed], ensure_ascii=False) + "\n")
        yield done[seed]


def _kept(verdicts: list[Judgement]) -> Iterator[Judgement]:
    """Verdicts without the words of what is right: refusals tell them."""
    for one in verdicts:
        plain = one.kind == RIGHT and one.function != "critical"
        yield one._replace(size=float(one.size), text="" if plain else one.text)


def show(lines: list[Line], console: Console | None = None) -> int:
    """Print what was compared, and all that is wrong; how many verdicts are contradicted or
    refused."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    scenes: dict[tuple[str, str], set[int]] = defaultdict(set)
    console = console or Console()
    for line in lines:
        for function, kind, size, text in line["verdicts"]:
            counts[function][kind] += 1
            scenes[function, kind].add(line["seed"])
            if kind in (CONTRADICTED, REFUSED, FOLD):
                at = f"{line['seed']}: {function} {kind} at {size:.9g}"
                console.print(f"{at}: {text}", highlight=False, markup=False, soft_wrap=True)
    seconds = sum(line["seconds"] for line in lines)
    table = Table(title=f"verdicts on {len(lines)} random scenes, {seconds:.0f} s")
    for column in ("function", *KINDS):
        table.add_column(column, justify="left" if column == "function" else "right")
    for function, found in counts.items():
        each = (f"{found[k]} in {len(scenes[function, k])}" if found[k] else "0" for k in KINDS)
        table.add_row(function, *each)
    console.print(table)
    console.print("verdicts in scenes; refused: where the reference has an answer")
    return sum(found[CONTRADICTED] + found[REFUSED] for found in counts.values())
