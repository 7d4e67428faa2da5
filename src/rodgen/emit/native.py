"""The functions of the C target, written."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from rodgen.derive.implicit_form import UNKNOWNS
from rodgen.derive.symbols import i
from rodgen.emit.functions import Functions
from rodgen.emit.loops import Code, LoopWriter
from rodgen.emit.statements import Domain, Outputs, Statement
from rodgen.scene.structure import COLLOCATION
from rodgen.scene.tables import FIXED_STEP

# Methods by their number in a run, and what the functions of a run end with.
METHODS = (*FIXED_STEP, "dop853", *COLLOCATION, "gauss_equal_steps")
STATUSES = {
    "PAUSED": (0, "the quota is used"),
    "REACHED": (1, "the end is reached"),
    "FULL": (2, "all samples are taken"),
    "NOT_FINITE": (-1, "the state or the rates stop being finite"),
    "TOO_SMALL": (-2, "the step becomes too small"),
    "DIVERGED": (-3, "Newton's method finds no solution"),
    "REFUSED": (-4, "no such run: method, times, step or tolerances, or it was not begun"),
}


def native(functions: Functions) -> dict[str, Any]:
    """Code of the functions, and what the templates need of the system."""
    width = functions.axes
    pivots = [f"pivot_{width[r]}{width[c]}" for r, c in functions.pairs]
    ratios = [f"ratio_{r}{c}" for r in width for c in width]
    rhs = _rhs(functions, functions.chain_outputs, ratios)
    flow = _rhs(functions, functions.chain_outputs | functions.power, ratios)
    codes = {
        "rhs": replace(rhs, fields=_united(rhs, flow)),
        "flow": flow,
        "batch": _batch(functions, ratios),
        "newton": _newton(functions),
    }
    codes["jac"], tangents = _jac(functions, pivots)
    return {
        **{f"{name}_code": code for name, code in codes.items()},
        "code_of": codes,
        "methods": METHODS,
        "statuses": {name: number for name, (number, _) in STATUSES.items()},
        "status_texts": {name: text for name, (_, text) in STATUSES.items()},
        "jac_tangents": tangents,
        "newton_made": {*functions.cells, *functions.motion},
        "ends_of": {
            "": list(functions.ends),
            "d_": [name for name in functions.ends if name in tangents],
        },
    }


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
    return given | dict.fromkeys(pivots, Domain((i,), 0, count - 1))


def _links(functions: Functions, names: Iterable[str]) -> dict[str, Domain]:
    """Arrays with a value for every link."""
    return dict.fromkeys(names, Domain((i,), 0, functions.links - 1))


def _rhs(functions: Functions, outputs: Outputs, pivots: Iterable[str]) -> Code:
    program = functions.compiler.analyse(outputs)
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
    common = dict(functions.structure.expressions)
    given = _given(functions, pivots) | _links(functions, ("phi", "omega"))
    if "external_damping" in functions.equations.terms:
        given["fin_factor"] = Domain((i,), 0, functions.links)
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


def _newton(functions: Functions) -> Code:
    """Blocks of the Newton matrix, for given accelerations and joint forces."""
    outputs = functions.cells | functions.motion
    program = functions.compiler.analyse(outputs)
    link = functions.compiler.link
    given = dict.fromkeys(map(str, UNKNOWNS), link)
    if functions.equations.hold.first:
        given |= _links(functions, ("phi", "omega"))
    statements = [st for phase in program.phases for st in phase]
    return LoopWriter(program.analysis, [statements], given, lambda _: False, outputs).code()


def _jac(functions: Functions, pivots: Iterable[str]) -> tuple[Code, list[str]]:
    outputs, tangents, values = functions.derivatives
    program = functions.compiler.analyse(outputs, tangents, values)
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
    return writer.code(), [name for name in tangents if f"d_{name}" in made]
