"""Marks of what happens in a run, on time axes and on paths: events, and when forces act that do
not always act. Numbers stand at the marks, and the names in the legend, where they have room.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from rodgen.arrays import Array
from rodgen.integrate import Solution
from rodgen.model.term import COUPLE, FORCE, SPREAD, Term
from rodgen.model.terms import TERMS
from rodgen.show.canvas import BEHIND, FAINT, letter_size, scales_of

MOST_NAMES = 12  # that have numbers of their own
DIGIT = 1.25  # widths of a letter
BAR = 0.03  # of the height of axes: of a bar as long as a force acts


def mark_times(axes: Axes, solution: Solution) -> None:
    """Mark on a time axis, once its curves are drawn, when forces act and when events happened;
    names are for `add_legend`."""
    rows: dict[str, int] = {}
    for term, start, end in force_intervals(solution):
        label = None if term.name in rows else f"{term.label} acts"
        low = BAR * rows.setdefault(term.name, len(rows))
        colour = term.colours[0]
        axes.axvspan(start, end, low, low + BAR, label=label, color=colour, alpha=0.7, linewidth=0)
    t = [event.t for event in solution.events]
    numbers, labels = _number_names(event.name for event in solution.events)
    for time, number in zip(t, numbers, strict=True):
        label = labels.pop(number, None)
        axes.axvline(time, color=FAINT, linewidth=0.8, linestyle=":", label=label)
    places = np.column_stack((t, np.zeros(len(t)))) * scales_of(axes)
    for at, text in _join_numbers(places, numbers):
        left = -36 * DIGIT * letter_size()[0]  # points: the first digit is above its line
        above: dict[str, Any] = {
            "xycoords": axes.get_xaxis_transform(),
            "textcoords": "offset points",
        }
        axes.annotate(text, (t[at], 1.0), (left, 2), color=FAINT, **above)


def mark_path(axes: Axes, solution: Solution) -> None:
    """Mark on the path of the centre of gravity, once the limits are set, where forces begin and
    end to act, and events; names are for `add_legend`."""
    said = [(event.t, event.name) for event in solution.events]
    for term, start, end in force_intervals(solution):
        said += [(t, f"{term.label} {what}") for t, what in ((start, "begins"), (end, "ends"))]
    said = sorted((t, name) for t, name in said if solution.t[0] < t < solution.t[-1])
    t = [time for time, _ in said]
    numbers, labels = _number_names(name for _, name in said)
    path = np.column_stack(
        [np.interp(t, solution.t, part) for part in solution.centre_of_gravity.T]
    )
    for place, number in zip(path, numbers, strict=True):
        axes.plot(*place, "D", color=FAINT, markersize=4, label=labels.pop(number, None))
    for at, text in _join_numbers(path * scales_of(axes), numbers):
        how: dict[str, Any] = {"textcoords": "offset points", "color": FAINT, "bbox": BEHIND}
        axes.annotate(text, path[at], (3, 4), **how)


def _number_names(names: Iterable[str]) -> tuple[list[int], dict[int, str]]:
    """Return the number of each name, in the order in which they come, one for all beyond the most
    that there may be; and what stands in the legend for each number."""
    named = list(names)
    every = list(dict.fromkeys(named))
    labels = {at: f"{at}: {name}" for at, name in enumerate(every[:MOST_NAMES], 1)}
    if len(every) > MOST_NAMES:
        labels[MOST_NAMES + 1] = f"{MOST_NAMES + 1}: others"
    numbers = {name: min(at, MOST_NAMES + 1) for at, name in enumerate(every, 1)}
    return [numbers[name] for name in named], labels


def _join_numbers(places: Array, numbers: Sequence[int]) -> list[tuple[int, str]]:
    """Return texts of numbers at places (k, 2) [inches], and the index of the place where each
    stands: texts that would lie over each other are one."""
    width, height = DIGIT * letter_size()[0], letter_size()[1]
    found: list[tuple[int, set[int]]] = []

    def overlap(one: tuple[int, set[int]], other: tuple[int, set[int]]) -> bool:
        across, up = places[other[0]] - places[one[0]]
        left = one if across >= 0 else other
        return bool(abs(across) < width * (len(_text(left[1])) + 1) and abs(up) < height)

    for new in ((at, {number}) for at, number in enumerate(numbers)):
        while near := next((one for one in found if overlap(one, new)), None):
            found.remove(near)
            new = near[0], near[1] | new[1]
        found.append(new)
    return [(at, _text(joined)) for at, joined in found]


def _text(numbers: Iterable[int]) -> str:
    """Write numbers with commas, three and more that follow each other with a dash."""
    every = np.array(sorted(numbers))
    rows = np.split(every, np.flatnonzero(np.diff(every) > 1) + 1)
    return ",".join(
        f"{row[0]}\u2013{row[-1]}" if len(row) > 2 else ",".join(map(str, row)) for row in rows
    )


def force_intervals(solution: Solution) -> Iterator[tuple[Term, float, float]]:
    """Yield the forces and couples that act for some of the time, with start and end of each
    interval [s]."""
    for name in solution.scene.loads.terms:
        term = TERMS[name]
        if term.kind == COUPLE:
            acts = solution.values(term.size_parameters[0].name) != 0
        elif term.kind in (FORCE, SPREAD):
            acts = np.abs(solution.forces[name]).sum(axis=(1, 2)) > 0
        else:
            continue
        if acts[1:-1].all() or not acts.any():  # where it grows from zero, it acts throughout
            continue
        edges = np.flatnonzero(np.diff(np.concatenate(([0], acts, [0]))))
        for first, beyond in zip(edges[::2], edges[1::2], strict=True):
            end = min(int(beyond), len(acts) - 1)
            yield term, float(solution.t[max(int(first) - 1, 0)]), float(solution.t[end])
