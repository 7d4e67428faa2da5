"""Moments in the joints, forces of the loads, and what a force at any point of the rod does."""

from __future__ import annotations

from sympy import Symbol, symbols

from rodgen.derive.general import Equations
from rodgen.derive.loads.kinds import Acting
from rodgen.derive.quantities import Quantities
from rodgen.derive.symbols import i, joint, n
from rodgen.emit.statements import SCALAR, Domain, Outputs

# What the caller of generalised_force gives.
LINK = Symbol("link", integer=True)
SHARE = Symbol("share", nonnegative=True)
FORCE = symbols("force_x force_y", real=True)


def bending(equations: Equations, links: int) -> Outputs:
    """Bending moment in every joint."""
    return {"bending": (Domain((joint,), 0, links), Quantities(equations).bending_moment)}


def forces(equations: Equations, links: int) -> Outputs:
    """Components of every load that acts as forces on joints."""
    return {
        f"{term}_force_{axis}": (_joints(load, links), component)
        for term, load in Quantities(equations).forces.items()
        for axis, component in zip("xy", load.force, strict=True)
    }


def places(equations: Equations, links: int) -> dict[str, str]:
    """Of the same loads: the joints on which they act, as an index of an array."""
    out = {}
    for term, load in Quantities(equations).forces.items():
        span = _joints(load, links)
        out[term] = f"{span.low}:{span.high + 1}" if span.along else str(load.low.subs(n, links))
    return out


def _joints(load: Acting, links: int) -> Domain:
    """Over which joints a load is computed; one that acts on a single joint is a number."""
    if load.low == load.high:
        return SCALAR
    return Domain((joint,), int(load.low.subs(n, links)), int(load.high.subs(n, links)))


def point_force(equations: Equations, links: int) -> Outputs:
    """Generalised forces of a force on a point of a link."""
    work = equations.point_force(FORCE, LINK, SHARE)
    rows: Outputs = {"on_links": (Domain((i,), equations.hold.first, links - 1), work.link)}
    if equations.hold.translates:
        rows |= {f"on_{axis}0": (SCALAR, e) for axis, e in zip("xy", work.base, strict=True)}
    return rows
