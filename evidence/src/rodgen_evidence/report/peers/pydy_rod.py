"""PyDy: KanesMethod and the generated Cython code; its set-up explodes, so few links."""

from __future__ import annotations

import os
import tempfile
from functools import partial
from typing import Any

import numpy as np
import sympy.physics.mechanics as me
from pydy.codegen.ode_function_generators import generate_ode_function
from sympy import Matrix, Symbol, cos, sin, symbols

from rodgen.arrays import Array
from rodgen_evidence.report.interleaved_timing import calls
from rodgen_evidence.report.peers.peer import Prepared, at_most, rod

LARGEST = 10  # links
NAMES = ("mass", "length", "bending_stiffness", "follower_force", "follower_angle")


def prepare(n: int) -> Prepared:
    """Kane's equations with absolute angles and the angular velocities as speeds."""
    at_most("PyDy", n, LARGEST, "symbolic derivation takes minutes")
    given = rod(n).parameters
    p = np.array([given[name] for name in NAMES])
    q = me.dynamicsymbols(f"x y phi0:{n}")
    u = me.dynamicsymbols(f"vx vy omega0:{n}")
    constants = symbols(NAMES)
    kane = _kane(n, q, u, constants)
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:  # for what pydy writes
        os.chdir(folder)
        try:
            ode = generate_ode_function(
                kane.forcing,
                q,
                u,
                constants,
                mass_matrix=kane.mass_matrix,
                coordinate_derivatives=Matrix(u),
                generator="cython",
                linear_sys_solver="scipy",
            )
        finally:
            os.chdir(here)
    last = np.zeros(2 * n + 4)

    def rhs(y: Array) -> Array:
        last[:] = y
        return np.array(ode(last, 0.0, p))

    return Prepared(rhs, calls(partial(ode, last, 0.0, p)))


def _kane(n: int, q: list[Any], u: list[Any], constants: tuple[Symbol, ...]) -> me.KanesMethod:
    mass, length, stiffness, thrust, nu = constants
    m, l, frame = mass / n, length / n, me.ReferenceFrame("N")
    joint, origin = me.Point("joint0"), me.Point("O")
    origin.set_vel(frame, 0)
    joint.set_pos(origin, q[0] * frame.x + q[1] * frame.y)
    joint.set_vel(frame, u[0] * frame.x + u[1] * frame.y)
    bodies, loads = [], []
    for i in range(n):
        link = frame.orientnew(f"L{i}", "Axis", (q[2 + i], frame.z))
        link.set_ang_vel(frame, u[2 + i] * frame.z)
        middle, tail = (
            joint.locatenew(f"C{i}", l / 2 * link.x),
            joint.locatenew(f"T{i}", l * link.x),
        )
        middle.v2pt_theory(joint, frame, link)
        tail.v2pt_theory(joint, frame, link)
        inertia = me.inertia(link, 0, 0, m * l**2 / 12)
        bodies.append(me.RigidBody(f"B{i}", middle, link, m, (inertia, middle)))
        after = stiffness / l * (q[3 + i] - q[2 + i]) if i < n - 1 else 0
        before = stiffness / l * (q[2 + i] - q[1 + i]) if i else 0
        loads.append((link, (after - before) * frame.z))
        joint = tail
    loads.append((joint, -thrust * (cos(nu) * link.x + sin(nu) * link.y)))
    rates = [x.diff(me.dynamicsymbols._t) - w for x, w in zip(q, u, strict=True)]
    kane = me.KanesMethod(frame, q, u, kd_eqs=rates)
    kane.kanes_equations(bodies, loads)
    return kane
