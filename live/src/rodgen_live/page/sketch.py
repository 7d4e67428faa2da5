"""A scene as a small picture: the rod as it begins, what holds it, what it carries, its loads."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from rodgen.model.palette import LIGHT
from rodgen.model.rod import CLAMP_ANGLE
from rodgen.model.term import FORCE, SPREAD, WEIGHT, Term
from rodgen.model.terms import TERMS
from rodgen.scene import Scene
from rodgen.scene.plain_tables import get_at
from rodgen.scene.rod_points import link_and_share

WIDE, HIGH, ROOM, ARROW = 168, 104, 26, 22  # pixels; ROOM: about the rod
MOST = 200  # points of the line of the rod: more cannot be told apart
BODY = 9.0  # pixels, the radius of a body that is the whole mass
ALONG = (0.15, 0.38, 0.62, 0.85)  # places of the arrows of what acts all along the rod
ROD, FIXED, CARRIED, BED = (str(LIGHT[name]) for name in ("link", "joint", "body", "line"))
Points = NDArray[np.float64]


def sketch(scene: Scene) -> str:
    """Draw a scene as SVG, to be read on a light ground."""
    joints = joints_at_start(scene)
    ties = [(tie.x, tie.y) for tie in scene.anchors.support_points]
    seen = np.concatenate((joints, np.reshape(ties, (-1, 2))))
    low, high = seen.min(axis=0), seen.max(axis=0)
    free = np.array((WIDE, HIGH)) - 2 * ROOM
    scale = float(np.min(free / np.maximum(high - low, 1e-9 * scene.rod.length)))
    middle, turn = (low + high) / 2, np.array((scale, -scale))

    def to_pixels(points: Points) -> Points:
        found: Points = np.array((WIDE / 2, HIGH / 2)) + turn * (points - middle)
        return found

    line = to_pixels(joints)
    parts = (
        *_draw_supports(scene, line, to_pixels),
        *_draw_rod(scene, line),
        *_draw_loads(scene, line),
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {HIGH}">'
    return "\n".join((head, *parts, "</svg>"))


def joints_at_start(scene: Scene) -> Points:
    """Positions of the joints at the start [m], (links + 1, 2)."""
    y, boundary, rod = scene.initial_state(), scene.boundary_condition, scene.rod
    free = 2 * boundary.translates
    phi = y[free : (len(y) - len(scene.states)) // 2]
    clamp = getattr(rod, CLAMP_ANGLE.key) or 0.0
    phi = np.concatenate((np.full(boundary.first, clamp), phi))
    links = rod.length / rod.links * np.stack((np.cos(phi), np.sin(phi)), axis=-1)
    start = y[:2] if free else np.array(scene.anchors.start)
    return np.concatenate(([start], start + np.cumsum(links, axis=0)))


def _draw_rod(scene: Scene, line: Points) -> Iterator[str]:
    shown = line[np.unique(np.linspace(0, len(line) - 1, MOST).round().astype(int))]
    yield _line(shown, ROD, 4)
    for mark in scene.distribution.body_outlines:
        # The picture's y runs down: what lies to the left of a link lies to its right there.
        start, along = line[mark.link], line[mark.link + 1] - line[mark.link]
        place = start + mark.along * along + mark.across * np.array((along[1], -along[0]))
        yield _disc(place, max(BODY * mark.size, 2.0), CARRIED)
    yield _disc(line[0], 3.0, ROD)


def _draw_supports(scene: Scene, line: Points, placed: object) -> Iterator[str]:
    assert callable(placed)
    for tie in scene.anchors.support_points:
        way = line[tie.link] + tie.share * (line[tie.link + 1] - line[tie.link])
        fixed = placed(np.array((tie.x, tie.y)))
        yield _line(np.array((way, fixed)), FIXED, 1.5, dashed=True)
        yield _disc(fixed, 3.0, FIXED)
    if len(scene.anchors.foundation_line):
        yield _line(placed(scene.anchors.foundation_line), BED, 9)
    along = _unit_vector(line[1] - line[0])
    across = np.array((-along[1], along[0]))
    if scene.boundary_condition.start_drawing == "wall":
        yield _line(line[0] + np.outer((-12, 12), across), FIXED, 3)
    elif scene.boundary_condition.start_drawing == "pin":
        corners = line[0] + np.array(((0, 0), (-7, 11), (7, 11), (0, 0)))
        yield _line(corners, FIXED, 2)


def _draw_loads(scene: Scene, line: Points) -> Iterator[str]:
    for name in scene.loads.terms:
        term, colour = TERMS[name], TERMS[name].colours[0]
        if term.kind == FORCE:
            yield _arrow(*_arrow_ends(scene, term, line), colour)
        elif term.kind == SPREAD:
            for share in ALONG:
                place, along = _point_at(share, line)
                beside = place + 6 * np.array((-along[1], along[0]))
                yield _arrow(beside, beside - 0.6 * ARROW * along, colour)
        elif term.kind == WEIGHT:
            middle = line.mean(axis=0)
            yield _arrow(middle, middle + np.array((0.0, ARROW)), colour)


def _arrow_ends(scene: Scene, term: Term, line: Points) -> tuple[Points, Points]:
    """Ends of the arrow of a force at a point: one that pushes ends at the rod, and one that pulls
    begins there."""
    one = term.parameters[0]
    table = get_at(scene, *scene.key_path(one.name)[: -len(one.key_path)])
    place, along = _point_at(getattr(table, "at", 1.0), line)
    if term.follows:
        return place + ARROW * along, place
    parts = [get_at(table, *part.key_path) for part in term.size_parameters]
    # Of an expression it is shown that it is there, not which way it points at first.
    x, y = (part if isinstance(part, int | float) else 1.0 for part in parts)
    pull = ARROW * _unit_vector(np.array((x, -y)))
    return (place - pull, place) if pull @ along < 0 else (place, place + pull)


def _point_at(share: float, line: Points) -> tuple[Points, Points]:
    """Point at a share of the rod, and the direction of its link."""
    link, part = link_and_share(share, len(line) - 1)
    step = line[link + 1] - line[link]
    return line[link] + part * step, _unit_vector(step)


def _unit_vector(vector: Points) -> Points:
    size = float(np.hypot(*vector))
    return vector / size if size else np.array((0.0, 1.0))


def _points(points: Points) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _line(points: Points, colour: str, width: float, *, dashed: bool = False) -> str:
    style = ' stroke-dasharray="3 2"' * dashed
    return (
        f'<polyline points="{_points(points)}" fill="none" stroke="{colour}" '
        f'stroke-width="{width:g}" stroke-linecap="round" stroke-linejoin="round"{style}/>'
    )


def _disc(place: Points, radius: float, colour: str) -> str:
    return f'<circle cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{radius:.1f}" fill="{colour}"/>'


def _arrow(start: Points, end: Points, colour: str) -> str:
    along = _unit_vector(end - start)
    across = 3.5 * np.array((-along[1], along[0]))
    neck = end - 8 * along
    head = _points(np.array((end, neck + across, neck - across)))
    return _line(np.array((start, neck)), colour, 2) + f'<polygon points="{head}" fill="{colour}"/>'
