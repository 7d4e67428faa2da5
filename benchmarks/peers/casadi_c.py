"""CasADi: the O(n) expressions written by hand, its generated C compiled and called from C."""

from __future__ import annotations

import tempfile
from pathlib import Path

import casadi as ca
import numpy as np
from native import compiled
from problem import P, Vector

from peers import Prepared

NAME, SIZES = "CasADi, C generated from O(n) expressions", (20, 50, 200)

# Those of rodgen's that help unrolled code: -O3 and wider vectors measure the same here.
FLAGS = ("-O2", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
CALLER = """
#include "generated.c"
void caller(double t, const double *y, const double *p, double *dy)
{
    const double *arg[SZ_ARG] = {y, p};
    double *res[SZ_RES] = {dy}, w[SZ_W];
    casadi_int iw[SZ_IW];
    (void)t;
    rhs(arg, res, iw, w, 0);
}
"""


def prepare(n: int) -> Prepared:
    """Unrolled C: one statement an operation."""
    y, p = ca.SX.sym("y", 2 * n + 4), ca.SX.sym("p", 5)
    function = ca.Function("rhs", [y, p], [_rhs(n, y, p)])
    generator = ca.CodeGenerator("generated.c")
    generator.add(function)
    sizes = {f"SZ_{name}": getattr(function, f"sz_{name.lower()}")() for name in ("ARG", "RES")}
    sizes |= {"SZ_W": function.sz_w() + 1, "SZ_IW": function.sz_iw() + 1}
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        texts = {"caller.c": CALLER, "generated.c": Path(folder, "generated.c").read_text()}
    native = compiled(texts, "caller", (*FLAGS, *(f"-D{k}={v}" for k, v in sizes.items())))
    last = np.zeros(2 * n + 4)

    def rhs(given: Vector) -> Vector:
        last[:] = given
        return native(last, P)

    return Prepared(rhs, native.batch(last, P), in_c=True)


def _rhs(n: int, y: ca.SX, p: ca.SX) -> ca.SX:
    m, l = p[0] / n, p[1] / n
    k, J = p[2] / l, m * l**2 / 12
    phi, u, omega = y[2 : n + 2], y[n + 2 :], y[n + 4 :]
    e = [ca.vertcat(ca.cos(phi[i]), ca.sin(phi[i])) for i in range(n)]
    normal = [ca.vertcat(-link[1], link[0]) for link in e]
    springs = [0, *(k * (phi[i + 1] - phi[i]) for i in range(n - 1)), 0]
    moment = [springs[i + 1] - springs[i] for i in range(n)]
    along, across = -p[3] * ca.cos(p[4]), -p[3] * ca.sin(p[4])
    moment[-1] += l / 2 * across
    force = [ca.SX.zeros(2)] * (n - 1) + [along * e[-1] + across * normal[-1]]
    w = [6 / l * moment[i] * normal[i] - m * l / 2 * omega[i] ** 2 * e[i] for i in range(n)]
    E = [3 * link @ link.T - ca.SX.eye(2) for link in normal]
    passed: list[tuple[ca.SX, ca.SX]] = []
    for j in range(1, n):
        D, r = E[j - 1] + E[j] + 4 * ca.SX.eye(2), force[j - 1] - force[j] + w[j - 1] + w[j]
        if passed:
            D, r = D - E[j - 1] @ passed[-1][0], r - E[j - 1] @ passed[-1][1]
        adjugate = ca.blockcat([[D[1, 1], -D[0, 1]], [-D[0, 1], D[0, 0]]])
        over = 1 / (D[0, 0] * D[1, 1] - D[0, 1] ** 2)
        passed.append((over * (adjugate @ E[j]), over * (adjugate @ r)))
    forces = [ca.SX.zeros(2)]
    for G, q in reversed(passed):
        forces.append(q - G @ forces[-1])
    forces = [*forces, ca.SX.zeros(2)][::-1]
    alpha = [
        (moment[i] - l / 2 * ca.dot(normal[i], forces[i] + forces[i + 1])) / J for i in range(n)
    ]
    start = (force[0] - forces[1]) / m + l / 2 * (omega[0] ** 2 * e[0] - alpha[0] * normal[0])
    return ca.vertcat(u, start, *alpha)
