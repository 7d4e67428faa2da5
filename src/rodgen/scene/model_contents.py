"""Parts of the model of a scene: which of them its module has, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rodgen.model.rod import INERTIAS
from rodgen.model.term import DAMPER, Term
from rodgen.model.terms import TERMS
from rodgen.scene.grammar import abbreviate
from rodgen.scene.law import Along
from rodgen.scene.plain_tables import get_at
from rodgen.scene.rod_points import link_and_share
from rodgen.scene.scene import Scene
from rodgen.scene.tables import BodyTable


@dataclass(frozen=True)
class ModelPart:
    """A part of the model: whether the module has it, and why."""

    piece: str
    present: bool
    reason: str


ROOTLESS = "no spring at joint 0"
KINDS = [*TERMS]


def model_parts(scene: Scene) -> list[ModelPart]:
    """All parts that a module can have, and which of them this scene has."""
    rod, held, differing = scene.rod, scene.n_fixed_links, scene.distribution.nonuniform_values
    moving = rod.links - held
    free = scene.boundary_condition.translates
    pieces = [
        ModelPart(
            "translation x0, y0",
            free,
            "boundary free" if free else f"boundary {rod.boundary}: joint 0 is fixed",
        ),
        ModelPart(
            f"{moving} moving link{'s' * (moving > 1)}",
            True,
            f"links {held} to {rod.links - 1}"
            + ("; link 0 is held at clamp_angle" if held else ""),
        ),
        ModelPart(
            "coupling of links in M and Q",
            moving > 1,
            "every pair of moving links" if moving > 1 else "a single link moves",
        ),
        ModelPart(
            "rotary springs",
            rod.links > 1,
            f"{rod.links - 1} inner joints{_describe_variation(differing.get('bending_stiffness'))}"
            if rod.links > 1
            else "one link has no inner joint",
        ),
        ModelPart(
            "root spring",
            scene.boundary_condition.root > 0,
            f"boundary {rod.boundary}: "
            + (
                "2 EI/l at joint 0, against clamp_angle"
                if scene.boundary_condition.root
                else ROOTLESS
            ),
        ),
        ModelPart(
            "law of springs",
            scene.spring_law is not None,
            abbreviate(scene.rod.spring or "k*d, Hooke's"),
        ),
        *(
            ModelPart("mass of links", True, f"mass_per_length{_describe_variation(law)}")
            for key, law in differing.items()
            if key == "mass_per_length"
        ),
        *(
            ModelPart(
                f"body {body.name}",
                True,
                f"{mass:g} kg{when} on link {link_and_share(body.at, rod.links)[0]}, "
                f"at s = {body.at:g}",
            )
            for body, mass, when in _describe_masses(scene)
        ),
        ModelPart(
            "rotary inertia of links",
            INERTIAS[rod.inertia].rotary,
            f"inertia {rod.inertia}: {INERTIAS[rod.inertia].description}",
        ),
    ]
    added = [
        ModelPart(
            f"state {name}", True, f"its rate is part of the code: {abbreviate(rate.canonical)}"
        )
        for name, rate in scene.state_rates.items()
    ]
    added += [
        ModelPart(f"table {name}", True, f"{len(table)} rows, from {first:g} to {last:g}")
        for name, table in scene.tables.items()
        for first, last in [table.knots[[0, -1]]]
    ]
    loads = {term.name: term for term in TERMS.values()}
    loads |= {name: TERMS[name] for name in scene.structure.loads}
    # A load that a scene has several times stands beside the first of its kind.
    rows = sorted(loads.values(), key=lambda term: KINDS.index(term.base_name))
    return pieces + [_term_part(scene, term) for term in rows] + [*_support_parts(scene)] + added


def describe_loads(scene: Scene) -> list[str]:
    """Names of the loads, supports and added states of a scene."""
    names = [TERMS[name].words for name in scene.structure.loads if name != "supports"]
    count = len(scene.supports)
    held = [f"{count} support{'s' * (count > 1)}"] * bool(count)
    return names + held + [f"state {name}" for name in scene.states]


def _support_parts(scene: Scene) -> Iterator[ModelPart]:
    """Yield a part for every support."""
    for number, support in enumerate(scene.supports):
        x, y = scene.anchors.fixed_point(support)
        sizes = {
            "N/m along x": support.stiffness[0],
            "N/m along y": support.stiffness[1],
            "N m/rad": support.rotation,
            "N s/m along x": support.damping[0],
            "N s/m along y": support.damping[1],
            "N m s/rad": support.rotation_damping,
        }
        what = ", ".join(f"{size:g} {unit}" for unit, size in sizes.items() if size)
        link = link_and_share(support.at, scene.rod.links)[0]
        reason = f"on link {link}, at s = {support.at:g}, to ({x:g}, {y:g}) m: {what or 'nothing'}"
        yield ModelPart(f"support {number}", True, reason)


def _describe_masses(scene: Scene) -> Iterator[tuple[BodyTable, float, str]]:
    """Yield bodies with their masses [kg], and words on a mass that changes."""
    for body, mass in zip(scene.bodies, scene.distribution.body_masses, strict=True):
        changes = isinstance(body.mass, str)
        yield body, mass, f" at the start, {abbreviate(str(body.mass))}," * changes


def _describe_variation(law: Along | None) -> str:
    """Words on a value that varies along the rod; empty for one that does not."""
    if isinstance(law, list):
        law = f"{min(law):g} to {max(law):g}"
    return "" if law is None else f", each its own: {abbreviate(str(law))}"


def _term_part(scene: Scene, term: Term) -> ModelPart:
    name, table = term.words, f"table {_table_heading(scene, term)}"
    if term.name not in scene.structure.loads:
        return ModelPart(name, False, f"no {table}")
    if term.kind == DAMPER and not scene.boundary_condition.spring_joints(scene.rod.links):
        return ModelPart(
            name, False, "one link has no inner joint; the parameter is taken, not used"
        )
    laws, fed = scene.expressions, scene.feedback_loads
    functions = [
        f"{one.key} {'follows the motion' if one.name in fed else 'is a function of t'}, "
        f"part of the code: {abbreviate(laws[one.name].canonical)}"
        for one in term.parameters
        if one.name in laws
    ]
    return ModelPart(name, True, "; ".join((*_describe_place(scene, term), *functions)) or table)


def _table_heading(scene: Scene, term: Term) -> str:
    """Name of a term's table in a scene file, [[...]] where there are several."""
    where, path = (scene.loads, f"loads.{term.table}") if term.is_load else (scene, term.table)
    return f"[[{path}]]" if isinstance(getattr(where, term.table), list) else f"[{path}]"


def _describe_place(scene: Scene, term: Term) -> list[str]:
    """Words on where a load acts; none for a single one at the tail."""
    if not term.placed:
        return []
    keys = scene.key_path(term.parameters[0].name)[1:-1]
    at = get_at(scene.loads, *keys, "at")
    if at == 1 and len(keys) == 1:
        return []
    link = link_and_share(at, scene.rod.links)[0]
    return [f"table {_table_heading(scene, term)} on link {link}, at s = {at:g}"]
