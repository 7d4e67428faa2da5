"""What everything costs against the number of links, and the exponents of that.

A free uniform rod with thrust; for implicit steps with internal damping as well. Batches of all
that is compared take turns, and medians are kept. What fails is a row that says why.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from itertools import groupby

import numpy as np

from rodgen.judge.cases import Case
from rodgen.judge.costs.peers_rates import known
from rodgen.judge.costs.rates import jacobians, rates, set_up
from rodgen.judge.costs.whole import analyses, implicit_steps, jobs
from rodgen.judge.rows import number
from rodgen.judge.unit import Row, Unit

LINKS = (10, 20, 50, 100, 200, 500, 1000, 2000)
QUICK = (10, 50)
ANALYSED = 200  # links: of what makes eigenvalues
LIMIT, PEER_LIMIT = 240.0, 120.0  # s
PEER = "rodgen.judge.costs.peers_rates:of_peer"


def units(_: list[Case], quick: bool) -> list[Unit]:
    """By number of links, then by peer; the scenes of the report have no part in it."""
    chosen, call = list(QUICK if quick else LINKS), f"{__name__}:costs"
    made = [
        Unit("costs", f"costs-n{n}", call, {"links": n, "quick": quick}, limit=LIMIT)
        for n in chosen
    ]
    for name in known():
        plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")
        asked = {"name": name, "links": [50] if quick else chosen, "quick": quick}
        made.append(Unit("costs", f"costs-peer-{plain}", PEER, asked, limit=PEER_LIMIT))
    return made


def costs(links: int, quick: bool = False) -> list[Row]:
    """All of one number of links: set-up from cold, then evaluations, steps, jobs, analyses."""
    with set_up(links, cold=not quick) as (rows, module):
        rows += rates(links, module, quick)
        rows += jacobians(links, module, quick)
        rows += jobs(links, module, quick)
    if not quick or links == QUICK[-1]:  # another module is to be made for them
        rows += implicit_steps(links, quick)
    return rows + (analyses(links, quick) if links <= ANALYSED else [])


def _curve(row: Row) -> tuple[str, str]:
    """Of which curve a row is a point."""
    return str(row["what"]), str(row["who"])


def fits(rows: Iterable[Row]) -> list[Row]:
    """Exponents of the seconds by n, per what and who, over the upper half of its numbers of links.

    A line of least squares through the logarithms; exponent None where there are not two.
    """
    good = [r for r in rows if not r.get("failed") and isinstance(r.get("seconds"), float)]
    found: list[Row] = []
    for (what, who), some in groupby(sorted(good, key=_curve), _curve):
        points = sorted((number(r, "n"), number(r, "seconds")) for r in some)
        upper = points[len(points) // 2 :] if len(points) > 3 else points
        found.append(
            {
                "what": what,
                "who": who,
                "exponent": _slope(upper),
                "from": upper[0][0],
                "to": upper[-1][0],
                "points": len(upper),
            }
        )
    return found


def _slope(points: list[tuple[float, float]]) -> float | None:
    """Of log seconds over log n."""
    kept = [(math.log(n), math.log(seconds)) for n, seconds in points if n > 0 and seconds > 0]
    if len({x for x, _ in kept}) < 2:
        return None
    x, y = np.array(kept).T
    return float(np.polyfit(x - x.mean(), y, 1)[0])
