"""A Structure to the text of its module: pure, the same bytes everywhere and always."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import sympy
from jinja2 import Environment, StrictUndefined
from sympy import Expr

from rodgen.derive.general import Equations, joint, joint_x, joint_y
from rodgen.derive.quantities import Quantities
from rodgen.emit.program import Compiler
from rodgen.emit.statements import SCALAR, Domain, Program
from rodgen.scene.expression import Expression
from rodgen.scene.structure import Structure

TEMPLATES = {"numpy": "numpy_dense.py.jinja"}
GUARD = "tests/generated/test_reference_modules.py"

DESCRIPTION = {"free": "free in space", "cantilever": "held at link 0 (the thesis's clamp)"}
RULES = {
    "mass": "positive",
    "length": "positive",
    "bending_stiffness": "at least 0",
    "internal_damping": "at least 0",
    "external_damping": "at least 0",
}
DEFAULTS = {"follower_angle": "0.0", "clamp_angle": "0.0", "gravity": "9.81", "fin_factor": "None"}
PARAMETER_DOCS = {
    "mass": "of the rod [kg]",
    "length": "of the rod [m]",
    "bending_stiffness": "EI [N m^2]",
    "follower_force": "thrust P at the tail [N], compressive for P > 0",
    "follower_angle": "angle nu between thrust and last link [rad]",
    "gravity": "acceleration g [m/s^2], downwards",
    "internal_damping": "c_int [m^2/s]",
    "external_damping": "c_ext [1/s]",
    "clamp_angle": "angle of the held link [rad]",
    "fin_factor": "s at every joint, nose to tail; ones if not given",
}
NO_ENERGY = "np.zeros_like(kinetic)"  # the contract has three energies, whatever the scene


def module_text(structure: Structure, target: str = "numpy") -> str:
    """The generated module of a structure as text."""
    template = TEMPLATES[target]
    source = files("rodgen.templates").joinpath(template).read_text(encoding="utf-8")
    environment = Environment(undefined=StrictUndefined, keep_trailing_newline=True)
    context = _context(structure, template, source)
    return environment.from_string(source).render(context)


def template_hash(source: str) -> str:
    """Content hash of a template."""
    return hashlib.sha256(source.encode()).hexdigest()[:16]


def _context(structure: Structure, template: str, source: str) -> dict[str, Any]:
    equations = Equations(structure.boundary, structure.inertia, structure.terms)
    hold, n = equations.hold, structure.links
    compiler = Compiler(n, hold.first, equations.arrays)
    programs = _programs(equations, compiler)
    counts = {name: program.operations for name, program in programs.items()}
    moving = n - hold.first
    size = moving + 2 * hold.translates
    position = _positions(structure)
    scalars = [name for name in position if name != "fin_factor"]
    width = len(position) + (n if "fin_factor" in position else 0)
    provenance = {
        "rodgen": version("rodgen"),
        "sympy": sympy.__version__,
        "template": template,
        "template_hash": template_hash(source),
        "structure_hash": structure.hash,
        "operations": counts,
    }
    constants = compiler.constants
    state_groups = _state_groups(structure, hold.translates, hold.first)
    parameter_groups = [
        f'*(f"fin_factor_{{at}}" for at in range({n + 1}))' if name == "fin_factor" else f'"{name}"'
        for name in position
    ]
    return {
        "title": _title(structure),
        "banner": _banner(provenance),
        "n": n,
        "first": hold.first,
        "held": hold.first > 0,
        "base": 2 * hold.translates,
        "moving": moving,
        "size": size,
        "boundary": structure.boundary,
        "inertia": structure.inertia,
        "terms": structure.terms,
        "terms_text": _tuple(structure.terms),
        "expressions": {name: _expression(text).source() for name, text in structure.expressions},
        "expression_texts": dict(structure.expressions),
        "state_groups": state_groups,
        "state_text": _state_text(structure, hold.translates, hold.first),
        "parameter_groups": parameter_groups,
        "parameter_text": ", ".join(
            f"fin_factor_0 .. fin_factor_{n}" if name == "fin_factor" else name for name in position
        ),
        "position": position,
        "slot": _slots(hold.translates, moving),
        "width": width,
        "signature": [(name, DEFAULTS.get(name)) for name in position],
        "parameter_docs": [(name, PARAMETER_DOCS[name]) for name in position],
        "scalars": scalars,
        "scalar_rules": [(name, RULES.get(name, "any")) for name in scalars],
        "provenance": provenance,
        "constants": constants,
        "constants_text": " ".join(c.code for c in constants),
        "energy_names": [
            "kinetic",
            "spring" if n > 1 else NO_ENERGY,
            "gravity_energy" if "gravity" in structure.terms else NO_ENERGY,
        ],
        "power_names": {name.removeprefix("power_"): name for name in programs["power"].outputs},
        **programs,
    }


def _expression(text: str) -> Expression:
    return Expression(text, "t")


def _tuple(names: tuple[str, ...]) -> str:
    inside = ", ".join(f'"{name}"' for name in names)
    return f"({inside},)" if len(names) == 1 else f"({inside})"


def _acts(term: str, n: int) -> bool:
    """Internal damping acts across inner joints: a single link has none."""
    return term != "internal_damping" or n > 1


def _programs(equations: Equations, compiler: Compiler) -> dict[str, Program]:
    link, hold, n = compiler.link, equations.hold, compiler.links
    quantities = Quantities(equations)
    mass: dict[str, tuple[Domain, Expr]] = {}
    rhs: dict[str, tuple[Domain, Expr]] = {}
    if hold.translates:
        mass["mass_base"] = SCALAR, equations.mass_base
        for axis, entry in zip("xy", equations.mass_base_link, strict=True):
            mass[f"mass_{axis}_link"] = link, entry
        for axis, entry in zip("xy", equations.velocity_base_link, strict=True):
            rhs[f"velocity_{axis}_link"] = link, entry
    mass["mass_link"] = link, equations.mass_link
    if link.count > 1:
        mass["mass_link_link"] = compiler.pair, equations.mass_link_link
        rhs["velocity_link_link"] = compiler.pair, equations.velocity_link_link
    rhs |= _forces(equations, compiler)
    joints = Domain((joint,), 0, n)
    centre = dict(zip(("centre_x", "centre_y"), quantities.centre, strict=True))
    near = dict(zip(("centre_x", "centre_y"), quantities.centre_from_start, strict=True))
    moments = dict(
        zip(("inertia_x", "inertia_y", "product_xy"), quantities.second_moments, strict=True)
    )
    energy = {"kinetic": quantities.kinetic_energy}
    if n > 1:
        energy["spring"] = quantities.spring_energy
    if "gravity" in equations.terms:
        energy["gravity_energy"] = quantities.gravity_energy
    power = {f"power_{term}": e for term, e in quantities.power.items() if _acts(term, n)}
    positions = {str(base): (joints, equations.arrays[base].value) for base in (joint_x, joint_y)}
    return {
        "rhs": compiler.compile(mass | rhs),
        "mass": compiler.compile(mass),
        "energy": compiler.compile(_scalars(energy), batch=True),
        "power": compiler.compile(_scalars(power), batch=True),
        "joints": compiler.compile(positions, batch=True),
        "centre": compiler.compile(_scalars(centre), batch=True),
        "inertia_moments": compiler.compile(_scalars(near | moments), batch=True),
    }


def _forces(equations: Equations, compiler: Compiler) -> dict[str, tuple[Domain, Expr]]:
    """Generalised forces of loads and joints, without those that vanish."""
    out: dict[str, tuple[Domain, Expr]] = {}
    works = equations.works.values()
    if equations.hold.translates:
        for at, axis in enumerate("xy"):
            out[f"force_{axis}"] = SCALAR, _total(work.base[at] for work in works)
    if compiler.links > 1:
        out["link_moment"] = compiler.link, equations.link_moment
    out["force_link"] = compiler.link, _total(work.link for work in works)
    return {name: (domain, e) for name, (domain, e) in out.items() if e != 0}


def _total(parts: Iterable[Expr]) -> Expr:
    return sympy.Add(*parts)


def _scalars(outputs: Mapping[str, Expr]) -> dict[str, tuple[Domain, Expr]]:
    return {name: (SCALAR, e) for name, e in outputs.items()}


def _positions(structure: Structure) -> dict[str, int]:
    return {name: at for at, name in enumerate(structure.parameters)}


def _slots(translates: bool, moving: int) -> dict[str, int]:
    """Where in y the inputs of a program start."""
    if not translates:
        return {"phi": 0, "omega": moving}
    half = 2 + moving
    return {"x0": 0, "y0": 1, "phi": 2, "vx0": half, "vy0": half + 1, "omega": half + 2}


def _state_groups(structure: Structure, translates: bool, first: int) -> list[str]:
    links = f"range({first}, {structure.links})" if first else f"range({structure.links})"
    groups = []
    for base, name in (('"x0", "y0"', "phi"), ('"vx0", "vy0"', "omega")):
        groups += [base] if translates else []
        groups.append(f'*(f"{name}_{{at}}" for at in {links})')
    return groups


def _state_text(structure: Structure, translates: bool, first: int) -> str:
    last = structure.links - 1
    parts = []
    for base, name in (("x0, y0, ", "phi"), ("vx0, vy0, ", "omega")):
        span = f"{name}_{first}" if first == last else f"{name}_{first} .. {name}_{last}"
        parts.append((base if translates else "") + span)
    return ", ".join(parts)


def _title(structure: Structure) -> str:
    links = f"{structure.links} rigid link{'s' if structure.links > 1 else ''}"
    timed = {name.split("_")[0] for name, _ in structure.expressions}
    plain = [term.replace("_", " ") for term in structure.terms]
    words = [f"{word} (a function of t)" if word in timed else word for word in plain]
    terms = ", ".join(words) or "no loads"
    held, mass = DESCRIPTION[structure.boundary], structure.inertia
    return f"Planar rod of {links}, {held}, {mass} mass; {terms}."


def _banner(provenance: Mapping[str, Any]) -> str:
    return (
        f"Generated by rodgen {provenance['rodgen']} with SymPy {provenance['sympy']} "
        f"from the template\n{provenance['template']} ({provenance['template_hash']}); structure "
        f"{provenance['structure_hash']};\n"
        f"rhs: {provenance['operations']['rhs']} operations and a Cholesky solve.\n"
        f"Do not edit; {GUARD} guards the generator byte by byte."
    )
