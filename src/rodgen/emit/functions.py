"""The functions of a module: what each computes, as the derivations have it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property

import sympy
from sympy import Eq, Expr, Indexed, IndexedBase, Piecewise, S, Symbol

from rodgen.derive.general import Equations, joint, joint_vx, joint_vy, joint_x, joint_y
from rodgen.derive.implicit_form import UNKNOWNS, ImplicitForm
from rodgen.derive.inertia import INERTIAS
from rodgen.derive.joint_forces import joint_system
from rodgen.derive.joint_system import System, alpha, link_moment
from rodgen.derive.quantities import Quantities
from rodgen.derive.symbols import i, n
from rodgen.emit.forces import bending, forces, point_force
from rodgen.emit.program import Compiler, Solve
from rodgen.emit.statements import SCALAR, Domain, Outputs, Program
from rodgen.scene.structure import Structure


@dataclass(frozen=True)
class Functions:
    """Outputs of the functions of one structure, by name; compiled where NumPy text is wanted."""

    structure: Structure

    @cached_property
    def equations(self) -> Equations:
        """Derivation 2."""
        return Equations(self.structure.boundary, self.structure.inertia, self.structure.terms)

    @property
    def links(self) -> int:
        return self.structure.links

    @property
    def _derived(self) -> tuple[System, ImplicitForm]:
        return _derive(self.equations, INERTIAS[self.equations.inertia])

    @property
    def springs(self) -> bool:
        """Whether any joint has a spring: a single link that is not clamped has none."""
        return self.links > self.equations.hold.first_spring

    @cached_property
    def system(self) -> System:
        """Derivation 3, without what this many links do not have."""
        return _pruned(self._derived[0], set() if self.springs else {link_moment})

    @cached_property
    def compiler(self) -> Compiler:
        """What turns outputs into programs."""
        first = self.equations.hold.first
        return Compiler(self.links, first, self.system.arrays, self.solve)

    @cached_property
    def solve(self) -> Solve:
        """The unknowns, with the values given at their ends."""
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
        return int(self.system.high.subs(n, self.links))

    # The chain form ---------------------------------------------------------------------------

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
        """Rows and columns of the upper half of a block."""
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
            if system.coupling[r, c] != system.coupling[c, r]:
                raise ArithmeticError(f"coupling is not symmetric: {system.coupling}")
            if low <= high and (self.low < self.high or self.ends):
                over = Domain((system.index,), low, high)
                out[f"next_{axes[r]}{axes[c]}"] = over, system.coupling[r, c]
        return out

    @cached_property
    def right(self) -> Outputs:
        """Right-hand side of the system."""
        if self.high < self.low:
            return {}
        rows = Domain((self.system.index,), self.low, self.high)
        return {
            f"right_{axis}": (rows, e) for axis, e in zip(self.axes, self.system.right, strict=True)
        }

    @cached_property
    def rates(self) -> Outputs:
        """Accelerations by the solution: of the links, and of joint 0 where it moves."""
        out: Outputs = {str(alpha): (self.compiler.link, self.system.angular)}
        for axis, e in zip("xy", self.system.base, strict=False):
            out[f"base_a{axis}"] = SCALAR, e
        return out

    @cached_property
    def residual(self) -> Outputs:
        """What the system leaves for given unknowns; of this only the tangent is wanted."""
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
                before -= _element(f"next_{pair}", index - 1) * unknown[index - 1]
                after -= _element(f"next_{pair}", index) * unknown[index + 1]
            if f"next_{axes[0]}{axes[0]}" not in self.matrix:
                before = after = S.Zero
            out[f"residual_{axis}"] = rows, self._at_ends(inner, before, after, r)
        return out

    def _at_ends(self, inner: Expr, before: Expr, after: Expr, r: int) -> Expr:
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

    # Programs ---------------------------------------------------------------------------------

    @property
    def chain_outputs(self) -> Outputs:
        """What rhs needs in the chain form."""
        return self.ends | self.matrix | self.right | self.rates

    def chain(self) -> Program:
        """rhs in O(n)."""
        return self.compiler.compile(self.chain_outputs)

    @property
    def derivatives(self) -> tuple[Outputs, dict[str, frozenset[str]], list[str]]:
        """Outputs of jac, those whose tangent is wanted, and those whose value is."""
        unknowns = frozenset(map(str, self.system.unknowns))
        values = self.ends | self.matrix | self.right
        none: frozenset[str] = frozenset()
        tangents = dict.fromkeys(self.ends, none) | dict.fromkeys(self.residual, unknowns)
        tangents |= dict.fromkeys(self.rates, none)
        return values | self.residual | self.rates, tangents, list(values)

    def jac(self) -> Program:
        """The Jacobian by tangents of the chain form."""
        outputs, tangents, values = self.derivatives
        return self.compiler.compile(outputs, tangents=tangents, values=values)

    def implicit(self) -> Program:
        """Residual with joint forces as unknowns, and its blocks."""
        cells = dict.fromkeys(map(str, UNKNOWNS), self.compiler.link)
        return self.compiler.compile(self.cells, given=cells)

    @cached_property
    def cells(self) -> Outputs:
        """What implicit gives, by the names that the templates put together."""
        form, link = self._derived[1], self.compiler.link
        outputs: Outputs = {f"residual_{r}": (link, e) for r, e in enumerate(form.residual)}
        blocks = {
            "angle": form.by_angle,
            "rate": form.by_rate,
            "unknown": form.by_unknown,
            "velocity": form.by_velocity,
        }
        for name, matrices in blocks.items():
            for at, matrix in enumerate(matrices.values()):
                for r in range(matrix.rows):
                    for c in range(matrix.cols):
                        value = matrix[r, c].subs(n, self.links)
                        if value != 0:
                            outputs[f"by_{name}_{at}_{r}_{c}"] = link, value
        return outputs

    @cached_property
    def motion(self) -> Outputs:
        """What takes the place of prefix sums in a Newton matrix: derivatives of the velocity that
        a link adds, and of the acceleration of joint 0 where it moves."""
        form, out = self._derived[1], Outputs()
        if "external_damping" in self.equations.terms:
            for kind, gained in zip(("angle", "rate"), form.lever_by, strict=True):
                for r in range(2):
                    out[f"lever_{kind}_{r}"] = self.compiler.link, gained[r]
        if self.equations.hold.translates:
            for kind, matrices in form.base_by(self.links).items():
                for at, matrix in matrices.items():
                    for r in range(matrix.rows):
                        for c in range(matrix.cols):
                            value = matrix[r, c].subs({i: 0, n: self.links})
                            if value != 0 and (at == 0 or self.links > 1 or kind == "velocity"):
                                out[f"base_{kind}_{at}_{r}_{c}"] = SCALAR, value
        return out

    def mass(self) -> Program:
        """Entries of the mass matrix."""
        return self.compiler.compile(self._mass)

    @cached_property
    def _mass(self) -> Outputs:
        equations, link = self.equations, self.compiler.link
        out: Outputs = {}
        if equations.hold.translates:
            out["mass_base"] = SCALAR, equations.mass_base
            for axis, entry in zip("xy", equations.mass_base_link, strict=True):
                out[f"mass_{axis}_link"] = link, entry
        out["mass_link"] = link, equations.mass_link
        if link.count > 1:
            out["mass_link_link"] = self.compiler.pair, equations.mass_link_link
        return out

    def dense(self) -> Program:
        """rhs by the mass matrix."""
        equations, link = self.equations, self.compiler.link
        rhs: Outputs = {}
        if equations.hold.translates:
            for axis, entry in zip("xy", equations.velocity_base_link, strict=True):
                rhs[f"velocity_{axis}_link"] = link, entry
        if link.count > 1:
            rhs["velocity_link_link"] = self.compiler.pair, equations.velocity_link_link
        return self.compiler.compile(self._mass | rhs | self._forces())

    def _forces(self) -> Outputs:
        """Generalised forces of loads and joints, without those that vanish."""
        out: Outputs = {}
        works = self.equations.works.values()
        if self.equations.hold.translates:
            for at, axis in enumerate("xy"):
                out[f"force_{axis}"] = SCALAR, _total(work.base[at] for work in works)
        if self.springs:
            out["link_moment"] = self.compiler.link, self.equations.link_moment
        out["force_link"] = self.compiler.link, _total(work.link for work in works)
        return {name: (domain, e) for name, (domain, e) in out.items() if e != 0}

    def quantities(self) -> dict[str, Program]:
        """Energies, power and geometry, for states along leading axes."""
        quantities = Quantities(self.equations)
        joints = Domain((joint,), 0, self.links)
        energy = {"kinetic": quantities.kinetic_energy}
        if self.springs:
            energy["spring"] = quantities.spring_energy
        if "gravity" in self.equations.terms:
            energy["gravity_energy"] = quantities.gravity_energy
        arrays = self.equations.arrays
        positions = {str(base): (joints, arrays[base].value) for base in (joint_x, joint_y)}
        centre = ("centre_x", "centre_y")
        moments = dict(
            zip(("inertia_x", "inertia_y", "product_xy"), quantities.second_moments, strict=True)
        )
        near = dict(zip(centre, quantities.centre_from_start, strict=True))
        outputs = {
            "energy": _scalars(energy),
            "power": self.power,
            "joints": positions,
            "centre": _scalars(dict(zip(centre, quantities.centre, strict=True))),
            "inertia_moments": _scalars(near | moments),
            "bending": bending(self.equations, self.links),
            "forces": forces(self.equations, self.links),
        }
        return {name: self.compiler.compile(o, batch=True) for name, o in outputs.items()}

    def point_force(self) -> Program:
        """Generalised forces of a force on a point of a link."""
        return self.compiler.compile(point_force(self.equations, self.links))

    @cached_property
    def power(self) -> Outputs:
        """Power of every load without potential."""
        power = Quantities(self.equations).power
        acting = {f"power_{term}": e for term, e in power.items() if self._acts(term)}
        if "external_damping" not in self.equations.terms:
            # Of all joints, only the tail's velocity is asked for: a sum, not one for every joint.
            values = {base: self.equations.arrays[base].value for base in (joint_vx, joint_vy)}
            tail = {base[n]: value.subs(joint, n) for base, value in values.items()}
            acting = {name: e.xreplace(tail) for name, e in acting.items()}
        return _scalars(acting)

    def _acts(self, term: str) -> bool:
        """Internal damping acts where springs do."""
        return term != "internal_damping" or self.springs


@cache
def _derive(equations: Equations, law: object) -> tuple[System, ImplicitForm]:
    """Derivation 3, once for any number of links and for one law of inertia."""
    return joint_system(equations), ImplicitForm(equations)


def _element(name: str, at: Expr) -> Indexed:
    return IndexedBase(name, real=True)[at]


def _total(parts: Iterable[Expr]) -> Expr:
    return sympy.Add(*parts)


def _scalars(outputs: Mapping[str, Expr]) -> Outputs:
    return {name: (SCALAR, e) for name, e in outputs.items()}


def _pruned(system: System, gone: set[IndexedBase]) -> System:
    """The system without arrays that are zero, and without what that makes zero in turn."""
    while gone:
        now = gone

        def without(e: Expr, now: set[IndexedBase] = now) -> Expr:
            return e.xreplace({x: S.Zero for x in e.atoms(Indexed) if x.base in now})

        kept = {base: a for base, a in system.arrays.items() if base not in now}
        system = replace(
            system,
            arrays={base: replace(a, value=without(a.value)) for base, a in kept.items()},
            right=system.right.applyfunc(without),
            angular=without(system.angular),
            base=tuple(map(without, system.base)),
        )
        gone = {base for base, a in system.arrays.items() if a.value == 0}
    return system
