"""A scene as a small picture: the rod as it begins, what holds it, what it carries, its loads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO

import numpy as np
from matplotlib.figure import Figure

from rodgen.arrays import Array
from rodgen.integrate.weights import fall_of
from rodgen.model.term import COUPLE, FORCE, SPREAD, WEIGHT, Term
from rodgen.scene import Scene
from rodgen.scene.plain_tables import get_at
from rodgen.scene.rod_mesh import RodMesh
from rodgen.show.canvas import ROD
from rodgen.show.marks import base_at, curved_arrow, draw_marks

SIZE, ROOM, ARROW = np.array((168.0, 104.0)), 26.0, 22.0  # points; ROOM: about the rod
ALONG, ASIDE = (0.15, 0.38, 0.62, 0.85), 8.0  # where on the rod arrows stand; points beside it
NO_GAP = {"mutation_scale": 12.0, "shrinkA": 0, "shrinkB": 0}
LEFT = np.array(((0.0, 1.0), (-1.0, 0.0)))  # turns rows to the left


def thumbnail(scene: Scene) -> bytes:
    """Draw a scene as SVG, to be read on a light ground."""
    joints = joints_at_start(scene)
    seen = np.array([*joints, *((tie.x, tie.y) for tie in scene.anchors.support_points)])
    low, high = seen.min(axis=0), seen.max(axis=0)
    point = float(np.max((high - low) / (SIZE - 2 * ROOM)))  # metres
    figure = Figure(tuple(SIZE / 72))
    figure.set_layout_engine("none")  # whatever the style in use
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    (left, right), (below, above) = np.transpose((low + high) / 2 + point * SIZE / 2 * [[-1], [1]])
    axes.set(xlim=(left, right), ylim=(below, above))
    axes.plot(*joints.T, color=ROD, linewidth=3.0)
    draw_marks(axes, scene, joints, ROD)
    for term in map(scene.structure.load_rows.__getitem__, scene.loads.terms):
        style = {"arrowstyle": "-|>", "color": term.colours[0], "lw": 2.0, **NO_GAP}
        for *line, start, end in _arrows(scene, term, joints, point):
            axes.plot(*np.transpose([*line, start]), color=style["color"], lw=2.0)
            axes.annotate("", (*end,), (*start,), arrowprops=style)
    file = BytesIO()
    figure.savefig(file, format="svg", transparent=True)
    return file.getvalue()


def joints_at_start(scene: Scene) -> Array:
    """Positions of the joints at the start [m], (links + 1, 2)."""
    y, boundary = scene.initial_state(), scene.boundary_condition
    free = 2 * boundary.translates
    held = [base_at(scene)[1]] * boundary.first
    phi = np.concatenate((held, y[free : (len(y) - len(scene.states)) // 2]))
    lengths = scene.mesh.lengths(scene.rod.length)[:, None]
    links = lengths * np.stack((np.cos(phi), np.sin(phi)), axis=-1)
    return scene.anchors.start + np.cumsum(np.vstack((np.zeros(2), links)), axis=0)


def _arrows(scene: Scene, term: Term, joints: Array, point: float) -> Iterator[Sequence[Array]]:
    """Points of the arrows of a load [m]; point: metres. One that pushes ends at the rod."""
    # Of an expression it is shown that it is there, not which way it points at first.
    found = {part.name: scene.loads.value(part.name) for part in term.size_parameters}
    sizes = {name: x if isinstance(x, int | float) else 1.0 for name, x in found.items()}
    size, table = point * ARROW, get_at(scene.loads, *scene.loads.table_keys[term.name])
    if term.kind == SPREAD:
        nu = angle if isinstance(angle := getattr(table, "angle", None), float) else 0.0
        for share in ALONG:
            place, along = _point_at(scene.mesh, share, joints)
            push = -0.6 * size * (np.cos(nu) * along + np.sin(nu) * along @ LEFT)
            start = place + point * ASIDE * np.cos(nu) * along @ LEFT - abs(np.sin(nu)) * push
            yield start, start + push
    elif term.kind == WEIGHT:
        middle, fall = joints.mean(axis=0), fall_of(term, sizes.__getitem__)
        yield middle, middle + size * fall / (np.linalg.norm(fall) or 1.0)
    elif term.kind in (FORCE, COUPLE):
        place, along = _point_at(scene.mesh, getattr(table, "at", 1.0), joints)
        pull = np.array([*sizes.values()])
        if term.kind == COUPLE:
            yield [*(place + curved_arrow(0.4 * size, np.sign(pull[0]))[:-3])]
            return
        pull = -size * along if term.follows else size * pull / (np.linalg.norm(pull) or 1.0)
        yield (place - pull, place) if pull @ along < 0 else (place, place + pull)


def _point_at(mesh: RodMesh, share: float, joints: Array) -> tuple[Array, Array]:
    """A point of the rod [m], and the direction of its link."""
    link, part = mesh.link_and_share(share)
    step = joints[link + 1] - joints[link]
    return joints[link] + part * step, step / np.linalg.norm(step)
