"""Rows of the text panel about the motion and how it is integrated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from rodgen.scene import Scene
from rodgen.scene.tables import AUTO
from rodgen.view.live.quantities.now import Entry, Now, column
from rodgen.view.live.quantities.numbers import NOTHING, five, fixed, padded, three, whole
from rodgen.view.live.quantities.present import Row

ANGLE = 3  # decimals of degrees
ROUNDING = 1e-12  # of the larger principal moment


def geometry(_: Scene) -> Iterator[Entry]:
    yield column("centre_of_gravity_x", "centre of gravity, x", "m", "centre", 0)
    yield column("centre_of_gravity_y", "centre of gravity, y", "m", "centre", 1)
    row = Row("principal_direction_1", "principal direction 1", "°")
    yield row, lambda now: fixed(_degrees(now), ANGLE)
    row = Row("principal_direction_2", "principal direction 2", "°")
    yield row, lambda now: fixed(_degrees(now) + (90 if _degrees(now) <= 0 else -90), ANGLE)
    yield _moment("principal_moment_1", "principal moment 1", "principal", 1)
    yield _moment("principal_moment_2", "principal moment 2", "principal", 2)
    yield _moment("inertia_x", "moment of inertia about x", "inertia", 0)
    yield _moment("inertia_y", "moment of inertia about y", "inertia", 1)
    yield _moment("product_xy", "product of inertia", "inertia", 2)


def _moment(key: str, label: str, group: str, column: int) -> Entry:
    """A row that shows a moment or product of inertia; what is rounding alone is shown as zero."""

    def show(now: Now) -> str:
        value, largest = float(now.group(group)[column]), float(now.group("principal")[2])
        return five(0.0 if abs(value) < ROUNDING * largest else value)

    return Row(key, label, "kg m²"), show


def _degrees(now: Now) -> float:
    return float(np.degrees(now.group("principal")[0]))


def energies(scene: Scene) -> Iterator[Entry]:
    yield column("kinetic_energy", "kinetic energy", "J", "energy", 0)
    yield column("spring_energy", "energy of the springs", "J", "energy", 1)
    if "gravity" in scene.loads.terms:
        yield column("gravity_energy", "energy in gravity", "J", "energy", 2)
    yield column("total_energy", "total energy", "J", "energy", 3)
    terms = [term for term in scene.loads.terms if term != "gravity"]
    for term in terms:
        yield Row(f"work_{term}", f"work of {term.replace('_', ' ')}", "J"), _work(term)
    row = Row("given", "given by changes and kicks", "J")
    yield row, lambda now: five(now.present.chunk.given)
    yield column("energy_balance", "balance error", "J", "balance", 0)


def _work(term: str) -> Callable[[Now], str]:
    """A rod whose module does no work by this load shows none."""

    def show(now: Now) -> str:
        works = now.source.works
        return five(float(now.group("work")[works.index(term)]) if term in works else 0.0)

    return show


def integration(scene: Scene) -> Iterator[Entry]:
    yield Row("method", "method", ""), _method
    if scene.integrate.fixed:
        yield Row("step", "step", "s"), lambda now: five(now.scene.integrate.step or math.nan)
    else:
        yield Row("rtol", "relative tolerance", ""), lambda now: five(now.scene.integrate.rtol)
        yield Row("atol", "absolute tolerance", ""), lambda now: five(now.scene.integrate.atol)
    yield Row("t", "simulated time", "s"), lambda now: fixed(now.present.t, _decimals(now.scene))
    yield Row("seconds", "computing time", "s"), lambda now: fixed(now.present.seconds, 2)
    yield Row("ratio", "ratio to real time", ""), _ratio
    yield Row("steps", "steps", ""), lambda now: whole(now.present.counts.steps)
    yield Row("rejected", "rejected steps", ""), _rejected
    yield Row("rhs", "evaluations of rhs", ""), lambda now: whole(now.present.counts.rhs)


def _method(now: Now) -> str:
    asked, used = now.scene.integrate.method, now.present.method
    if asked == AUTO and used and used != AUTO:
        return padded(f"{used} ({AUTO})")
    return padded(asked)


def _ratio(now: Now) -> str:
    ratio = now.present.ratio
    return padded(NOTHING) if ratio is None else three(ratio)


def _rejected(now: Now) -> str:
    rejected = now.present.counts.rejected
    return padded(NOTHING) if rejected is None else whole(rejected)


def _decimals(scene: Scene) -> int:
    """Of the time: as many as tell two samples apart."""
    return min(max(0, math.ceil(-math.log10(scene.integrate.output_every) - 1e-9)), 7)
