"""CasADi: the O(n) expressions of chain.py, its generated C compiled and called from C."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import casadi as ca
import numpy as np

from rodgen.judge.peers.native import FLAGS, compiled
from rodgen.judge.peers.rates.prepared import Prepared, at_most, rod
from rodgen.judge.peers.symbolic import equations
from rodgen.judge.precision.contestant import Array

CALLER = """
#include "generated.c"
void caller(double t, const double *y, const double *p, double *dy)
{
    const double *arg[SZ_ARG] = {y};
    double *res[SZ_RES] = {dy}, w[SZ_W];
    casadi_int iw[SZ_IW];
    (void)t, (void)p;
    rhs(arg, res, iw, w, 0);
}
"""
LARGEST = 200  # links: compilers take long for a single function of so many statements


def prepare(links: int) -> Prepared:
    """Unrolled C: one statement an operation."""
    at_most("CasADi", links, LARGEST, "one function of all operations takes minutes to compile")
    start = time.perf_counter()
    made = equations(rod(links), 0.0)
    function = ca.Function("rhs", [made["x"]], [made["ode"]])
    sizes = {f"SZ_{name}": getattr(function, f"sz_{name.lower()}")() for name in ("ARG", "RES")}
    sizes |= {"SZ_W": function.sz_w() + 1, "SZ_IW": function.sz_iw() + 1}
    generator = ca.CodeGenerator("generated.c")
    generator.add(function)
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        texts = {"caller.c": CALLER, "generated.c": Path(folder, "generated.c").read_text()}
    written = time.perf_counter()
    native = compiled(texts, "caller", (*FLAGS, *(f"-D{k}={v}" for k, v in sizes.items())))
    setup = {"generate": written - start, "compile": time.perf_counter() - written}
    last, nothing = np.zeros(2 * links + 4), np.zeros(1)

    def rhs(given: Array) -> Array:
        last[:] = given
        return native(0.0, last, nothing)

    return Prepared(rhs, native.batch(last, nothing), in_c=True, setup=setup)
