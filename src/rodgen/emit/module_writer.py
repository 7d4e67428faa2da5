"""Text of the generated module of a Structure: the same bytes everywhere and always."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Mapping
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from typing import Any

import sympy
from jinja2 import DictLoader, Environment, StrictUndefined

from rodgen.emit.forces import force_places
from rodgen.emit.masses import Masses, functions_in_time
from rodgen.emit.outputs import Functions
from rodgen.emit.program import AnalysedFunction
from rodgen.emit.statements import PAIR, Program
from rodgen.emit.targets import TARGETS, check_output, required_parts, target_of
from rodgen.model.rod import CLAMP_ANGLE, NONUNIFORM
from rodgen.model.term import AT_LEAST_ONE, JOINTS, KNOTS, POSITIVE, SIDE, Parameter
from rodgen.model.terms import BASE_ANGLE, TERMS
from rodgen.progress import EMITTING, report_stage
from rodgen.scene.grammar import NUMPY
from rodgen.scene.structure import Structure

GUARD = "tests/reference.py"
# Conditions of the rules that few parameters have.
MORE_RULES = {AT_LEAST_ONE: "number >= 1", SIDE: "abs(number) == 1"}

NO_ENERGY = "np.zeros_like(kinetic)"  # the contract has three energies, whatever the scene


def module_files(
    structure: Structure,
    target: str = "numpy",
    form: str = "chain",
    parts: Iterable[str] | None = None,
    steps: bool = False,
) -> dict[str, str]:
    """The texts of a module, by file name; the first is the Python module itself.

    parts: names of targets.PARTS, and what they need; all that the target has but those of
    targets.ASKED, if not given. steps: whether a C module takes steps, by the loops of native/
    beside it.
    """
    check_output(target, form)
    wanted = required_parts(target, parts, steps)
    templates = target_of(target).templates[form]
    stem = structure.module_stem(target, form)
    functions = Functions(structure)
    _ = functions.system  # what takes long to derive is kept from here on
    report_stage(EMITTING)
    programs, more = target_of(target).programs(functions, form, wanted)
    programs = {**programs, **_programs(functions, wanted)}
    context = {
        **_context(functions, target, form, programs, templates["py"]),
        **more,
        "parts": wanted,
        "steps": steps,
    }
    return {
        f"{stem}.{ending}": _environment().get_template(template).render(context)
        for ending, template in templates.items()
    }


def module_text(structure: Structure, target: str = "numpy", form: str = "chain") -> str:
    """The text of the Python module of a structure."""
    return next(iter(module_files(structure, target, form).values()))


@cache
def _environment() -> Environment:
    """Jinja environment of the templates, each compiled once."""
    return Environment(
        loader=DictLoader(_templates()), undefined=StrictUndefined, keep_trailing_newline=True
    )


@cache
def _templates() -> dict[str, str]:
    """All templates by name."""
    root = files("rodgen.templates")
    folders = {"": root} | {f"{name}/": root.joinpath(name) for name in TARGETS}
    return {
        f"{name}{file.name}": file.read_text(encoding="utf-8")
        for name, folder in sorted(folders.items())
        for file in sorted(folder.iterdir(), key=lambda file: file.name)
        if file.name.endswith(".jinja")
    }


@cache
def template_hash() -> str:
    """Content hash of the templates, which include one another, and of the step loops."""
    native = [f for f in files("rodgen.native").iterdir() if f.name.endswith((".c", ".h"))]
    texts = _templates() | {f.name: f.read_text(encoding="utf-8") for f in native}
    content = "\0".join(f"{name}\0{texts[name]}" for name in sorted(texts))
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def _programs(functions: Functions, parts: Iterable[str]) -> dict[str, Program]:
    """The functions that are NumPy's in every target, by name."""
    programs: dict[str, Program] = {}
    if "mass" in parts:
        programs["mass"] = functions.mass()
    if "balance" in parts:
        programs["balance"] = functions.balance()
    if "implicit" in parts:
        programs["implicit"] = functions.implicit()
    if "power" in parts:
        programs["power"] = functions.power_program()
    if "kinetics" in parts:
        programs |= functions.kinetics()
    if "quantities" in parts:
        programs |= functions.quantities()
        programs["point_force"] = functions.point_force()
    return programs


