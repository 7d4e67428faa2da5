"""Check of a result against that of twice as many links."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from rodgen.errors import AnalysisError, InputError
from rodgen.result import NOTES, Note, doubt, notes_as_text, notes_from
from rodgen.scene import Scene
from rodgen.scene.mesh import mesh_dependent_values

if TYPE_CHECKING:
    import xarray

    from rodgen.analyse.cycles.cycle_result import Cycle

MOVED = 0.01  # of a number: a change that is said


def double_links(scene: Scene, key: str = "") -> Scene:
    """Refine a scene to twice as many links. Raises InputError if values are given link by link,
    and for a key that depends on the number of links."""
    if key == "rod.links" or key in {
        one.field for one in mesh_dependent_values(scene, everything=True)
    }:
        allowed = f"absent where {key} is varied, which belongs to the number of links"
        raise InputError("check_mesh", True, allowed)
    return scene.with_links(2 * scene.rod.links)


def add_mesh_doubts(
    data: xarray.Dataset, links: int, follow: Callable[[], xarray.Dataset]
) -> xarray.Dataset:
    """Add to the notes of a curve what changes with twice as many links; follow: computes the curve
    of these."""
    found = *notes_from(data.attrs), *_curve_doubts(data, links, follow)
    return data.assign_attrs({NOTES: notes_as_text(found)})


def _curve_doubts(
    data: xarray.Dataset, links: int, follow: Callable[[], xarray.Dataset]
) -> Iterator[Note]:
    few, many = f"with {links} links", f"with {2 * links}"
    try:
        other = follow()
    except (AnalysisError, InputError) as error:
        yield doubt(f"{many} links there is none ({error})")
        return
    above = [one.attrs.get("supercritical") for one in (data, other)]
    if above[0] != above[1]:
        was, becomes = ("supercritical" if one else "subcritical" for one in above)
        yield doubt(f"{was} {few}, {becomes} {many}")
    kinds = [one["special_kind"].values.tolist() for one in (data, other)]
    if kinds[0] != kinds[1]:
        shown = [", ".join(one) or "none" for one in kinds]
        yield doubt(f"special points {few}: {shown[0]}; {many}: {shown[1]}")
        return
    values = (one["special_value"].values.tolist() for one in (data, other))
    for kind, a, b in zip(kinds[0], *values, strict=True):
        if _is_different(a, b):
            words = f"{kind} at {a:.6g} {few}, at {b:.6g} {many}"
            yield doubt(words, here=a, with_twice_the_links=b)
    ends = [(float(one["value"][-1]), int(one["unstable"][-1])) for one in (data, other)]
    if not _is_different(ends[0][0], ends[1][0]) and ends[0][1] != ends[1][1]:
        text = f"at the end {ends[0][1]} directions are unstable {few}, {ends[1][1]} {many}"
        yield doubt(text, here=ends[0][1], with_twice_the_links=ends[1][1])


def cycle_doubts(cycle: Cycle, links: int, find: Callable[[], Cycle]) -> tuple[Note, ...]:
    """Doubts about a cycle that changes with twice as many links; find: computes that."""
    few, many = f"with {links} links", f"with {2 * links}"
    try:
        other = find()
    except (AnalysisError, InputError) as error:
        return (doubt(f"{many} links there is none ({error})"),)
    said = []
    if cycle.stable != other.stable:
        was, becomes = ("stable" if one.stable else "unstable" for one in (cycle, other))
        said.append(doubt(f"{was} {few}, {becomes} {many}"))
    for name, unit in (("period", "s"), ("amplitude", "rad")):
        a, b = (float(getattr(one, name)) for one in (cycle, other))
        if _is_different(a, b):
            words = f"{name} {a:.6g} {unit} {few}, {b:.6g} {unit} {many}"
            said.append(doubt(words, here=a, with_twice_the_links=b))
    return tuple(said)


def _is_different(a: float, b: float) -> bool:
    return abs(a - b) > MOVED * max(abs(a), abs(b))
