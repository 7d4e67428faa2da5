"""Functions of a module as programs: analysed, put in order and cut into phases."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from sympy import Expr, IndexedBase, Symbol

from rodgen.derive.symbols import Array, i
from rodgen.emit.analysis import Analysis
from rodgen.emit.numpy.array_writer import ArrayWriter
from rodgen.emit.statements import PAIR, Constant, Domain, Outputs, Program, Statement


@dataclass(frozen=True)
class Solve:
    """Solution of a system within a function: names of the unknowns, and their range."""

    unknowns: tuple[str, ...] = ()
    domain: Domain = field(default=Domain())

    @property
    def names(self) -> tuple[set[str], set[str]]:
        """Names that are known after each solution: the unknowns, then their tangents."""
        return set(self.unknowns), {f"d_{name}" for name in self.unknowns}


@dataclass(frozen=True)
class AnalysedFunction:
    """A function, analysed: its analysis, its statements, those of each phase without mere terms of
    a sum, and operations of one evaluation."""

    analysis: Analysis
    statements: list[Statement]
    phases: tuple[tuple[Statement, ...], ...]
    operations: int


class Compiler:
    """Compiles the functions of one structure; constants are shared by all of them."""

    def __init__(
        self,
        links: int,
        first: int,
        arrays: Mapping[IndexedBase, Array],
        solve: Solve,
        parameters: Mapping[str, Domain],
        numbers: Mapping[Symbol, Expr],
        clocked: Collection[str] = (),
    ):
        """clocked: numbers that follow the time."""
        self.links, self.arrays, self.solve, self.parameters = links, arrays, solve, parameters
        self.numbers, self.clocked = numbers, clocked
        self.link = Domain((i,), first, links - 1)
        self.pair = Domain(PAIR, first, links - 1)
        self._constants: dict[tuple[Expr, Domain], Constant] = {}

    @property
    def constants(self) -> list[Constant]:
        """Constants of the functions compiled so far."""
        return list(self._constants.values())

    def analyse(
        self,
        outputs: Outputs,
        tangents: Mapping[str, frozenset[str]] | None = None,
        values: Iterable[str] | None = None,
        by: Collection[str] | None = None,
    ) -> AnalysedFunction:
        """The statements of a function in phases, not written yet.

        tangents: outputs whose tangent is wanted; values: those whose value is (all, if not
        given); by: numbers that tangents are by (the state, if not given).
        """
        known = self._constants, self.parameters, self.numbers
        analysis = Analysis(self.links, self.link, self.arrays, *known)
        wanted = outputs if values is None else values
        statements = analysis.run(outputs, tangents or {}, wanted, by)
        summed = {st.terms.name for st in statements if st.terms}
        kept = [st for st in statements if st.name not in summed]
        given = [*wanted, *(f"d_{name}" for name in tangents or ())]
        cost = sum(st.operations() for st in statements)
        return AnalysedFunction(analysis, statements, self._phases(analysis, kept, given), cost)

    def compile(
        self,
        outputs: Outputs,
        batch: bool = False,
        tangents: Mapping[str, frozenset[str]] | None = None,
        values: Iterable[str] | None = None,
        given: Mapping[str, Domain] | None = None,
        writer: type[ArrayWriter] = ArrayWriter,
        by: Collection[str] | None = None,
    ) -> Program:
        """The statements of a function, written for NumPy or, in targets of extensions, by another
        writer; batch: for states along leading axes; given: arrays from outside that do not start
        at link 0, in place of the unknowns; tangents, values, by: as in analyse."""
        analysed = self.analyse(outputs, tangents, values, by)
        analysis, statements = analysed.analysis, analysed.statements
        given = given or dict.fromkeys(self.solve.unknowns, self.solve.domain)
        written = writer(analysis, statements, batch, given, self.clocked)
        for statement in statements:
            written.write(statement)
        reads = set().union(*map(analysis.uses, statements)) if statements else set()
        made = {st.name for st in statements} | {c.name for c in self.constants}
        kept = [st for phase in analysed.phases for st in phase]
        return Program(
            kept, tuple(outputs), frozenset(reads - made), analysed.operations, analysed.phases
        )

    def _phases(
        self, analysis: Analysis, statements: list[Statement], outputs: Iterable[str]
    ) -> tuple[tuple[Statement, ...], ...]:
        """Statements before any solution, after the first, and after that of the tangents."""
        used: dict[str, set[str]] = {}
        phase_of: dict[str, int] = {}
        for at, names in enumerate(self.solve.names, start=1):
            phase_of |= dict.fromkeys(names, at)
        for st in statements:
            uses = set(analysis.uses(st))
            if st.terms is not None:
                uses |= analysis.uses(st.terms)
            phase_of[st.name] = max((phase_of.get(name, 0) for name in uses), default=0)
            used[st.name] = uses
        # As late as what reads it allows: less is kept over a solution.
        needed = {name: phase_of[name] for name in outputs if name in used}
        for st in reversed(statements):
            phase = phase_of[st.name] = needed.get(st.name, phase_of[st.name])
            for name in used[st.name] & used.keys():
                needed[name] = min(needed.get(name, phase), phase)
        return tuple(tuple(st for st in statements if phase_of[st.name] == at) for at in range(3))
