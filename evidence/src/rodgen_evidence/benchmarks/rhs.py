"""Times of the right-hand side: beside a plain elimination, in every form, and beside peers.

    python -m rodgen_evidence.benchmarks.rhs

The yardstick is the plain elimination of yardstick.c, compiled with the flags of the C target.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files

import numpy as np

import rodgen
from rodgen_evidence.benchmarks import Times
from rodgen_evidence.report.costs import rates
from rodgen_evidence.report.costs.cost_rows import (
    THRUST,
    Array,
    built,
    parameter_vector,
    scene,
    state,
)
from rodgen_evidence.report.interleaved_timing import Batch, time_in_turns
from rodgen_evidence.report.peers import RATES
from rodgen_evidence.report.peers.native import Native, compile_function
from rodgen_evidence.report.surroundings import flags

AGREED = 1e-9  # relative


def yardstick(links: int) -> Native:
    """The plain elimination for so many links."""
    text = files(__package__).joinpath("yardstick.c").read_text(encoding="utf-8")
    own = [*flags().split(), f"-DN={links}"]
    return compile_function({"yardstick.c": text}, "yardstick_rhs", own)


def tapered_rod(links: int, y: Array) -> Batch:
    """A rod whose stiffness and mass differ along it, and that carries bodies at both ends and
    beside it."""
    table = scene(links).model_dump(exclude_none=True)
    table["rod"]["bending_stiffness"] = "100*(1 - 0.5*s)"
    table["bodies"] = [
        {"name": "payload", "at": 0.0, "mass": 6.0, "inertia": 0.2},
        {"name": "gyro", "at": 0.3, "mass": 1.0, "offset": [0.0, 0.1]},
        {"name": "engine", "at": 1.0, "mass": 4.0},
    ]
    made = rodgen.Scene.from_dict(table)
    p = rodgen.build(made).parameters(**made.parameters)
    return rates.native(links, made.structure.nonuniform).batch(y, p)


def rhs(sizes: Sequence[int] = (5, 20, 50, 200, 1000), peers: bool = True) -> Times:
    """Everything for so many links. Raises ArithmeticError where the yardstick disagrees."""
    times = Times("the right-hand side, from C")
    for links in sizes:
        module, y = built(links, THRUST), state(links)
        p = parameter_vector(module)
        ours, plain = rates.native(links), yardstick(links)
        off = np.abs(ours(0.0, y, p) - plain(0.0, y, p)).max() / np.abs(plain(0.0, y, p)).max()
        if not off < AGREED:
            raise ArithmeticError(f"the yardstick differs by {off:.1e} at {links} links")
        both = time_in_turns({"ours": ours.batch(y, p), "plain": plain.batch(y, p)})
        median = both["ours"]
        times.add(f"n={links}", median, "plain elimination", both["plain"])
        both = time_in_turns({"even": ours.batch(y, p), "tapered": tapered_rod(links, y)})
        what = f"n={links}: tapered, with three bodies"
        times.add(what, both["tapered"], "even", both["even"])
        rows = [*rates.rates(links, module, True), *rates.jacobians(links, module, True)]
        for row in rows:
            if not row["failed"]:
                who = f"n={links}: {row['what']}, {row['who']}"
                times.add(who, float(str(row["seconds"])), "from C", median)
    for name in RATES if peers else ():
        for row in rates.of_peer(name, [n for n in sizes if n >= 20], quick=True):
            if not row["failed"]:
                its = next(s for what, s, *_ in times.rows if what == f"n={row['n']}")
                times.add(f"n={row['n']}: {name}", float(str(row["seconds"])), "from C", its)
    return times


if __name__ == "__main__":
    rhs().show()
