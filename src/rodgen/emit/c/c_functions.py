"""Functions of the C target as code."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from itertools import chain
from typing import Any

from rodgen.derive.implicit_form import UNKNOWNS
from rodgen.derive.symbols import i
from rodgen.emit.c import lane_functions
from rodgen.emit.c.loop_writer import SCENE, Code, LoopWriter
from rodgen.emit.masses import Masses
from rodgen.emit.outputs import Functions
from rodgen.emit.program import AnalysedFunction
from rodgen.emit.statements import Domain, Outputs, Statement
from rodgen.model.methods import COMPILED
from rodgen.native.native_batch import LANES
from rodgen.native.native_run import STATUSES


def programs(
    functions: Functions, form: str, parts: Collection[str]
) -> tuple[dict[str, AnalysedFunction], dict[str, Any]]:
    """Functions of a module that are of this target alone, by name, and the rest of the template
    context: code of every part and properties of the system."""
    _ = form  # there is one
    width = functions.axes
    pivots = [f"pivot_{width[r]}{width[c]}" for r, c in functions.pairs]
    ratios = [f"ratio_{r}{c}" for r in width for c in width]
    analysed: dict[str, AnalysedFunction] = {}
    codes: dict[str, Code] = {}
    more: dict[str, Any] = {"tangents_made": []}
    structure, masses = functions.structure, Masses(functions.structure)
    places, link_masses = structure.slices, masses.link_codes(SCENE)
    outputs = {"rhs": functions.chain_outputs, "flow": functions.chain_outputs | functions.power}
    for part in (part for part in outputs if part in parts):
        analysed[part] = functions.compiler.analyse(outputs[part])
        codes[part] = _rhs_code(functions, analysed[part], outputs[part], ratios)
    if "batch" in parts:
        codes["batch"] = _batch_code(functions, ratios)
    if "lanes" in parts:
        links = _link_arrays(functions, ("phi", "omega", *link_masses))
        codes |= lane_functions.lane_codes(functions, links, _solution_arrays(functions, ratios))
        more |= lane_functions.lane_context(functions)
    values = functions.derivatives[2]
    motion = [*functions.rates, *functions.state_rates, *functions.power]
    for part, wanted in {"jac": values, "tangents": [*values, *motion]}.items():
        if part in parts:
            made = _tangent_code(functions, wanted, [*pivots, *ratios])
            codes[part], analysed[part], more["tangents_made"] = made
    if "newton" in parts:
        codes["newton"] = _newton_code(functions)
    rates = [codes[part] for part in ("rhs", "flow") if part in codes]
    if rates:
        codes["rates"] = replace(rates[0], fields=_merge_fields(*rates))
    expressions = {name: e for name, e in structure.open_expressions.items() if not e.signals}
    timed = {name: e.source(SCENE, places) for name, e in expressions.items()}
    timed |= masses.number_codes(SCENE)
    by_rod = masses.number_codes(SCENE, lane_functions.BY_ROD)
    more |= {
        "code_of": codes,
        "link_masses_c": link_masses,
        "works": list(functions.power),
        "newton_made": {*functions.newton.outputs} if "newton" in parts else (),
        "border": _border_context(functions) if structure.laws else None,
        "timed": timed,
        # Of each rod by itself: expressions whose numbers are parameters.
        "timed_by_rod": {
            name: e.source(SCENE, places, lane_functions.BY_ROD)
            for name, e in expressions.items()
            if e.names
        }
        | by_rod,
        "lane_count": LANES,
        "called": _called_functions(
            chain(timed.values(), link_masses.values(), *(code.lines for code in codes.values()))
        ),
        "dragged": functions.equations.has_velocity_loads,
        "anchored": functions.equations.has_position_loads,
        "sums": any(
            loop.has_total
            for name, code in codes.items()
            if name not in lane_functions.SIDE_BY_SIDE
            for phase in code.phases
            for loop in phase
        ),
        "ends_of": {
            "": list(functions.ends),
            "d_": [name for name in functions.ends if name in more["tangents_made"]],
        },
        "cut": segments(functions),
        "methods": COMPILED,
        "statuses": STATUSES,
    }
    return {name: of for name, of in analysed.items() if name in ("rhs", "jac", "tangents")}, more


def _called_functions(lines: Iterable[str]) -> set[str]:
    """Names of the functions that some lines call."""
    return {name for line in lines for name in re.findall(r"\w+(?=\()", line)}


def _merge_fields(*codes: Code) -> tuple[tuple[str, int, bool], ...]:
    """Arrays of several functions in one memory, each with its largest length."""
    fields: dict[str, tuple[str, int, bool]] = {}
    for code in codes:
        for name, count, laned in code.fields:
            before = fields.get(name, (name, 0, laned))
            fields[name] = name, max(count, before[1]), laned
    return tuple(fields.values())


def segments(functions: Functions) -> dict[str, int]:
    """Numbers of segments into which the system is cut (1: it is not) and of their rows, and of
    elements before the first coupling in its arrays.

    Fewer rows are faster one by one: measured, see benchmarks/.
    """
    count = functions.high - functions.low + 1
    number = 1 if len(functions.axes) == 1 or count < 9 else 4 if count < 28 else 8
    before = any(name.startswith("start") for name in functions.ends)
    return {"segments": number, "rows": count // number + 1, "next_lead": 0 if before else 1}


def _padding(functions: Functions) -> dict[str, tuple[int, int]]:
    """For each array of a system that is cut, the elements before its first, and its length."""
    cut = segments(functions)
    if cut["segments"] == 1:
        return {}
    length = cut["segments"] * cut["rows"]
    names = [*functions.matrix, *functions.right]
    return {
        name: (cut["next_lead"] if name.startswith("next") else 1, length + 1) for name in names
    }


def _solution_arrays(functions: Functions, pivots: Iterable[str]) -> dict[str, Domain]:
    """Arrays that the solution of the system fills, with their ranges."""
    count = max(functions.high - functions.low + 1, 0)
    given = dict.fromkeys(functions.solve.unknowns, functions.solve.domain)
    given |= _link_arrays(functions, Masses(functions.structure).link_codes(SCENE))
    return given | dict.fromkeys(pivots, Domain((i,), 0, count - 1))


def _link_arrays(functions: Functions, names: Iterable[str]) -> dict[str, Domain]:
    """Arrays with a value for every link."""
    return dict.fromkeys(names, Domain((i,), 0, functions.n_links - 1))


def _held_arrays(functions: Functions) -> dict[str, Domain]:
    """Arrays of the angles and rates of all links, where some are held."""
    names = ("phi", "omega") if functions.equations.boundary_condition.first else ()
    return _link_arrays(functions, names)


def _rhs_code(
    functions: Functions, program: AnalysedFunction, outputs: Outputs, pivots: Iterable[str]
) -> Code:
    given = _solution_arrays(functions, pivots) | _held_arrays(functions)
    cut = segments(functions)
    padding = _padding(functions)
    if padding:  # solved in segments, without pivots of its own
        given = {name: domain for name, domain in given.items() if name not in set(pivots)}
        length = cut["segments"] * cut["rows"] + 1
        padding |= dict.fromkeys(functions.solve.unknowns, (0, length))
    system = [] if padding else [*functions.matrix, *functions.right]
    writer = LoopWriter(
        program.analysis, program.phases[:2], given, lambda _: False, outputs, padding, system
    )
    return writer.write()


def _batch_code(functions: Functions, pivots: Iterable[str]) -> Code:
    program = functions.compiler.analyse(functions.chain_outputs)
    expressions = functions.structure.open_expressions.items()
    common = {name for name, e in expressions if not (e.names or e.signals)}
    given = (
        _solution_arrays(functions, pivots)
        | _link_arrays(functions, ("phi", "omega"))
        | functions.parameter_domains
    )
    writer = LoopWriter(
        program.analysis,
        program.phases[:2],
        given,
        lambda name: name not in common,
        functions.chain_outputs,
        system=[*functions.matrix, *functions.right],
    )
    return writer.write()


def _border_context(functions: Functions) -> dict[str, Any]:
    """Border of a Newton matrix: numbers of the loads that follow the motion, derivatives of each
    law by sensors and states, and for each sensor its places in y, or derivatives by a number of
    angles and rates."""
    laws, structure = functions.laws, functions.structure
    first, moving = functions.compiler.link.low, functions.compiler.link.count
    base = 2 * functions.equations.boundary_condition.translates
    half, sensors, border = moving + base, [], functions.newton.border
    for at, (sensor, point) in enumerate(laws.points):
        turn = point.link - first
        single = {} if point.held else {"phi": base + turn, "omega": half + base + turn}
        single |= {"x": 0, "y": 1, "vx": half, "vy": half + 1} if base else {}
        arrays = {f"sensed_{kind}_{at}": low for kind, low in (("angle", 0), ("rate", half))}
        sensors.append(
            {
                "single": single.get(sensor.what),
                "arrays": {k: base + low for k, low in arrays.items() if k in border},
                "count": turn + 1,
            }
        )
    names = list(structure.laws)
    signals = [*laws.sensors, *laws.states]
    gains = laws.seen_gains.items()
    numbered = [(names.index(of), signals.index(by), str(gain)) for gain, (of, by, _) in gains]
    return {"inputs": len(laws.inputs), "laws": len(names), "gains": numbered, "sensors": sensors}


def _newton_code(functions: Functions) -> Code:
    """Blocks of the Newton matrix, for given accelerations and joint forces."""
    outputs = functions.newton.outputs
    program = functions.compiler.analyse(outputs)
    link = functions.compiler.link
    given = dict.fromkeys(map(str, UNKNOWNS), link)
    given |= _link_arrays(functions, Masses(functions.structure).link_codes(SCENE))
    given |= _held_arrays(functions)
    statements = [st for phase in program.phases for st in phase]
    return LoopWriter(program.analysis, [statements], given, lambda _: False, outputs).write()


def _tangent_code(
    functions: Functions, values: Collection[str], pivots: Iterable[str]
) -> tuple[Code, AnalysedFunction, list[str]]:
    """Code of values and of tangents in many directions; its program; outputs with a tangent."""
    outputs, tangents, _ = functions.derivatives
    program = functions.compiler.analyse(outputs | functions.power, tangents, values)
    made = [st.name for phase in program.phases for st in phase]
    given = _solution_arrays(functions, pivots) | _held_arrays(functions)
    links = _link_arrays(functions, ("d_phi", "d_omega"))
    unknowns = functions.solve.unknowns
    given |= links | {f"d_{name}": functions.solve.domain for name in unknowns}
    keep = [*values, *(f"d_{name}" for name in tangents)]
    before, after, last = program.phases

    def select(phase: Iterable[Statement], tangent: bool) -> list[Statement]:
        return [st for st in phase if st.domain.is_tangent == tangent]

    phases = [
        select(before, False),
        select(after, False),
        select(before, True) + select(after, True),
        list(last),
    ]

    def has_lanes(name: str) -> bool:
        st = program.analysis.statements.get(name)
        return st.domain.is_tangent if st is not None else name.startswith("d_")

    writer = LoopWriter(program.analysis, phases, given, has_lanes, keep)
    return writer.write(), program, [name for name in tangents if f"d_{name}" in made]
