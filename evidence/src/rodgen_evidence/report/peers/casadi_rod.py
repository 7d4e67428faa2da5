"""CasADi: the O(n) expressions of chain_accelerations.py, unrolled, with its own exact Jacobian.

Its integrators are each a single call from the start of a stretch to its end; its generated C is
compiled and called from C.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

import rodgen
from rodgen.analyse.precision.job import SAMPLES, Job, Stretch
from rodgen.analyse.precision.method_families import SHARE, scipy_tolerances
from rodgen.arrays import Array
from rodgen_evidence.report.peers import chain_accelerations, loads
from rodgen_evidence.report.peers.native import FLAGS, compile_function
from rodgen_evidence.report.peers.peer import Over, Peer, Prepared, at_most, rod, steps

ADAMS = {"linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional"}
MOST = 2**31 - 1  # steps between two samples
# Collocation by Radau's points, of order 5.
RADAU = {"interpolation_order": 3, "collocation_scheme": "radau"}
# Plugin and its options by method.
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "CVODES BDF": ("cvodes", {}),
    "CVODES Adams": ("cvodes", ADAMS),
    "IDAS": ("idas", {}),
    "collocation": ("collocation", RADAU),
}
COUNTS = {
    "nsteps": "nsteps",
    "rejected": "netfails",
    "nfev": "nfevals",
    "nlu": "nlinsetups",
}
FUNCTIONS = {name: getattr(ca, name) for name in loads.NAMES}
SYMBOLS = chain_accelerations.Algebra(
    *(ca.cos, ca.sin, ca.sqrt, ca.fabs), lambda square: ca.if_else(square > 0, square, 1.0)
)


def equations(scene: rodgen.Scene, middle: float) -> dict[str, Any]:
    """Symbols t and x (states,) in rodgen's order, and the rates ode, as they are in the stretch
    of that time."""
    half = len(scene.initial_state()) // 2
    x, t = ca.SX.sym("x", 2 * half), ca.SX.sym("t")
    entries = ca.vertsplit(x)
    given = loads.parameters(scene, middle, FUNCTIONS)(t)
    found = chain_accelerations.accelerations(
        scene.structure, given, entries[:half], entries[half:], SYMBOLS
    )
    return {"t": t, "x": x, "ode": ca.vertcat(x[half:], *found)}


class CasadiRod(Peer):
    """Backward differences or Adams methods by CVODES, backward differences for implicit equations
    by IDAS, collocation in elements of one length, of which every sample has at least one."""

    who = target = "CasADi"
    knows = (*chain_accelerations.KNOWN, "external_damping")
    orders = {"collocation": 5.0}
    # Of these the set-up takes seconds.
    most = {"CVODES BDF": 100, "CVODES Adams": 100, "IDAS": 100, "collocation": 20}
    why = "unrolled expressions, too large"

    def __init__(self, job: Job, method: str):
        super().__init__(job, method)
        begin = time.perf_counter()
        self.parts = job.stretches
        self.made = {part.first: equations(job.scene, part.middle) for part in self.parts}
        self.written = time.perf_counter() - begin
        self.plugin, self.options = METHODS[method]
        if method == "collocation":
            self.kind = "step"

    @property
    def name(self) -> str:
        """Name of the method, with the points of the collocation."""
        return "collocation, Radau 5" if self.method == "collocation" else self.method

    def settings(self, quick: bool) -> Iterator[float]:
        """Tolerances; of collocation the lengths of an element."""
        first, last = self.job.span
        fixed = self.kind == "step"
        return (
            steps(self.job, (last - first) / SAMPLES, quick) if fixed else scipy_tolerances(quick)
        )

    def integrator(self, setting: float) -> Over:
        """Create an integrator for every stretch."""
        begin = time.perf_counter()
        solvers = {
            part.first: ca.integrator(
                *("solver", self.plugin, self.made[part.first], part.first, part.times),
                self.options | self._accuracy(setting, part),
            )
            for part in self.parts
        }
        self.setup = {"generate": self.written + time.perf_counter() - begin}

        def over(stretch: Stretch, y: Array) -> Array:
            solver = solvers[stretch.first]
            states: Array = solver(x0=y)["xf"].full().T
            said = solver.stats()
            for name, known in COUNTS.items():
                if known in said:
                    self.counts[name] += int(said[known])
            return states

        return over

    def _accuracy(self, setting: float, part: Stretch) -> dict[str, Any]:
        if self.kind == "step":
            return {"number_of_finite_elements": round((part.last - part.first) / setting) or 1}
        return {"reltol": setting, "abstol": SHARE * setting, "max_num_steps": MOST}

    def accelerations(self, t: float, y: Array) -> Array:
        """Accelerations by a function of the expressions of the stretch."""
        made = next(self.made[part.first] for part in self.parts if t <= part.last)
        rates = ca.Function("rates", [made["t"], made["x"]], [made["ode"]])(t, y).full()
        return np.ravel(rates)[len(y) // 2 :]


CALLER = """
#include "generated.h"
void caller(double t, const double *y, const double *p, double *dy)
{
    const double *arg[%(SZ_ARG)d] = {y};
    double *res[%(SZ_RES)d] = {dy}, w[%(SZ_W)d];
    casadi_int iw[%(SZ_IW)d];
    (void)t, (void)p;
    rhs(arg, res, iw, w, 0);
}
"""
MOST_RATES = 200  # links: compilers take long for a single function of so many statements


def prepare(links: int) -> Prepared:
    """Unrolled C: one statement an operation."""
    why = "one function of all operations takes minutes to compile"
    at_most("CasADi", links, MOST_RATES, why)
    made = equations(rod(links), 0.0)
    function = ca.Function("rhs", [made["x"]], [made["ode"]])
    sizes = {f"SZ_{name}": getattr(function, f"sz_{name.lower()}")() for name in ("ARG", "RES")}
    sizes |= {"SZ_W": function.sz_w() + 1, "SZ_IW": function.sz_iw() + 1}
    generator = ca.CodeGenerator("generated.c")
    generator.add(function)
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        text = Path(folder, "generated.c").read_text()
    native = compile_function({"caller.c": CALLER % sizes, "generated.h": text}, "caller", FLAGS)
    last, nothing = np.zeros(2 * links + 4), np.zeros(1)

    def rhs(given: Array) -> Array:
        last[:] = given
        return native(0.0, last, nothing)

    return Prepared(rhs, native.batch(last, nothing))