def _context(
    functions: Functions,
    target: str,
    form: str,
    programs: Mapping[str, Program | AnalysedFunction],
    template: str,
) -> dict[str, Any]:
    structure = functions.structure
    boundary_condition, n = functions.equations.boundary_condition, structure.n_links
    acting = force_places(functions.equations, n) if "forces" in programs else {}
    energies = [st.name for st in programs["energy"].statements] if "energy" in programs else []
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
    moving, in_time = n - boundary_condition.first, functions_in_time(structure)
    laws = (*structure.laws.values(), *structure.open_masses.values())
    texts = structure.open_expressions | structure.open_along
    moved = [e for name, e in texts.items() if name in structure.base_parameters]
    size = moving + 2 * boundary_condition.translates
    added = {name: 2 * size + at for at, name in enumerate(structure.state_names)}
    slots = _input_slots(boundary_condition.translates, moving)
    first = boundary_condition.first
    # Of the angles and of their rates, the number of the first.
    named = {f"{x}_{first}" if x in ("phi", "omega") else x: at for x, at in slots.items()}
    return {
        "stem": structure.module_stem(target, form),
        "title": _title(structure),
        "banner": _banner(provenance, form),
        "n": n,
        "first": first,
        **_time_context(structure),
        "base": 2 * boundary_condition.translates,
        "moving": moving,
        "size": size,
        "states": 2 * size + len(added),
        "added": added,
        "added_rates": structure.open_rates,
        "signal_names": _signal_names(functions),
        "input_names": functions.input_names,
        "input_text": _tuple_code(functions.input_names),
        "measured": {
            name: max(over.count, 0) if over.indices else 0
            for name, (over, _) in functions.measures.items()
        },
        "contact_names": functions.contacts,
        "air_names": functions.air,
        "cubic": any(e.has_cubic for e in (*texts.values(), *laws)),
        "tables": any(e.has_table for e in (*laws, *moved)),
        "bends": any(e.has_table for e in moved),
        "boundary": structure.boundary,
        "inertia": structure.inertia,
        "terms": structure.terms,
        "terms_text": _tuple_code(structure.terms),
        "nonuniform_text": _tuple_code(structure.nonuniform) if structure.nonuniform else "",
        "spring": structure.spring,
        "expressions": structure.open_expressions,
        "table_rows": dict(structure.tables),
        "sensor_places": structure.sensor_places,
        "texts": texts,
        "slot": slots,
        "state_places": named | added,
        "provenance": provenance,
        "constants": functions.compiler.constants,
        "pairs": [c for c in functions.compiler.constants if c.domain.indices == PAIR],
        "dense": form == "dense",
        "heavy": functions.equations.rod.has_link_masses,
        "anchored": functions.equations.has_position_loads,
        "energy_names": [
            name if name in energies else NO_ENERGY for name in ("kinetic", "spring", "load_energy")
        ],
        "power_names": {name.removeprefix("power_"): name for name in functions.power},
        "force_places": acting,
        "force_terms": _tuple_code(acting),
        "chain": _chain_context(functions),
        **_parameter_context(structure),
        "in_time_text": _tuple_code(in_time),
        "in_time": _TimeArguments(dict.fromkeys(in_time, ", t")),
        **_state_context(structure, boundary_condition.translates, first),
        **programs,
    }


def _signal_names(functions: Functions) -> dict[str, str]:
    """Variables of the computed signals, by the text that a scene has for each."""
    named = {
        of.text: str(symbol)
        for of, symbol in functions.laws.sensor_symbols.items()
        if of in functions.structure.sensors
    }
    named |= functions.laws.push_names
    return named | {str(symbol): str(symbol) for symbol in functions.laws.inputs}


