"""What of an answer changes with twice as many links."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from rodgen.errors import AnalysisError, InputError
from rodgen.scene import Scene
from rodgen.scene.mesh import per_link

if TYPE_CHECKING:
    import xarray

    from rodgen.analyse.cycles.cycle import Cycle

MOVED = 0.01  # of a number: a change that is said


def twice(scene: Scene, key: str = "") -> Scene:
    """The same rod of twice as many links. Raises InputError for one that belongs to its number of
    links, and for a key that does."""
    if key == "rod.links" or key in {one.field for one in per_link(scene, everything=True)}:
        allowed = f"absent where {key} is varied, which belongs to the number of links"
        raise InputError("check_mesh", True, allowed)
    return scene.with_links(2 * scene.rod.links)


def compared(
    data: xarray.Dataset, links: int, follow: Callable[[], xarray.Dataset]
) -> xarray.Dataset:
    """A curve with what changes on it with twice as many links among its notes; follow: gives that
    of these."""
    return data.assign_attrs(
        notes="\n".join([*filter(None, [data.attrs["notes"]]), *_notes(data, links, follow)])
    )


def _notes(data: xarray.Dataset, links: int, follow: Callable[[], xarray.Dataset]) -> Iterator[str]:
    few, many = f"with {links} links", f"with {2 * links}"
    try:
        other = follow()
    except (AnalysisError, InputError) as error:
        yield f"{many} links there is none ({error})"
        return
    above = [one.attrs.get("supercritical") for one in (data, other)]
    if above[0] != above[1]:
        words = ["supercritical" if one else "subcritical" for one in above]
        yield f"{words[0]} {few}, {words[1]} {many}"
    kinds = [one["special_kind"].values.tolist() for one in (data, other)]
    if kinds[0] != kinds[1]:
        shown = [", ".join(one) or "none" for one in kinds]
        yield f"special points {few}: {shown[0]}; {many}: {shown[1]}"
        return
    values = (one["special_value"].values.tolist() for one in (data, other))
    for kind, a, b in zip(kinds[0], *values, strict=True):
        if _moved(a, b):
            yield f"{kind} at {a:.6g} {few}, at {b:.6g} {many}"
    ends = [(float(one["value"][-1]), int(one["unstable"][-1])) for one in (data, other)]
    if not _moved(ends[0][0], ends[1][0]) and ends[0][1] != ends[1][1]:
        yield f"at the end {ends[0][1]} directions are unstable {few}, {ends[1][1]} {many}"


def cycle_notes(cycle: Cycle, links: int, find: Callable[[], Cycle]) -> tuple[str, ...]:
    """What changes of a cycle with twice as many links; find: gives that of these."""
    few, many = f"with {links} links", f"with {2 * links}"
    try:
        other = find()
    except (AnalysisError, InputError) as error:
        return (f"{many} links there is none ({error})",)
    said = []
    if cycle.stable != other.stable:
        words = ["stable" if one.stable else "unstable" for one in (cycle, other)]
        said.append(f"{words[0]} {few}, {words[1]} {many}")
    for name, unit in (("period", "s"), ("amplitude", "rad")):
        a, b = (float(getattr(one, name)) for one in (cycle, other))
        if _moved(a, b):
            said.append(f"{name} {a:.6g} {unit} {few}, {b:.6g} {unit} {many}")
    return tuple(said)


def _moved(a: float, b: float) -> bool:
    return abs(a - b) > MOVED * max(abs(a), abs(b))
