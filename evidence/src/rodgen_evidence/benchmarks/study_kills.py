"""Studies whose workers and clients are killed at random, against undisturbed ones.

python -m rodgen_evidence.benchmarks.study_kills [STUDIES] [SEED]

Each of STUDIES studies (by default 20) suffers five SIGKILLs, of a worker or of the client, at
random times; a client that is killed is followed by one with --resume. Every result has to be that
of an undisturbed study, bit for bit.
"""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil

import rodgen
from rodgen.studies.specification import Study
from rodgen.studies.store import Store, read

KILLS = 5  # of a study
CLIENTS = 0.2  # share of the kills that a client suffers
PAUSE = 2.5  # seconds between two kills at most
POINTS, BLOCK = 400, 5
FILE = """
name = "killed"
[scene]
name = "pendulum"
rod = {{links = 3, length = 1.0, bending_stiffness = 1.0, mass = 2.0, boundary = "pinned"}}
loads = {{gravity = {{g = 9.81}}, internal_damping = {{coefficient = 0.02}}}}
initial = {{phi = 0.8}}
integrate = {{method = "rk4", step = 1e-4, span = [0.0, 12.0]}}
[vary]
"rod.mass" = {{from = 1, to = 2}}
[sample]
method = "random"
count = {points}
seed = {seed}
[compute]
keep = ["last(tip_x)", "max(phi_2)"]
"""


def workers_of(client: psutil.Process) -> list[psutil.Process]:
    """The worker processes of a client."""
    return [one for one in client.children() if "--multiprocessing-fork" in one.cmdline()]


def disturbed(file: Path, chance: random.Random) -> tuple[int, int]:
    """Compute a study under kills; how many workers and how many clients were killed."""
    command = [sys.executable, "-m", "rodgen", "study", str(file), "--out", str(file.parent)]
    quiet: Any = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    killed = [0, 0]
    while True:
        client = subprocess.Popen([*command, "--workers", "2", "--resume"], text=True, **quiet)
        while client.poll() is None and sum(killed) < KILLS:
            time.sleep(chance.uniform(0.0, PAUSE))
            try:
                this = psutil.Process(client.pid)
                own = workers_of(this)
                of_client = bool(own) and chance.random() < CLIENTS
                victim = this if of_client else chance.choice(own) if own else None
                if victim is not None:
                    victim.send_signal(signal.SIGKILL)
                    killed[of_client] += 1
            except psutil.NoSuchProcess:
                continue
        _, err = client.communicate()
        if client.returncode == 0:
            return killed[0], killed[1]
        if client.returncode != -signal.SIGKILL:
            raise RuntimeError(f"a client ended with {client.returncode}: {err}")


def main() -> None:
    """Kill, compare, and print."""
    studies = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    chance = random.Random(int(sys.argv[2]) if len(sys.argv) > 2 else 0)
    total, right = [0, 0], 0
    for seed in range(studies):
        with tempfile.TemporaryDirectory() as made:
            file = Path(made, "study.toml")
            file.write_text(FILE.format(points=POINTS, seed=seed))
            study, store = Study.from_toml(file), Path(made, "killed", "study.zarr")
            Store.make(store, study, BLOCK)
            workers, clients = disturbed(file, chance)
            found, expected = read(store), rodgen.study(study, workers=1)
            same = all(
                np.array_equal(found[name].values, expected[name].values)
                for name in {*expected.variables} - {"seconds"}
            )
        total = [total[0] + workers, total[1] + clients]
        right += same
        print(
            f"study {seed}: {workers} workers, {clients} clients killed: same = {same}", flush=True
        )
    print(f"{right} of {studies} studies right, {total[0]} workers and {total[1]} clients killed")
    if right < studies:
        sys.exit(1)


if __name__ == "__main__":
    main()
