"""What the module of a scene holds, piece by piece, with the reason."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rodgen.model.rod import INERTIAS
from rodgen.model.term import DAMPER, Term
from rodgen.model.terms import TERMS
from rodgen.scene.grammar import in_brief
from rodgen.scene.law import Along
from rodgen.scene.places import point_of
from rodgen.scene.plain import entry
from rodgen.scene.scene import Scene
from rodgen.scene.tables import Body


@dataclass(frozen=True)
class Piece:
    """A piece of the model: whether the module has it, and why."""

    piece: str
    present: bool
    reason: str


ROOTLESS = "no spring at joint 0"
KINDS = [*TERMS]


def contents(scene: Scene) -> list[Piece]:
    """All pieces that a module can have, for this scene."""
    rod, held, differing = scene.rod, scene.held, scene.distribution.differing
    moving = rod.links - held
    free = scene.hold.translates
    pieces = [
        Piece(
            "translation x0, y0",
            free,
            "boundary free" if free else f"boundary {rod.boundary}: joint 0 is fixed",
        ),
        Piece(
            f"{moving} moving link{'s' * (moving > 1)}",
            True,
            f"links {held} to {rod.links - 1}"
            + ("; link 0 is held at clamp_angle" if held else ""),
        ),
        Piece(
            "coupling of links in M and Q",
            moving > 1,
            "every pair of moving links" if moving > 1 else "a single link moves",
        ),
        Piece(
            "rotary springs",
            rod.links > 1,
            f"{rod.links - 1} inner joints{_each(differing.get('bending_stiffness'))}"
            if rod.links > 1
            else "one link has no inner joint",
        ),
        Piece(
            "root spring",
            scene.hold.root > 0,
            f"boundary {rod.boundary}: "
            + ("2 EI/l at joint 0, against clamp_angle" if scene.hold.root else ROOTLESS),
        ),
        Piece(
            "law of springs",
            scene.spring_law is not None,
            in_brief(scene.rod.spring or "k*d, Hooke's"),
        ),
        *(
            Piece("mass of links", True, f"mass_per_length{_each(law)}")
            for key, law in differing.items()
            if key == "mass_per_length"
        ),
        *(
            Piece(
                f"body {body.name}",
                True,
                f"{mass:g} kg{when} on link {point_of(body.at, rod.links)[0]}, at s = {body.at:g}",
            )
            for body, mass, when in _masses(scene)
        ),
        Piece(
            "rotary inertia of links",
            INERTIAS[rod.inertia].rotary,
            f"inertia {rod.inertia}: {INERTIAS[rod.inertia].description}",
        ),
    ]
    added = [
        Piece(f"state {name}", True, f"its rate is part of the code: {in_brief(rate.canonical)}")
        for name, rate in scene.rates.items()
    ]
    added += [
        Piece(f"table {name}", True, f"{len(table)} rows, from {first:g} to {last:g}")
        for name, table in scene.tables.items()
        for first, last in [table.knots[[0, -1]]]
    ]
    loads = {term.name: term for term in TERMS.values()}
    loads |= {name: TERMS[name] for name in scene.structure.loads}
    # A load that a scene has several times stands beside the first of its kind.
    rows = sorted(loads.values(), key=lambda term: KINDS.index(term.kind_name))
    return pieces + [_term(scene, term) for term in rows] + [*_supports(scene)] + added


def in_words(scene: Scene) -> list[str]:
    """What acts on a rod and what is added to it, by name."""
    names = [TERMS[name].words for name in scene.structure.loads if name != "supports"]
    count = len(scene.supports)
    held = [f"{count} support{'s' * (count > 1)}"] * bool(count)
    return names + held + [f"state {name}" for name in scene.states]


def _supports(scene: Scene) -> Iterator[Piece]:
    """Every support by itself."""
    for number, support in enumerate(scene.supports):
        x, y = scene.anchors.place(support)
        sizes = {
            "N/m along x": support.stiffness[0],
            "N/m along y": support.stiffness[1],
            "N m/rad": support.rotation,
            "N s/m along x": support.damping[0],
            "N s/m along y": support.damping[1],
            "N m s/rad": support.rotation_damping,
        }
        what = ", ".join(f"{size:g} {unit}" for unit, size in sizes.items() if size)
        link = point_of(support.at, scene.rod.links)[0]
        reason = f"on link {link}, at s = {support.at:g}, to ({x:g}, {y:g}) m: {what or 'nothing'}"
        yield Piece(f"support {number}", True, reason)


def _masses(scene: Scene) -> Iterator[tuple[Body, float, str]]:
    """Bodies with their masses, and what is said of one that changes."""
    for body, mass in zip(scene.bodies, scene.distribution.body_mass, strict=True):
        changes = isinstance(body.mass, str)
        yield body, mass, f" at the start, {in_brief(str(body.mass))}," * changes


def _each(law: Along | None) -> str:
    """What is said of a value that differs along the rod."""
    if isinstance(law, list):
        law = f"{min(law):g} to {max(law):g}"
    return "" if law is None else f", each its own: {in_brief(str(law))}"


def _term(scene: Scene, term: Term) -> Piece:
    name, table = term.words, f"table {_table(scene, term)}"
    if term.name not in scene.structure.loads:
        return Piece(name, False, f"no {table}")
    if term.kind == DAMPER and not scene.hold.springs(scene.rod.links):
        return Piece(name, False, "one link has no inner joint; the parameter is taken, not used")
    laws, fed = scene.expressions, scene.fed
    functions = [
        f"{one.key} {'follows the motion' if one.name in fed else 'is a function of t'}, "
        f"part of the code: {in_brief(laws[one.name].canonical)}"
        for one in term.parameters
        if one.name in laws
    ]
    return Piece(name, True, "; ".join((*_place(scene, term), *functions)) or table)


def _table(scene: Scene, term: Term) -> str:
    """The table of a term, or that of one among several."""
    where, path = (scene.loads, f"loads.{term.table}") if term.loads else (scene, term.table)
    return f"[[{path}]]" if isinstance(getattr(where, term.table), list) else f"[{path}]"


def _place(scene: Scene, term: Term) -> list[str]:
    """Where a load acts that is not the only one of its kind at the tail."""
    if not term.placed:
        return []
    keys = scene.place(term.parameters[0].name)[1:-1]
    at = entry(scene.loads, *keys, "at")
    if at == 1 and len(keys) == 1:
        return []
    link = point_of(at, scene.rod.links)[0]
    return [f"table {_table(scene, term)} on link {link}, at s = {at:g}"]