def _chain_context(functions: Functions) -> dict[str, Any]:
    """Template context of the system that the chain form solves."""
    domain = functions.solve.domain
    return {
        "width": len(functions.axes),
        "axes": functions.axes,
        "unknowns": functions.solve.unknowns,
        "unknown_of": dict(zip(functions.axes, functions.solve.unknowns, strict=True)),
        "low": functions.low,
        "count": max(functions.high - functions.low + 1, 0),
        "high": functions.high,
        "given_low": domain.low,
        "given": max(domain.count, 0),
        "ends": list(functions.ends),
        "starts_before": domain.low < functions.low,
        "ends_after": domain.high > functions.high,
        "next_low": functions.low - any(e.startswith("start") for e in functions.ends),
        "lower": "next_yx" if "next_yx" in functions.matrix else "next_xy",
        "couples": any(name.startswith("next") for name in functions.matrix),
    }


class _TimeArguments(dict[str, str]):
    """Text of the argument t of the functions that have it, by name; of others none."""

    def __missing__(self, name: str) -> str:
        return ""


def _time_context(structure: Structure) -> dict[str, Any]:
    """Template context of what changes with time, and of a held link: numbers that add up to its
    angle and to its rate; which numbers a function needs that reads some names."""
    numbers = Masses(structure).context(NUMPY)
    turns = BASE_ANGLE if BASE_ANGLE in structure.base_parameters else ""
    held = {"phi": [CLAMP_ANGLE.name, turns], "omega": [f"{turns}_rate" if turns else ""]}
    held = {array: list(filter(None, names)) for array, names in held.items()}
    held = held if structure.boundary_condition.first else {}

    def needs(name: str, reads: Collection[str]) -> bool:
        return name in reads or any(name in of and array in reads for array, of in held.items())

    def follows_time(reads: Collection[str]) -> bool:
        timed = (*structure.open_expressions, *numbers["clocked"])
        return any(needs(name, reads) for name in timed)

    own: dict[str, Any] = {"held": held, "held_moves": bool(turns)}
    own["by_rates"] = _tuple_code(["power"]) if structure.base_parameters else ""
    return {**numbers, **own, "needed": needs, "follows_time": follows_time}


def _parameter_context(structure: Structure) -> dict[str, Any]:
    """Template context of the parameters: places in p, rules, defaults and documentation."""
    spans, places = structure.index_ranges, structure.slices
    rows = structure.rows
    single = [one for one in rows if not one.is_array]
    width = structure.width
    return {
        "position": structure.indices,
        "places": places,
        "first_positions": {
            f"{name}_{spans[name].start}" if name in spans else name: place.start
            for name, place in places.items()
            if place.start < width
        },
        "width": width,
        "arrays": [
            _array_context(one, spans[one.name], places[one.name]) for one in rows if one.is_array
        ],
        "scalars": [one.name for one in single],
        "more_rules": {rule: MORE_RULES[rule] for one in rows if (rule := one.rule) in MORE_RULES},
        "scalar_rules": [(one.name, one.rule) for one in single],
        "divisors": [one.name for one in single if one.rule == POSITIVE],
        "signature": [(one.name, _default_code(one)) for one in rows],
        "parameter_docs": [(one.name, _parameter_doc(one)) for one in rows],
        "parameter_text": ", ".join(_name_range(one.name, spans.get(one.name)) for one in rows),
        "parameter_groups": [
            f'*(f"{one.name}_{{at}}" for at in {_range_code(spans[one.name])})'
            if one.is_array
            else f'"{one.name}"'
            for one in rows
        ],
    }


def _array_context(parameter: Parameter, span: range, place: slice) -> dict[str, Any]:
    """Template context of a parameter of several numbers: its place in p, number and rule."""
    return {
        "name": parameter.name,
        "start": place.start,
        "slice": f"{place.start}:{place.stop}",
        "first": span.start,
        "count": len(span),
        "number": "N + 1" if parameter.each == JOINTS else str(len(span)),
        "rule": parameter.rule,
        "each": f"one for every {parameter.each}",
        "table": parameter.each == KNOTS,
        "default": parameter.default,
    }


