"""A Structure to the texts of its module: pure, the same bytes everywhere and always."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import sympy
from jinja2 import DictLoader, Environment, StrictUndefined

from rodgen.emit.forces import places
from rodgen.emit.functions import Functions
from rodgen.emit.native import native, segments
from rodgen.emit.statements import PAIR
from rodgen.emit.tableaux import tableaux
from rodgen.progress import EMITTING, tell
from rodgen.scene.expression import Expression
from rodgen.scene.structure import TERM_PARAMETERS, Structure, check_output

# The templates of a module in its target and form: ending of the file, template.
TEMPLATES: dict[tuple[str, str], dict[str, str]] = {
    ("numpy", "chain"): {"py": "numpy_chain.py.jinja"},
    ("numpy", "dense"): {"py": "numpy_dense.py.jinja"},
    ("c", "chain"): {"py": "c.py.jinja", "c": "c.c.jinja", "h": "c.h.jinja"},
}
GUARD = "tests/generated/test_reference_modules.py"

DESCRIPTION = {
    "free": "free in space",
    "cantilever": "held at link 0 (the thesis's clamp)",
    "clamped": "clamped by a root spring",
    "pinned": "pinned at joint 0",
}
RULES = {
    "mass": "positive",
    "length": "positive",
    "bending_stiffness": "at least 0",
    "internal_damping": "at least 0",
    "external_damping": "at least 0",
}
DEFAULTS = {
    "follower_angle": "0.0",
    "clamp_angle": "0.0",
    "gravity": "9.81",
    "fin_factor": "None",
    "tip_force_x": "0.0",
    "tip_force_y": "0.0",
}
PARAMETER_DOCS = {
    "mass": "of the rod [kg]",
    "length": "of the rod [m]",
    "bending_stiffness": "EI [N m^2]",
    "follower_force": "thrust P at the tail [N], compressive for P > 0",
    "follower_angle": "angle nu between thrust and last link [rad]",
    "gravity": "acceleration g [m/s^2], downwards",
    "internal_damping": "c_int [m^2/s]",
    "external_damping": "c_ext [1/s]",
    "clamp_angle": "angle at which the start is held [rad]",
    "tip_force_x": "x component of the dead force at the tail [N]",
    "tip_force_y": "y component of the dead force at the tail [N]",
    "fin_factor": "s at every joint, nose to tail; ones if not given",
}
NO_ENERGY = "np.zeros_like(kinetic)"  # the contract has three energies, whatever the scene


def module_files(
    structure: Structure, target: str = "numpy", form: str = "chain"
) -> dict[str, str]:
    """The texts of a module, by file name; the first is the Python module itself."""
    check_output(target, form)
    environment = Environment(
        loader=DictLoader(_templates()), undefined=StrictUndefined, keep_trailing_newline=True
    )
    templates = TEMPLATES[target, form]
    stem = structure.module_stem(target, form)
    functions = Functions(structure)
    _ = functions.system  # what takes long to derive is kept from here on
    tell(EMITTING)
    context = _context(functions, target, form, next(iter(templates.values())))
    return {
        f"{stem}.{ending}": environment.get_template(template).render(context)
        for ending, template in templates.items()
    }


def module_text(structure: Structure, target: str = "numpy", form: str = "chain") -> str:
    """The text of the Python module of a structure."""
    return next(iter(module_files(structure, target, form).values()))


@cache
def _templates() -> dict[str, str]:
    """All templates by name."""
    folder = files("rodgen.templates")
    names = [f.name for f in folder.iterdir() if f.name.endswith((".jinja", "c_build.py"))]
    return {name: folder.joinpath(name).read_text(encoding="utf-8") for name in sorted(names)}


def template_hash() -> str:
    """Content hash of the templates; they include one another."""
    content = "\0".join(f"{name}\0{text}" for name, text in _templates().items())
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def _context(functions: Functions, target: str, form: str, template: str) -> dict[str, Any]:
    structure = functions.structure
    hold, n = functions.equations.hold, structure.links
    programs = {
        "rhs": functions.dense() if form == "dense" else functions.chain(),
        "jac": functions.jac(),
        "mass": functions.mass(),
        "implicit": functions.implicit(),
        **functions.quantities(),
        "point_force": functions.point_force(),
    }
    acting = places(functions.equations, n)
    provenance = {
        "rodgen": version("rodgen"),
        "sympy": sympy.__version__,
        "target": target,
        "form": form,
        "template": template,
        "template_hash": template_hash(),
        "structure_hash": structure.hash,
        "operations": {name: programs[name].operations for name in sorted(programs)},
    }
    moving = n - hold.first
    return {
        "stem": structure.module_stem(target, form),
        "title": _title(structure),
        "banner": _banner(provenance, form),
        "n": n,
        "first": hold.first,
        "held": hold.first > 0,
        "base": 2 * hold.translates,
        "moving": moving,
        "size": moving + 2 * hold.translates,
        "boundary": structure.boundary,
        "inertia": structure.inertia,
        "terms": structure.terms,
        "terms_text": _tuple(structure.terms),
        "expressions": {name: Expression(text, "t") for name, text in structure.expressions},
        "expression_text": " ".join(
            Expression(text, "t").source("c") for _, text in structure.expressions
        ),
        "slot": _slots(hold.translates, moving),
        "state_places": _places(_slots(hold.translates, moving), hold.first),
        "provenance": provenance,
        "constants": functions.compiler.constants,
        "pairs": [c for c in functions.compiler.constants if c.domain.indices == PAIR],
        "dense": form == "dense",
        "energy_names": [
            "kinetic",
            "spring" if functions.springs else NO_ENERGY,
            "gravity_energy" if "gravity" in structure.terms else NO_ENERGY,
        ],
        "power_names": {name.removeprefix("power_"): name for name in programs["power"].outputs},
        "force_places": acting,
        "force_terms": _tuple(acting),
        "chain": _chain(functions),
        **({**native(functions), "tableaux": tableaux()} if target == "c" else {}),
        "works": list(programs["power"].outputs),
        **_parameters(structure),
        **_state(structure, hold.translates, hold.first),
        **programs,
    }


def _chain(functions: Functions) -> dict[str, Any]:
    """What the chain form solves."""
    domain = functions.solve.domain
    return {
        "width": len(functions.axes),
        "axes": functions.axes,
        "unknowns": functions.solve.unknowns,
        "low": functions.low,
        "count": max(functions.high - functions.low + 1, 0),
        "high": functions.high,
        "given_low": domain.low,
        "given": max(domain.count, 0),
        "ends": list(functions.ends),
        "starts_before": domain.low < functions.low,
        "ends_after": domain.high > functions.high,
        "next_low": functions.low - any(e.startswith("start") for e in functions.ends),
        **segments(functions),
        "couples": any(name.startswith("next") for name in functions.matrix),
    }


def _parameters(structure: Structure) -> dict[str, Any]:
    """What a module says and asks of its parameters."""
    n, names = structure.links, structure.parameters
    fins = f"fin_factor_0 .. fin_factor_{n}"
    scalars = [name for name in names if name != "fin_factor"]
    return {
        "position": {name: at for at, name in enumerate(names)},
        "width": len(names) + (n if "fin_factor" in names else 0),
        "scalars": scalars,
        "scalar_rules": [(name, RULES.get(name, "any")) for name in scalars],
        "divisors": [name for name in scalars if RULES.get(name) == "positive"],
        "signature": [(name, DEFAULTS.get(name)) for name in names],
        "parameter_docs": [(name, PARAMETER_DOCS[name]) for name in names],
        "parameter_text": ", ".join(fins if name == "fin_factor" else name for name in names),
        "parameter_groups": [
            f'*(f"fin_factor_{{at}}" for at in range({n + 1}))'
            if name == "fin_factor"
            else f'"{name}"'
            for name in names
        ],
    }


def _state(structure: Structure, translates: bool, first: int) -> dict[str, Any]:
    """Names of the state, as code and in words."""
    last = structure.links - 1
    links = f"range({first}, {last + 1})" if first else f"range({last + 1})"
    groups: list[str] = []
    words: list[str] = []
    for base, name in ((("x0", "y0"), "phi"), (("vx0", "vy0"), "omega")):
        groups += [", ".join(f'"{b}"' for b in base)] if translates else []
        groups.append(f'*(f"{name}_{{at}}" for at in {links})')
        words += base if translates else ()
        span = f"{name}_{first}" if first == last else f"{name}_{first} .. {name}_{last}"
        words.append(span)
    return {"state_groups": groups, "state_text": ", ".join(words)}


def _places(slots: Mapping[str, int], first: int) -> dict[str, int]:
    """Where in y its numbers are, by name; of the angles and their rates the first."""
    return {
        f"{name}_{first}" if name in ("phi", "omega") else name: at for name, at in slots.items()
    }


def _slots(translates: bool, moving: int) -> dict[str, int]:
    """Where in y the inputs of a program start."""
    if not translates:
        return {"phi": 0, "omega": moving}
    half = 2 + moving
    return {"x0": 0, "y0": 1, "phi": 2, "vx0": half, "vy0": half + 1, "omega": half + 2}


def _tuple(names: Iterable[str]) -> str:
    quoted = [f'"{name}"' for name in names]
    return f"({quoted[0]},)" if len(quoted) == 1 else f"({', '.join(quoted)})"


def _title(structure: Structure) -> str:
    links = f"{structure.links} rigid link{'s' if structure.links > 1 else ''}"
    timed = {name for name, _ in structure.expressions}
    words = [
        term.replace("_", " ") + " (a function of t)" * bool(timed & {*TERM_PARAMETERS[term]})
        for term in structure.terms
    ]
    terms = ", ".join(words) or "no loads"
    held, mass = DESCRIPTION[structure.boundary], structure.inertia
    return f"Planar rod of {links}, {held}, {mass} mass; {terms}."


def _banner(provenance: Mapping[str, Any], form: str) -> str:
    solved = "a Cholesky solve" if form == "dense" else "a solve of the joint forces in O(n)"
    return (
        f"Generated by rodgen {provenance['rodgen']} with SymPy {provenance['sympy']} "
        f"from the template\n{provenance['template']} ({provenance['template_hash']}); structure "
        f"{provenance['structure_hash']};\n"
        f"rhs: {provenance['operations']['rhs']} operations and {solved}.\n"
        f"Do not edit; {GUARD} of rodgen guards the generator byte by byte."
    )
