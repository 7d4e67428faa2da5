"""A scene as a small picture: the rod as it begins, what holds it, what it carries, its loads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from rodgen.model.palette import LIGHT
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
Points = NDArray[np.complex128]  # x + iy, in pixels, of which y runs down


def sketch(scene: Scene) -> str:
    """Draw a scene as SVG, to be read on a light ground."""
    joints, anchors = joints_at_start(scene), scene.anchors
    ties = np.reshape([(tie.x, tie.y) for tie in anchors.support_points], (-1, 2))
    seen = np.concatenate((joints, ties))
    low, high = seen.min(axis=0), seen.max(axis=0)
    free = np.array((WIDE, HIGH)) - 2 * ROOM
    scale = float(np.min(free / np.maximum(high - low, 1e-9 * scene.rod.length)))

    def to_pixels(points: NDArray[np.float64]) -> Points:
        x, y = scale * (points - (low + high) / 2).T
        found: Points = WIDE / 2 + x + 1j * (HIGH / 2 - y)
        return found

    line = to_pixels(joints)
    parts = (
        *_draw_supports(scene, line, to_pixels(ties), to_pixels(anchors.foundation_line)),
        *_draw_rod(scene, line),
        *_draw_loads(scene, line),
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {HIGH}">'
    return "\n".join((head, *parts, "</svg>"))


def joints_at_start(scene: Scene) -> NDArray[np.float64]:
    """Positions of the joints at the start [m], (links + 1, 2)."""
    y, boundary, rod = scene.initial_state(), scene.boundary_condition, scene.rod
    free = 2 * boundary.translates
    held = [rod.clamp_angle or 0.0] * boundary.first
    phi = np.concatenate((held, y[free : (len(y) - len(scene.states)) // 2]))
    links = rod.length / rod.links * np.stack((np.cos(phi), np.sin(phi)), axis=-1)
    start = y[:2] if free else np.array(scene.anchors.start)
    return np.concatenate(([start], start + np.cumsum(links, axis=0)))


def _draw_rod(scene: Scene, line: Points) -> Iterator[str]:
    yield _line(line[np.unique(np.linspace(0, len(line) - 1, MOST).round().astype(int))], ROD, 4)
    for mark in scene.distribution.body_outlines:
        step = line[mark.link + 1] - line[mark.link]
        # y runs down: what lies to the left of a link lies to its right there.
        place = line[mark.link] + complex(mark.along, -mark.across) * step
        yield _disc(place, max(BODY * mark.size, 2.0), CARRIED)
    yield _disc(line[0], 3.0, ROD)


def _draw_supports(scene: Scene, line: Points, ties: Points, bed: Points) -> Iterator[str]:
    for tie, fixed in zip(scene.anchors.support_points, ties, strict=True):
        way = line[tie.link] + tie.share * (line[tie.link + 1] - line[tie.link])
        yield _line((way, fixed), FIXED, 1.5, dashed=True)
        yield _disc(fixed, 3.0, FIXED)
    if len(bed):
        yield _line(bed, BED, 9)
    start, along = line[0], _unit_vector(line[1] - line[0])
    if scene.boundary_condition.start_drawing == "wall":
        yield _line((start - 12j * along, start + 12j * along), FIXED, 3)
    elif scene.boundary_condition.start_drawing == "pin":
        yield _line((start, start - 7 + 11j, start + 7 + 11j, start), FIXED, 2)


def _draw_loads(scene: Scene, line: Points) -> Iterator[str]:
    for name in scene.loads.terms:
        term, colour = TERMS[name], TERMS[name].colours[0]
        if term.kind == FORCE:
            yield _arrow(*_arrow_ends(scene, term, line), colour)
        elif term.kind == SPREAD:
            for share in ALONG:
                place, along = _point_at(share, line)
                yield _arrow(place + 6j * along, place + (6j - 0.6 * ARROW) * along, colour)
        elif term.kind == WEIGHT:
            yield _arrow(line.mean(), line.mean() + 1j * ARROW, colour)


def _arrow_ends(scene: Scene, term: Term, line: Points) -> tuple[complex, complex]:
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
    pull = ARROW * _unit_vector(complex(x, -y))
    pushes = (pull * along.conjugate()).real < 0
    return (place - pull, place) if pushes else (place, place + pull)


def _point_at(share: float, line: Points) -> tuple[complex, complex]:
    link, part = link_and_share(share, len(line) - 1)
    step = line[link + 1] - line[link]
    return line[link] + part * step, _unit_vector(step)


def _unit_vector(vector: complex) -> complex:
    return vector / abs(vector) if vector else 1j


def _points(points: Iterable[complex]) -> str:
    return " ".join(f"{z.real:.1f},{z.imag:.1f}" for z in points)


def _line(points: Iterable[complex], colour: str, width: float, *, dashed: bool = False) -> str:
    style = ' stroke-dasharray="3 2"' * dashed
    return (
        f'<polyline points="{_points(points)}" fill="none" stroke="{colour}" '
        f'stroke-width="{width:g}" stroke-linecap="round" stroke-linejoin="round"{style}/>'
    )


def _disc(at: complex, radius: float, colour: str) -> str:
    return f'<circle cx="{at.real:.1f}" cy="{at.imag:.1f}" r="{radius:.1f}" fill="{colour}"/>'


def _arrow(start: complex, end: complex, colour: str) -> str:
    along = _unit_vector(end - start)
    neck = end - 8 * along
    head = _points((end, neck + 3.5j * along, neck - 3.5j * along))
    return _line((start, neck), colour, 2) + f'<polygon points="{head}" fill="{colour}"/>'
