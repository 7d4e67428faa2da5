"""The Newton matrix of an implicit step: its blocks, what couples them, and its border."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

from sympy import Expr, Matrix

from rodgen.derive.general import GeneralEquations
from rodgen.derive.implicit_form import ImplicitForm
from rodgen.derive.sensors import AXES
from rodgen.derive.symbols import i, n
from rodgen.emit.laws import Laws
from rodgen.emit.statements import SCALAR, Domain, Outputs


@dataclass(frozen=True)
class NewtonMatrix:
    """Derivatives of equations in which accelerations and joint forces are unknowns.

    laws: those that border the matrix; link: the links that move, of so many.
    """

    form: ImplicitForm
    equations: GeneralEquations
    laws: Laws
    link: Domain
    n_links: int

    @property
    def outputs(self) -> Outputs:
        """All outputs: cells, motion and border."""
        return self.cells | self.motion | self.border

    @cached_property
    def cells(self) -> Outputs:
        """Outputs of implicit, by the names that the templates put together."""
        form, link = self.form, self.link
        outputs: Outputs = {f"residual_{r}": (link, e) for r, e in enumerate(form.residual)}
        for name, _, e in _entries(form.derivatives):
            value = e.subs(n, self.n_links)
            if value != 0:
                outputs[f"by_{name}"] = link, value
        return outputs

    @cached_property
    def motion(self) -> Outputs:
        """Outputs in place of prefix sums in a Newton matrix: derivatives of the velocity that a
        link adds (that by its rate is also that of the position by its angle), and of the
        acceleration of joint 0 where it moves."""
        form, out = self.form, Outputs()
        if self.equations.has_velocity_loads:
            for kind, gained in zip(("angle", "rate"), form.link_velocity_derivatives, strict=True):
                for r in range(2):
                    out[f"lever_{kind}_{r}"] = self.link, gained[r]
        moved = ("velocity", "position")  # of joints, of which there is one more than links
        if self.equations.boundary_condition.translates:
            for name, at, e in _entries(form.base_derivatives(self.n_links)):
                value = e.subs({i: 0, n: self.n_links})
                if value != 0 and (at == 0 or self.n_links > 1 or name.startswith(moved)):
                    out[f"base_{name}"] = SCALAR, value
        return out

    @cached_property
    def border(self) -> Outputs:
        """Outputs that border a Newton matrix: derivatives of the equations by parameters that
        follow the motion, of laws by what they follow, and of sensors by the state."""
        form, link, out = self.form, self.link, Outputs()
        for at, number in enumerate(self.laws.inputs):
            for r, e in enumerate(form.by_number(number)):
                out[f"by_input_{at}_{r}"] = link, e.subs(n, self.n_links)
            if self.equations.boundary_condition.translates:
                for r, e in enumerate(form.base_by_number(number, self.n_links)):
                    out[f"base_input_{at}_{r}"] = SCALAR, e.subs({i: 0, n: self.n_links})
        out |= {str(gain): (SCALAR, e) for gain, (_, _, e) in self.laws.seen_gains.items()}
        for at, (sensor, point) in enumerate(self.laws.points):
            if sensor.what in AXES and not point.held:
                along = replace(link, high=point.link)
                for kind, e in zip(("angle", "rate"), point.derivatives(sensor.what), strict=True):
                    out[f"sensed_{kind}_{at}"] = along, e
        return {name: (domain, e) for name, (domain, e) in out.items() if e != 0}


def _entries(blocks: Mapping[str, Sequence[Matrix]]) -> Iterator[tuple[str, int, Expr]]:
    """Yield the entries of matrices with their names, which end in the numbers of the matrix, the
    row and the column, and with the number of the matrix."""
    for kind, matrices in blocks.items():
        for at, matrix in enumerate(matrices):
            for r, c in product(range(matrix.rows), range(matrix.cols)):
                yield f"{kind}_{at}_{r}_{c}", at, matrix[r, c]