def _name_range(name: str, span: range | None) -> str:
    """A name, or the first and the last of several that are numbered."""
    if span is None:
        return name
    ends = [f"{name}_{at}" for at in (span.start, span.stop - 1)]
    return " .. ".join(ends) if len(span) > 1 else ends[0] if span else f"no {name}"


def _range_code(span: range) -> str:
    """The code of a range."""
    return f"range({span.start}, {span.stop})" if span.start else f"range({span.stop})"


def _parameter_doc(parameter: Parameter) -> str:
    if not parameter.is_array or parameter.default is None:
        return parameter.documentation
    return f"{parameter.documentation}; {parameter.default:g} everywhere if not given"


def _default_code(parameter: Parameter) -> str | None:
    """The default of an argument, as code; None where it has to be given."""
    if parameter.default is None:
        return None
    return "None" if parameter.is_array else repr(parameter.default)


def _state_context(structure: Structure, translates: bool, first: int) -> dict[str, Any]:
    """Template context of the state: its names, as code and in words."""
    last = structure.n_links - 1
    links = _range_code(range(first, last + 1))
    groups: list[str] = []
    words: list[str] = []
    for base, name in ((("x0", "y0"), "phi"), (("vx0", "vy0"), "omega")):
        groups += [", ".join(f'"{b}"' for b in base)] if translates else []
        groups.append(f'*(f"{name}_{{at}}" for at in {links})')
        words += base if translates else ()
        words.append(_name_range(name, range(first, last + 1)))
    groups += [f'"{name}"' for name in structure.state_names]
    words += structure.state_names
    return {"state_groups": groups, "state_text": ", ".join(words)}


def _input_slots(translates: bool, moving: int) -> dict[str, int]:
    """Index in y at which each input of a program starts."""
    if not translates:
        return {"phi": 0, "omega": moving}
    half = 2 + moving
    return {"x0": 0, "y0": 1, "phi": 2, "vx0": half, "vy0": half + 1, "omega": half + 2}


def _tuple_code(names: Iterable[str]) -> str:
    quoted = [f'"{name}"' for name in names]
    return f"({quoted[0]},)" if len(quoted) == 1 else f"({', '.join(quoted)})"


def _title(structure: Structure) -> str:
    links = f"{structure.n_links} rigid link{'s' if structure.n_links > 1 else ''}"
    timed = {name for name, _ in structure.expressions}
    rows = [TERMS[name] for name in structure.loads]
    fed = structure.laws.keys()
    words = [
        row.words
        + " (a function of t)" * any(one.name in timed - fed for one in row.parameters)
        + " (follows the motion)" * any(one.name in fed for one in row.parameters)
        for row in rows
    ]
    terms = ", ".join(words) or "no loads"
    held, mass = structure.boundary_condition.title, structure.inertia
    nonuniform = "".join(f", {NONUNIFORM[what].title}" for what in structure.nonuniform)
    nonuniform += f", springs of the moment {structure.spring}" * bool(structure.spring)
    added = f"; with {', '.join(structure.state_names)}" if structure.states else ""
    return f"Planar rod of {links}, {held}, {mass} mass{nonuniform}; {terms}{added}."


def _banner(provenance: Mapping[str, Any], form: str) -> str:
    solved = "a Cholesky solve" if form == "dense" else "a solve of the joint forces in O(n)"
    operations = provenance["operations"].get("rhs")
    cost = f";\nrhs: {operations} operations and {solved}" if operations is not None else ""
    return (
        f"Generated by rodgen {provenance['rodgen']} with SymPy {provenance['sympy']} "
        f"from the template\n{provenance['template']} ({provenance['template_hash']}); structure "
        f"{provenance['structure_hash']}"
        f"{cost}.\n"
        f"Do not edit; {GUARD} of rodgen guards the generator byte by byte."
    )
