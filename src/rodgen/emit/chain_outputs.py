"""Outputs of the rates of a module in the chain form, and of their derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import starmap

from sympy import Eq, Expr, Indexed, IndexedBase, Piecewise, S, Symbol

from rodgen.derive.general import GeneralEquations
from rodgen.derive.implicit_form import UNKNOWNS, ImplicitForm
from rodgen.derive.joint_force_system import joint_system
from rodgen.derive.joint_system import BlockSystem, link_moment
from rodgen.derive.link_properties import INERTIAS
from rodgen.derive.symbols import Array, alpha, i, n
from rodgen.derive.variable_mass import ChangingBody, VariableMasses
from rodgen.emit.laws import Laws
from rodgen.emit.masses import Masses
from rodgen.emit.newton import NewtonMatrix
from rodgen.emit.program import Compiler, Solve
from rodgen.emit.spring_expression import law_of
from rodgen.emit.statements import SCALAR, Domain, Outputs, Program
from rodgen.model.term import BASE
from rodgen.scene.grammar import NUMPY
from rodgen.scene.structure import Structure


@dataclass(frozen=True)
class ChainFunctions:
    """Outputs for the rates of one structure; compiled where NumPy text is wanted."""

    structure: Structure

    @cached_property
    def equations(self) -> GeneralEquations:
        """Equations of derivation 2."""
        of = self.structure
        equations = GeneralEquations(of.boundary, of.inertia, of.terms, of.nonuniform, law_of(of))
        return _cached_equations(equations, INERTIAS[of.inertia])

    @property
    def n_links(self) -> int:
        return self.structure.n_links

    @property
    def _derivation(self) -> tuple[BlockSystem, ImplicitForm]:
        return _derive(self.equations, INERTIAS[self.equations.inertia])

    @property
    def has_springs(self) -> bool:
        """Whether any joint has a spring: a single link that is not clamped has none."""
        return bool(self.equations.boundary_condition.spring_joints(self.n_links))

    @cached_property
    def system(self) -> BlockSystem:
        """System of derivation 3, without the moments of springs where no joint has one."""
        return self._derivation[0].without(set() if self.has_springs else {link_moment})

    @cached_property
    def compiler(self) -> Compiler:
        """Compiler of outputs to programs."""
        first, arrays = self.equations.boundary_condition.first, self.system.arrays
        if self.variable_masses:
            present = self.variable_masses.masses.items()
            arrays = arrays | {base: Array(base, i, S.Zero, n - 1, e) for base, e in present}
        known = arrays, self.solve, self.parameter_domains, self.laws.definitions
        return Compiler(self.n_links, first, *known, self.time_dependent)

    @cached_property
    def variable_masses(self) -> VariableMasses | None:
        """Masses that are functions of time; None where there are none."""
        of = self.structure
        if not of.masses:
            return None
        bodies = tuple(starmap(ChangingBody, of.changing_bodies.items()))
        own = len(bodies) < len(of.masses)
        return VariableMasses(self.equations, own, bodies, of.potentials)

    @cached_property
    def time_dependent(self) -> tuple[str, ...]:
        """Names of the numbers and masses that depend on time, and of the rates of these masses."""
        masses = Masses(self.structure)
        expressions = self.structure.open_expressions
        return (*expressions, *masses.number_codes(NUMPY), *masses.link_codes(NUMPY))

    @cached_property
    def laws(self) -> Laws:
        """Expressions that follow the motion, and states that are added."""
        return Laws(self.structure)

    @property
    def state_rates(self) -> Outputs:
        """Rates of the states that are added."""
        return scalar_outputs(self.laws.rates)

    @cached_property
    def parameter_domains(self) -> dict[str, Domain]:
        """Parameters that are several numbers, each with the joints or links that these are of."""
        spans = self.structure.index_ranges.items()
        return {name: Domain((i,), span.start, span.stop - 1) for name, span in spans}

    @cached_property
    def solve(self) -> Solve:
        """Unknowns of the system and their range, with the values given at their ends."""
        low = self.low - bool(self.system.start)
        high = self.high + bool(self.system.end)
        domain = Domain((self.system.index,), low, high)
        return Solve(tuple(map(str, self.system.unknowns)), domain)

    @property
    def low(self) -> int:
        """The first position of the system."""
        return int(self.system.low)

    @property
    def high(self) -> int:
        """The last position of the system; below the first where there is nothing to solve."""
        return int(self.system.high.subs(n, self.n_links))

    @cached_property
    def ends(self) -> Outputs:
        """Unknowns that are given at the start and at the end, where they are not zero."""
        axes = self.axes
        given = {"start": self.system.start, "end": self.system.end}
        return {
            f"{where}_{axis}": (SCALAR, e)
            for where, values in given.items()
            for axis, e in zip(axes, values, strict=False)
            if e != 0
        }

    @property
    def axes(self) -> tuple[str, ...]:
        """Suffixes of the components of an unknown."""
        return ("x", "y") if len(self.system.unknowns) == 2 else ("t",)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Row and column of every entry in the upper half of a block."""
        width = len(self.axes)
        return [(r, c) for r in range(width) for c in range(r, width)]

    @cached_property
    def matrix(self) -> Outputs:
        """Entries of the blocks: of the diagonal, and of a position with the next."""
        system, axes, out = self.system, self.axes, Outputs()
        if self.high < self.low:
            return out
        rows = Domain((system.index,), self.low, self.high)
        starts = any(name.startswith("start") for name in self.ends)
        # Beyond the last row stands what is given there, be it zero.
        low, high = self.low - starts, self.high - (not system.end)
        for r, c in self.pairs:
            out[f"diag_{axes[r]}{axes[c]}"] = rows, system.diagonal[r, c]
            if low <= high and (self.low < self.high or self.ends):
                over = Domain((system.index,), low, high)
                out[f"next_{axes[r]}{axes[c]}"] = over, system.coupling[r, c]
                if r != c and system.coupling != system.coupling.T:
                    out[f"next_{axes[c]}{axes[r]}"] = over, system.coupling[c, r]
        return out

    def _coupling(self, r: int, c: int, at: Expr) -> Expr:
        """An entry of the block of a position with the next."""
        pair = self.axes[r] + self.axes[c]
        known = f"next_{pair}" in self.matrix
        return _element(f"next_{pair if known else ''.join(sorted(pair))}", at)

    @cached_property
    def right(self) -> Outputs:
        """Right-hand side of the system."""
        if self.high < self.low:
            return {}
        rows = Domain((self.system.index,), self.low, self.high)
        return named_outputs([f"right_{axis}" for axis in self.axes], self.system.right, rows)

    @cached_property
    def rates(self) -> Outputs:
        """Accelerations by the solution: of the links, and of joint 0 where it moves."""
        out: Outputs = {str(alpha): (self.compiler.link, self.system.angular)}
        for axis, e in zip("xy", self.system.base, strict=False):
            out[f"base_a{axis}"] = SCALAR, e
        return out

    @cached_property
    def residual(self) -> Outputs:
        """Residual of the system for given unknowns, of which only the tangent is used."""
        if self.high < self.low:
            return {}
        system, index, axes = self.system, self.system.index, self.axes
        rows = Domain((index,), self.low, self.high)
        out: Outputs = {}
        for r, axis in enumerate(axes):
            inner = IndexedBase(f"right_{axis}", real=True)[index]
            before = after = S.Zero
            for c, unknown in enumerate(system.unknowns):
                pair = "".join(sorted(axes[r] + axes[c]))
                inner -= _element(f"diag_{pair}", index) * unknown[index]
                before -= self._coupling(c, r, index - 1) * unknown[index - 1]
                after -= self._coupling(r, c, index) * unknown[index + 1]
            if f"next_{axes[0]}{axes[0]}" not in self.matrix:
                before = after = S.Zero
            out[f"residual_{axis}"] = rows, self._with_neighbours(inner, before, after)
        return out

    def _with_neighbours(self, inner: Expr, before: Expr, after: Expr) -> Expr:
        """A row of the residual with its neighbours; beyond the ends stands what is given."""
        index, sides = self.system.index, {"start": before, "end": after}
        for where, offset in (("start", -1), ("end", 1)):
            for axis, unknown in zip(self.axes, self.system.unknowns, strict=True):
                name = f"{where}_{axis}"
                given = Symbol(name, real=True) if name in self.ends else S.Zero
                sides[where] = sides[where].xreplace({unknown[index + offset]: given})
        if self.low == self.high:
            return inner + sides["start"] + sides["end"]
        return Piecewise(
            (inner + sides["start"] + after, Eq(index, self.low)),
            (inner + before + sides["end"], Eq(index, self.high)),
            (inner + before + after, True),
        )

    @property
    def chain_outputs(self) -> Outputs:
        """Outputs of rhs in the chain form."""
        return self.ends | self.matrix | self.right | self.rates | self.state_rates

    def chain(self) -> Program:
        """Program of rhs in O(n)."""
        return self.compiler.compile(self.chain_outputs)

    @property
    def derivatives(self) -> tuple[Outputs, dict[str, frozenset[str]], list[str]]:
        """Outputs of jac, those whose tangent is wanted, and those whose value is."""
        unknowns = frozenset(map(str, self.system.unknowns))
        values = self.ends | self.matrix | self.right
        none: frozenset[str] = frozenset()
        tangents = dict.fromkeys(self.ends, none) | dict.fromkeys(self.residual, unknowns)
        tangents |= dict.fromkeys(self.rates | self.state_rates, none)
        return values | self.residual | self.rates | self.state_rates, tangents, list(values)

    def jac(self) -> Program:
        """Program of the Jacobian, by tangents of the chain form."""
        outputs, tangents, values = self.derivatives
        return self.compiler.compile(outputs, tangents=tangents, values=values)

    @cached_property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs: single numbers of loads that may be laws. What moves a base is none:
        the rod feels its accelerations, which are no numbers."""
        rows = [row for row in self.structure.load_rows.values() if row.kind != BASE]
        given = (one for row in rows for one in row.parameters if one.timed and not one.is_array)
        return tuple(dict.fromkeys(one.name for one in given))

    def inputs(self) -> Program:
        """Program of the derivatives of the rates by the inputs, likewise."""
        outputs, tangents, values = self.derivatives
        by = self.input_names
        return self.compiler.compile(outputs, tangents=tangents, values=values, by=by)

    @cached_property
    def newton(self) -> NewtonMatrix:
        """Derivatives that make up a Newton matrix."""
        of_rod = self.equations, self.laws, self.compiler.link, self.n_links
        return NewtonMatrix(self._derivation[1], *of_rod)

    def implicit(self) -> Program:
        """Program of the residual with joint forces as unknowns, and of its blocks."""
        cells = dict.fromkeys(map(str, UNKNOWNS), self.compiler.link)
        return self.compiler.compile(self.newton.cells, given=cells)


@cache
def _cached_equations(equations: GeneralEquations, law: object) -> GeneralEquations:
    """Return the first of equal equations, for one law of inertia, with all that it has cached."""
    return equations


@cache
def _derive(equations: GeneralEquations, law: object) -> tuple[BlockSystem, ImplicitForm]:
    """Derive both forms of derivation 3, once for any number of links and a law of inertia."""
    return joint_system(equations), ImplicitForm(equations)


def _element(name: str, at: Expr) -> Indexed:
    return IndexedBase(name, real=True)[at]


def named_outputs(names: Iterable[str], values: Iterable[Expr], over: Domain = SCALAR) -> Outputs:
    """Outputs by their names, all over the same range."""
    return {name: (over, e) for name, e in zip(names, values, strict=True)}


def scalar_outputs(outputs: Mapping[str, Expr]) -> Outputs:
    """Outputs that are one number each."""
    return {name: (SCALAR, e) for name, e in outputs.items()}
