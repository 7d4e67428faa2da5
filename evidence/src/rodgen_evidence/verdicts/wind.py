"""Statics of rods with drag in a wind, against plain continuation in small steps of the load.

python -m rodgen_evidence.verdicts.wind [--scenes 100] [--first 0]

All loads, drag among them, grow together from nothing. `static_equilibrium` has to find the rest
at the end of that way, and may refuse only where it turns back: at a fold, where the smallest
singular value of the stiffness goes to zero.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from typing import Any

import numpy as np
from rich.progress import track

import rodgen
from rodgen_evidence.verdicts.digits import FLOAT
from rodgen_evidence.verdicts.exact_rest import ChainFoldError, follow, stiffness
from rodgen_evidence.verdicts.judgement import CONTRADICTED, FOLD, REFUSED, RIGHT, Judgement
from rodgen_evidence.verdicts.link_chain import LinkChain, Table
from rodgen_evidence.verdicts.product_answers import Refusal, ask
from rodgen_evidence.verdicts.scaling import with_load

STEP = 0.01  # of the way
SAME = 1e-7  # rad or m
FOLDED = 0.02  # of the stiffness at the start
BOUNDARIES = ("clamped", "cantilever", "pinned", "clamped", "free")


def windy(seed: int) -> Table:
    """A rod of ones in a wind of any direction; some have other loads."""
    rng = np.random.default_rng([seed, 4])

    def size(low: float, high: float) -> float:
        return float(f"{10 ** rng.uniform(np.log10(low), np.log10(high)):.6g}")

    boundary = BOUNDARIES[seed % len(BOUNDARIES)]
    rod: Table = {"links": int(rng.integers(1 + (boundary in ("cantilever", "free")), 6))}
    rod |= {"length": 1.0, "mass": 1.0, "bending_stiffness": 1.0, "boundary": boundary}
    # Half of the winds blow more or less against the rod, which then turns over.
    speed, angle = size(1, 12), float(rng.uniform(-np.pi, np.pi))
    angle = np.pi + angle / 4 if rng.random() < 0.5 else angle
    drag: Table = {"normal": size(0.1, 2), "tangential": float(rng.choice([0.0, size(0.01, 0.5)]))}
    drag["wind"] = [round(speed * float(part), 6) for part in (np.cos(angle), np.sin(angle))]
    loads: Table = {"drag": drag, "material_damping": {"time": 0.05}}
    if rng.random() < 0.3:
        loads["follower"] = {"force": float(rng.choice([-1, 1])) * size(0.1, 8)}
    if rng.random() < 0.3:
        loads["gravity"] = {"g": size(0.1, 10)}
    if rng.random() < 0.2:
        loads["tip"] = {"x": float(rng.normal()), "y": float(rng.normal())}
    table: Table = {"name": f"windy_{seed}", "rod": rod, "loads": loads}
    ends = {"free": (0.0, 1.0), "pinned": (float(rng.choice([0.5, 1.0])),)}.get(boundary, ())
    if not ends and rng.random() < 0.2:
        ends = (1.0,)
    rows = [{"at": at, "stiffness": [size(0.5, 50), size(0.5, 50)]} for at in ends]
    return table | ({"supports": rows} if rows else {})


def judge_rest(seed: int, answer: Any = None, step: float = STEP) -> Judgement:
    """Judge the rest of a scene; answer: that of `static_equilibrium`, by default; step:
    the longest of the way."""
    table = windy(seed)
    answer = answer or ask(lambda: rodgen.static_equilibrium(rodgen.Scene.from_dict(table)))
    chain = LinkChain(table, FLOAT)
    start = np.zeros(chain.size)
    try:
        z = follow(lambda share: with_load(table, "", 0.0, share), start, step)
    except ChainFoldError as folded:
        return _at_fold(table, start, folded, answer)
    if isinstance(answer, Refusal):
        return Judgement("wind", REFUSED, 1.0, answer.text)
    own = answer.y[: chain.size]
    apart = float(np.abs(own - z).max(initial=0.0))
    if apart > SAME:
        text = f"another branch, {apart:.3g} away: {own.tolist()}, not {z.tolist()}"
        return Judgement("wind", CONTRADICTED, 1.0, text)
    return Judgement("wind", RIGHT, 1.0)


def _at_fold(table: Table, start: Any, folded: ChainFoldError, answer: Any) -> Judgement:
    """The verdict where plain continuation goes no further."""
    sizes = [
        np.linalg.svd(
            stiffness(LinkChain(with_load(table, "", 0.0, at), FLOAT), z), compute_uv=False
        ).min()
        for at, z in ((0.0, start), (folded.where, folded.z))
    ]
    where = f"turns back at {folded.where:.6g}, stiffness {sizes[1] / sizes[0]:.2g} of the first"
    if sizes[1] > FOLDED * sizes[0]:
        return Judgement("wind", CONTRADICTED, folded.where, f"no fold of the reference: {where}")
    if isinstance(answer, Refusal):
        return Judgement("wind", FOLD, folded.where, f"{where}; {answer.text}")
    return Judgement(
        "wind", CONTRADICTED, folded.where, f"{where}, but there is an answer: {answer}"
    )


def main() -> int:
    """Judge the scenes that are asked for; 1 if one is wrong."""
    parser = argparse.ArgumentParser(prog="python -m rodgen_evidence.verdicts.wind")
    parser.add_argument("--scenes", type=int, default=100, help="how many")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    asked_for = parser.parse_args()
    numbers = range(asked_for.first, asked_for.first + asked_for.scenes)
    verdicts = {seed: judge_rest(seed) for seed in track(numbers, "scenes")}
    for seed, one in verdicts.items():
        if one.kind != RIGHT:
            print(f"{seed}: {one.kind}: {one.text}")
    counts = Counter(one.kind for one in verdicts.values())
    print("; ".join(f"{kind}: {count}" for kind, count in counts.items()))
    return int(counts[CONTRADICTED] + counts[REFUSED] > 0)


if __name__ == "__main__":
    sys.exit(main())
