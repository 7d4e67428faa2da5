"""Outputs for forces of the loads, and for a force at any point of the rod."""

from __future__ import annotations

from sympy import Symbol, symbols

from rodgen.derive.energies import Quantities
from rodgen.derive.general import GeneralEquations
from rodgen.derive.loads.kinds import AppliedForces
from rodgen.derive.symbols import i, joint, n
from rodgen.emit.statements import SCALAR, Domain, Outputs

# What the caller of generalised_force gives.
LINK = Symbol("link", integer=True)
SHARE = Symbol("share", nonnegative=True)
FORCE = symbols("force_x force_y", real=True)


def forces(equations: GeneralEquations, links: int) -> Outputs:
    """Components of every load that acts as forces on joints."""
    return {
        f"{term}_force_{axis}": (_joint_domain(load, links), component)
        for term, load in Quantities(equations).forces.items()
        for axis, component in zip("xy", load.force, strict=True)
    }


def force_places(equations: GeneralEquations, links: int) -> dict[str, str]:
    """Joints on which each load acts as a force, as an index of an array."""
    out = {}
    for term, load in Quantities(equations).forces.items():
        span = _joint_domain(load, links)
        out[term] = f"{span.low}:{span.high + 1}" if span.along else str(load.low.subs(n, links))
    return out


def _joint_domain(load: AppliedForces, links: int) -> Domain:
    """Domain of the joints on which a load acts; a load on a single joint is a scalar."""
    if load.low == load.high:
        return SCALAR
    return Domain((joint,), int(load.low.subs(n, links)), int(load.high.subs(n, links)))


def point_force(equations: GeneralEquations, links: int) -> Outputs:
    """Generalised forces of a force on a point of a link."""
    work = equations.point_force(FORCE, LINK, SHARE)
    rows: Outputs = {
        "on_links": (Domain((i,), equations.boundary_condition.first, links - 1), work.link)
    }
    if equations.boundary_condition.translates:
        rows |= {f"on_{axis}0": (SCALAR, e) for axis, e in zip("xy", work.base, strict=True)}
    return rows
