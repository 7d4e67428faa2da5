"""The functions of the C target, written."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from itertools import chain
from typing import Any

from rodgen.derive.implicit_form import UNKNOWNS
from rodgen.derive.symbols import i
from rodgen.emit.c import lanes
from rodgen.emit.c.language import SCENE
from rodgen.emit.c.writer import Code, LoopWriter
from rodgen.emit.functions import Functions
from rodgen.emit.masses import Masses
from rodgen.emit.program import Analysed
from rodgen.emit.statements import Domain, Outputs, Statement
from rodgen.model.methods import COMPILED
from rodgen.native.many import LANES
from rodgen.native.run import STATUSES


def programs(
    functions: Functions, form: str, parts: Collection[str]
) -> tuple[dict[str, Analysed], dict[str, Any]]:
    """The functions of a module that are of this target alone, by name, and what else its
    templates need: the code of every part and what the system is like."""
    _ = form  # there is one
    width = functions.axes
    pivots = [f"pivot_{width[r]}{width[c]}" for r, c in functions.pairs]
    ratios = [f"ratio_{r}{c}" for r in width for c in width]
    analysed: dict[str, Analysed] = {}
    codes: dict[str, Code] = {}
    more: dict[str, Any] = {"tangents_made": []}
    outputs = {"rhs": functions.chain_outputs, "flow": functions.chain_outputs | functions.power}
    for part in (part for part in outputs if part in parts):
        analysed[part] = functions.compiler.analyse(outputs[part])
        codes[part] = _rhs(functions, analysed[part], outputs[part], ratios)
    if "batch" in parts:
        codes["batch"] = _batch(functions, ratios)
    if "lanes" in parts:
        masses_in_time = Masses(functions.structure).of_links(SCENE)
        links = _links(functions, ("phi", "omega", *masses_in_time))
        codes |= lanes.codes(functions, links, _given(functions, ratios))
        more |= lanes.context(functions)
    values = functions.derivatives[2]
    motion = [*functions.rates, *functions.added, *functions.power]
    for part, wanted in {"jac": values, "tangents": [*values, *motion]}.items():
        if part in parts:
            made = _directions(functions, wanted, [*pivots, *ratios])
            codes[part], analysed[part], more["tangents_made"] = made
    if "newton" in parts:
        codes["newton"] = _newton(functions)
    rates = [codes[part] for part in ("rhs", "flow") if part in codes]
    if rates:
        codes["rates"] = replace(rates[0], fields=_united(*rates))
    structure = functions.structure
    places = structure.places
    expressions = {name: e for name, e in structure.open_expressions.items() if not e.signals}
    timed = {name: e.source(SCENE, places) for name, e in expressions.items()}
    masses = Masses(structure)
    timed |= masses.of_bodies(SCENE)
    by_rod = masses.of_bodies(SCENE, lanes.BY_ROD)
    link_masses = masses.of_links(SCENE)
    more |= {
        "code_of": codes,
        "link_masses_c": link_masses,
        "works": list(functions.power),
        "newton_made": {*functions.newton.outputs} if "newton" in parts else (),
        "border": _border(functions) if functions.structure.laws else None,
        "timed": timed,
        # Of each rod by itself: expressions whose numbers are parameters.
        "timed_by_rod": {
            name: e.source(SCENE, places, lanes.BY_ROD)
            for name, e in expressions.items()
            if e.names
        }
        | by_rod,
        "lane_count": LANES,
        "called": _called(
            chain(timed.values(), link_masses.values(), *(code.lines for code in codes.values()))
        ),
        "dragged": functions.equations.dragged,
        "anchored": functions.equations.anchored,
        "sums": any(
            loop.sums
            for name, code in codes.items()
            if name not in lanes.SIDE_BY_SIDE
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


def _called(lines: Iterable[str]) -> set[str]:
    """Functions that some lines call."""
    return {name for line in lines for name in re.findall(r"\w+(?=\()", line)}


def _united(*codes: Code) -> tuple[tuple[str, int, bool], ...]:
    """Arrays for several functions in one memory."""
    fields: dict[str, tuple[str, int, bool]] = {}
    for code in codes:
        for name, count, laned in code.fields:
            before = fields.get(name, (name, 0, laned))
            fields[name] = name, max(count, before[1]), laned
    return tuple(fields.values())


def segments(functions: Functions) -> dict[str, int]:
    """Into how many segments of how many rows the system is cut (1: it is not), and with how many
    elements before the first coupling its arrays begin.

    Fewer rows are faster one by one: measured, see benchmarks/.
    """
    count = functions.high - functions.low + 1
    number = 1 if len(functions.axes) == 1 or count < 9 else 4 if count < 28 else 8
    before = any(name.startswith("start") for name in functions.ends)
    return {"segments": number, "rows": count // number + 1, "next_lead": 0 if before else 1}


def _padding(functions: Functions) -> dict[str, tuple[int, int]]:
    """Elements before the first and lengths of the arrays of a system that is cut."""
    cut = segments(functions)
    if cut["segments"] == 1:
        return {}
    length = cut["segments"] * cut["rows"]
    names = [*functions.matrix, *functions.right]
    return {
        name: (cut["next_lead"] if name.startswith("next") else 1, length + 1) for name in names
    }


def _given(functions: Functions, pivots: Iterable[str]) -> dict[str, Domain]:
    """Arrays that solving fills."""
    count = max(functions.high - functions.low + 1, 0)
    given = dict.fromkeys(functions.solve.unknowns, functions.solve.domain)
    given |= _links(functions, Masses(functions.structure).of_links(SCENE))
    return given | dict.fromkeys(pivots, Domain((i,), 0, count - 1))


def _links(functions: Functions, names: Iterable[str]) -> dict[str, Domain]:
    """Arrays with a value for every link."""
    return dict.fromkeys(names, Domain((i,), 0, functions.links - 1))


def _rhs(functions: Functions, program: Analysed, outputs: Outputs, pivots: Iterable[str]) -> Code:
    given = _given(functions, pivots)
    if functions.equations.hold.first:
        given |= _links(functions, ("phi", "omega"))
    cut = segments(functions)
    padding = _padding(functions)
    if padding:  # solved in segments, without pivots of its own
        given = {name: domain for name, domain in given.items() if name not in set(pivots)}
        length = cut["segments"] * cut["rows"] + 1
        padding |= dict.fromkeys(functions.solve.unknowns, (0, length))
    keep = [*outputs]
    system = [] if padding else [*functions.matrix, *functions.right]
    writer = LoopWriter(
        program.analysis, program.phases[:2], given, lambda _: False, keep, padding, system
    )
    return writer.code()


def _batch(functions: Functions, pivots: Iterable[str]) -> Code:
    program = functions.compiler.analyse(functions.chain_outputs)
    expressions = functions.structure.open_expressions.items()
    common = {name for name, e in expressions if not (e.names or e.signals)}
    given = _given(functions, pivots) | _links(functions, ("phi", "omega")) | functions.given
    keep = [*functions.chain_outputs]
    writer = LoopWriter(
        program.analysis,
        program.phases[:2],
        given,
        lambda name: name not in common,
        keep,
        system=[*functions.matrix, *functions.right],
    )
    return writer.code()


def _border(functions: Functions) -> dict[str, Any]:
    """The border of a Newton matrix: how many numbers of the loads follow the motion, of each law
    its derivatives by sensors and states, and of each sensor what it follows: places in y, and
    derivatives by so many angles and rates."""
    laws, structure = functions.laws, functions.structure
    first, moving = functions.compiler.link.low, functions.compiler.link.count
    base = 2 * functions.equations.hold.translates
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
    gains = laws.gains.items()
    numbered = [(names.index(of), signals.index(by), str(gain)) for gain, (of, by, _) in gains]
    return {"inputs": len(laws.inputs), "laws": len(names), "gains": numbered, "sensors": sensors}


def _newton(functions: Functions) -> Code:
    """Blocks of the Newton matrix, for given accelerations and joint forces."""
    outputs = functions.newton.outputs
    program = functions.compiler.analyse(outputs)
    link = functions.compiler.link
    given = dict.fromkeys(map(str, UNKNOWNS), link)
    given |= _links(functions, Masses(functions.structure).of_links(SCENE))
    if functions.equations.hold.first:
        given |= _links(functions, ("phi", "omega"))
    statements = [st for phase in program.phases for st in phase]
    return LoopWriter(program.analysis, [statements], given, lambda _: False, outputs).code()


def _directions(
    functions: Functions, values: Collection[str], pivots: Iterable[str]
) -> tuple[Code, Analysed, list[str]]:
    """Values at a state, and tangents in many directions; what has one."""
    outputs, tangents, _ = functions.derivatives
    program = functions.compiler.analyse(outputs | functions.power, tangents, values)
    made = [st.name for phase in program.phases for st in phase]
    given = _given(functions, pivots)
    if functions.equations.hold.first:
        given |= _links(functions, ("phi", "omega"))
    links = _links(functions, ("d_phi", "d_omega"))
    unknowns = functions.solve.unknowns
    given |= links | {f"d_{name}": functions.solve.domain for name in unknowns}
    keep = [*values, *(f"d_{name}" for name in tangents)]
    before, after, last = program.phases

    def split(phase: Iterable[Statement], tangent: bool) -> list[Statement]:
        return [st for st in phase if st.domain.tangent == tangent]

    phases = [
        split(before, False),
        split(after, False),
        split(before, True) + split(after, True),
        list(last),
    ]

    def laned(name: str) -> bool:
        st = program.analysis.statements.get(name)
        return st.domain.tangent if st is not None else name.startswith("d_")

    writer = LoopWriter(program.analysis, phases, given, laned, keep)
    return writer.code(), program, [name for name in tangents if f"d_{name}" in made]
