"""Studies whose workers and clients are killed at random, against undisturbed ones.

python -m rodgen_evidence.benchmarks.study_kills [STUDIES] [SEED] [BESIDE]

STUDIES studies (by default 20, BESIDE of them at a time) suffer five SIGKILLs each, of a worker or
of the client, at random times; a client that is killed is followed by one with --resume. Studies
that are done sooner are followed by others until there are five kills for each of them. Every
result has to be that of an undisturbed study, bit for bit.
"""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import count
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import psutil

import rodgen
from rodgen.studies.store import StudyStore, read_store
from rodgen.studies.study import Study
from rodgen_evidence.benchmarks.clusters import same

KILLS = 5  # of a study
CLIENTS = 0.2  # share of the kills that a client suffers
PAUSE = 2.5  # seconds between two kills at most, or
STRETCH = 0.2  # share of the blocks that are done between them at most
POINTS, BLOCK = 400, 5
FILE = """
name = "killed"
[scene]
name = "pendulum"
rod = {{links = 3, length = 1.0, bending_stiffness = 1.0, mass = 2.0, boundary = "pinned"}}
loads = {{gravity = {{g = 9.81}}, internal_damping = {{coefficient = 0.02}}}}
initial = {{phi = 0.8}}
integrate = {{method = "rk4", step = 1e-4, span = [0.0, {span}]}}
[vary]
"rod.mass" = {{bounds = [1, 2]}}
[sample]
method = "random"
count = {points}
seed = {seed}
[compute]
keep = ["last(tip_x)", "max(phi_2)"]
"""


@dataclass(frozen=True)
class Outcome:
    """Outcome of a study under kills.

    workers, clients: how many of them were killed; same: whether its bits are those of an
    undisturbed one; kept: how many of its points were there at each death of a client.
    """

    workers: int
    clients: int
    same: bool
    kept: tuple[int, ...]


def workers_of(client: psutil.Process) -> list[psutil.Process]:
    """The worker processes of a client."""
    return [one for one in client.children() if "--multiprocessing-fork" in one.cmdline()]


def compute_under_kills(
    file: Path, store: StudyStore, chance: random.Random, kills: int
) -> list[int]:
    """Compute a study under kills; return how many workers were killed and, for every client, how
    many points it left."""
    command = [sys.executable, "-m", "rodgen", "study", str(file), "--out", str(file.parent)]
    quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    killed, left = 0, list[int]()
    while True:
        client = subprocess.Popen([*command, "--workers", "2", "--resume"], text=True, **quiet)
        while client.poll() is None and killed + len(left) < kills:
            _pause(client, store, chance)
            try:
                this = psutil.Process(client.pid)
                own = workers_of(this)
                if own and chance.random() < CLIENTS:
                    this.send_signal(signal.SIGKILL)
                    if client.wait() != -signal.SIGKILL:
                        continue  # it was done just before
                    left.append(int((read_store(store.path)["status"].values != "").sum()))
                elif own:
                    chance.choice(own).send_signal(signal.SIGKILL)
                    killed += 1
            except psutil.NoSuchProcess:
                continue
        _, err = client.communicate()
        if client.returncode == 0:
            return [killed, *left]
        if client.returncode != -signal.SIGKILL:
            raise RuntimeError(f"a client ended with {client.returncode}: {err}")


def _pause(client: subprocess.Popen[str], store: StudyStore, chance: random.Random) -> None:
    """Wait for some time, or until some blocks are done: a client that goes on takes seconds until
    it computes, so that by time alone most kills would be of those that have not begun."""
    if chance.random() < 0.5:
        time.sleep(chance.uniform(0.0, PAUSE))
        return
    wanted = store.done_blocks().sum() + chance.uniform(1.0, max(1.0, STRETCH * store.layout.count))
    while client.poll() is None and store.done_blocks().sum() < wanted:
        time.sleep(chance.uniform(0.0, 0.1))


def outcome(seed: int, points: int = POINTS, span: float = 12.0, kills: int = KILLS) -> Outcome:
    """A study under kills beside an undisturbed one in this process."""
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as made:
        file = Path(made, "study.toml")
        file.write_text(FILE.format(points=points, seed=seed, span=span))
        study = Study.from_toml(file)
        store = StudyStore.create(Path(made, "killed", "study.zarr"), study, BLOCK)
        workers, *kept = compute_under_kills(file, store, chance, kills)
        found, expected = read_store(store.path), rodgen.study(study, workers=1)
        there = bool(np.all(found["status"].values == "finished"))
        return Outcome(workers, len(kept), there and same(found, expected), tuple(kept))


def study_kills(studies: int = 20, seed: int = 0, beside: int = 1, **how: Any) -> list[Outcome]:
    """Kill, compare, and print."""
    found: list[Outcome] = []
    seeds = count(1000 * seed)
    with ProcessPoolExecutor(beside, get_context("spawn")) as pool:
        while len(found) < studies or _kills(found) < how.get("kills", KILLS) * studies:
            some = [pool.submit(outcome, next(seeds), **how) for _ in range(beside)]
            for one in some:
                found.append(one.result())
                print(f"study {len(found)}: {found[-1]}", flush=True)
    right = sum(one.same for one in found)
    workers, clients = sum(one.workers for one in found), sum(one.clients for one in found)
    print(f"{right} of {len(found)} right, {workers} workers and {clients} clients killed")
    return found


def _kills(found: list[Outcome]) -> int:
    return sum(one.workers + one.clients for one in found)


if __name__ == "__main__":
    if not all(one.same for one in study_kills(*map(int, sys.argv[1:]))):
        sys.exit(1)
