"""Parts of the model of a scene: which of them its module has, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import atanh, cos, inf, sin

from rodgen.model.rod import INERTIAS
from rodgen.model.term import BASE, CONTACT, DAMPER, Parameter, Term
from rodgen.model.terms import PARAMETERS, TERMS
from rodgen.scene.grammar import abbreviate
from rodgen.scene.law import Along
from rodgen.scene.plain_tables import get_at
from rodgen.scene.scene import Scene


@dataclass(frozen=True)
class ModelPart:
    """A part of the model: whether the module has it, and why."""

    piece: str
    present: bool
    reason: str


KINDS = [*TERMS]
HALF, LEVEL = 0.5, 1e-12  # of the largest friction


def model_parts(scene: Scene) -> list[ModelPart]:
    """All parts that a module can have, and which of them this scene has."""
    loads = {term.name: term for term in TERMS.values()}
    loads |= {name: TERMS[name] for name in scene.structure.loads}
    # A load that a scene has several times stands beside the first of its kind.
    rows = sorted(loads.values(), key=lambda term: KINDS.index(term.base_name))
    terms = (_term_part(scene, term) for term in rows)
    return [*_rod_parts(scene), *terms, *_support_parts(scene), *_added_parts(scene)]


def _rod_parts(scene: Scene) -> Iterator[ModelPart]:
    """Yield the parts of the rod and a part for every body."""
    rod, start, along = scene.rod, scene.boundary_condition, scene.distribution
    moving, boundary = rod.links - start.first, f"boundary {rod.boundary}"
    held = "joint 0 is fixed" if scene.base is None else "[base] moves what holds it"
    fixed = "" if start.translates else f": {held}"
    yield ModelPart("translation x0, y0", start.translates, boundary + fixed)
    clamp = "; link 0 is held at clamp_angle" if start.first else ""
    links = f"links {start.first} to {rod.links - 1}{clamp}"
    yield ModelPart(f"{moving} moving link{'s' * (moving > 1)}", True, links)
    coupled = "every pair of moving links" if moving > 1 else "a single link moves"
    yield ModelPart("coupling of links in M and Q", moving > 1, coupled)
    yield ModelPart("links of unequal length", not along.mesh.is_even, _describe_lengths(scene))
    varying = _describe_variation(along.nonuniform_values.get("bending_stiffness"))
    varying += ", and an end bends up to a body there" * ("ends" in along.nonuniform)
    joints = f"{rod.links - 1} inner joints{varying}"
    joints = joints if rod.links > 1 else "one link has no inner joint"
    yield ModelPart("rotary springs", rod.links > 1, joints)
    root = "2 EI/l at joint 0, against clamp_angle" if start.root else "no spring at joint 0"
    yield ModelPart("root spring", start.root > 0, f"{boundary}: {root}")
    spring = abbreviate(rod.spring or "k*d, Hooke's")
    yield ModelPart("law of springs", scene.spring_law is not None, spring)
    bent = rod.rest_curvature is not None
    curvature = describe_along(rod.rest_curvature)
    shape = f"rest_curvature {curvature} 1/m" if bent else "straight: no rest_curvature"
    yield ModelPart("bent at rest", bent, shape)
    if varying := _describe_variation(along.nonuniform_values.get("mass_per_length")):
        yield ModelPart("mass of links", True, f"mass_per_length{varying}")
    if rod.stations is not None:
        stations = f"{len(rod.stations)} stations, {along.total_link_mass:g} kg in all"
        yield ModelPart("mass of links", True, stations)
    for body, mass in zip(scene.bodies, along.body_masses, strict=True):
        when = f" at the start, {abbreviate(body.mass)}," if isinstance(body.mass, str) else ""
        where = _describe_point(scene, body.at)
        yield ModelPart(f"body {body.name}", True, f"{mass:g} kg{when} {where}")
    inertia = INERTIAS[rod.inertia]
    reason = f"inertia {rod.inertia}: {inertia.description}"
    yield ModelPart("rotary inertia of links", inertia.rotary, reason)


def _added_parts(scene: Scene) -> Iterator[ModelPart]:
    """Yield a part for every added state and every table."""
    for name, rate in scene.state_rates.items():
        reason = f"its rate is part of the code: {abbreviate(rate.canonical)}"
        yield ModelPart(f"state {name}", True, reason)
    for name, table in scene.tables.items():
        reason = f"{len(table)} rows, from {table.knots[0]:g} to {table.knots[-1]:g}"
        yield ModelPart(f"table {name}", True, reason)


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
        where = _describe_point(scene, support.at)
        reason = f"{where}, to ({x:g}, {y:g}) m: {what or 'nothing'}"
        yield ModelPart(f"support {number}", True, reason)


def _describe_point(scene: Scene, at: float) -> str:
    """Words on a point of the rod; at: its s."""
    return f"on link {scene.mesh.link_and_share(at)[0]}, at s = {at:g}"


def describe_along(value: Along | None) -> str:
    """Describe a number, an expression in s, or the range of values along the rod."""
    if isinstance(value, list):
        return f"{min(value):g} to {max(value):g}"
    return abbreviate(value) if isinstance(value, str) else f"{value or 0.0:g}"


def _describe_lengths(scene: Scene) -> str:
    """Words on the lengths of the links."""
    lengths = scene.mesh.lengths(scene.rod.length)
    if scene.mesh.is_even:
        return f"{lengths[0]:.6g} m each"
    joints = scene.rod.joints
    law = f": joints at {abbreviate(joints)}" if isinstance(joints, str) else ""
    return f"{lengths.min():.6g} to {lengths.max():.6g} m{law}"


def _describe_variation(law: Along | None) -> str:
    """Words on a value that varies along the rod; empty for one that does not."""
    return "" if law is None else f", each its own: {describe_along(law)}"


def _term_part(scene: Scene, term: Term) -> ModelPart:
    name, table = term.words, f"table {_table_heading(scene, term)}"
    if term.kind == BASE and not scene.boundary_condition.is_held:
        return ModelPart(name, False, f"boundary {scene.rod.boundary}: nothing holds the rod")
    if term.name not in scene.structure.loads:
        return ModelPart(name, False, f"no {table}")
    if term.kind == CONTACT:
        return ModelPart(name, True, _describe_contact(scene, term))
    if term.kind == DAMPER and not scene.boundary_condition.spring_joints(scene.rod.links):
        unused = "one link has no inner joint; the parameter is taken, not used"
        return ModelPart(name, False, unused)
    laws, fed = scene.expressions, scene.feedback_loads
    functions = [
        f"{one.key} {'follows the motion' if one.name in fed else 'is a function of t'}, "
        f"part of the code: {_law_text(scene, one)}"
        for one in term.parameters
        if one.name in laws
    ]
    if term.kind == BASE and scene.base is not None:
        numbers = scene.base.values.items()
        functions += [f"{PARAMETERS[of].key} is {x!r}" for of, x in numbers if of not in laws]
    words = (*_describe_place(scene, term), *functions, *_describe_joint_friction(scene, term))
    words += _describe_fins(scene, term)
    return ModelPart(name, True, "; ".join(words) or table)


def _law_text(scene: Scene, one: Parameter) -> str:
    """Text of a law, as the scene has it where it stands for more."""
    if one.table:
        return abbreviate(scene.given_value(one.name))
    return abbreviate(scene.expressions[one.name].canonical)


def _describe_contact(scene: Scene, term: Term) -> str:
    """Words on a contact: where, its numbers, and how fast friction creeps."""
    rows = scene.structure.load_rows[term.name].parameters
    keys, values = scene.contacts.table_keys[term.name], scene.parameters
    words = [f"{values[one.name]:g} {one.unit}".strip() for one in rows]
    said = ", ".join(
        f"{one.name.removeprefix(f'{term.name}_')} {x}" for one, x in zip(rows, words, strict=True)
    )
    where = f"{_describe_point(scene, get_at(scene, *keys, 'at'))}: " if term.placed else ""
    return f"{where}{said}" + _describe_creep(scene, term)


def _describe_creep(scene: Scene, term: Term) -> str:
    """Words on the speed at which what lies on a wall with friction creeps."""
    values = scene.parameters
    if (mu := values.get(f"{term.name}_friction")) is None:
        return ""
    slow, share = values[f"{term.name}_friction_speed"], HALF
    under = "half of the friction that slides"
    if any(falls := _gravity(scene)):
        angle = values[f"{term.name}_normal"]
        presses = -(falls[0] * cos(angle) + falls[1] * sin(angle))
        drives = abs(falls[1] * cos(angle) - falls[0] * sin(angle))
        share = drives / (mu * presses) if mu and presses > 0 else inf
        under = "its weight"
    if share < LEVEL:
        return "; what lies on it stays where it is"
    if share >= 1:
        return "; what lies on it slides under its weight"
    return f"; what lies on it creeps under {under}, at {slow * atanh(share):.6g} m/s"


def _gravity(scene: Scene) -> tuple[float, float]:
    """Acceleration of free fall at the start of the span [m/s^2]."""
    start, found = scene.integrate.span[0], dict[str, float]()
    for one in TERMS["gravity"].parameters if "gravity" in scene.structure.loads else ():
        if one.name in scene.given_parameters:
            e = scene.expression(one.name)
            found[one.name] = float(scene.given_value(one.name) if e is None else e(start))
    return found.get("gravity_x", 0.0), found.get("gravity_y", -found.get("gravity", 0.0))


def _describe_joint_friction(scene: Scene, term: Term) -> list[str]:
    """Words on the rate at which a joint creeps under less than its friction."""
    if term.name != "joint_friction":
        return []
    rate = scene.parameters["joint_friction_rate"] * atanh(HALF)
    return [f"a joint under half of the moment that bends it creeps at {rate:.6g} rad/s"]


def _describe_fins(scene: Scene, term: Term) -> tuple[str, ...]:
    """Words on fins that are given by their geometry, and where their force acts."""
    keys = scene.loads.table_keys[term.name] if term.is_load else ()
    geometry = getattr(get_at(scene.loads, *keys), "geometry", None) if keys else None
    if geometry is None:
        return ()
    of = geometry.fin_set
    centre = f"centre of pressure {of.centre:.6g} m behind the leading edge of the root"
    return (f"slope {of.normal_slope:.6g} over {of.area:.6g} m^2, {centre}",)


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
    held = scene.mesh.link_and_share(at)[0] < scene.boundary_condition.first
    idle = ", which is held: it does nothing" if held else ""
    return [f"table {_table_heading(scene, term)} {_describe_point(scene, at)}{idle}"]
