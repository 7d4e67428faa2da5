"""A scene as expressions of CasADi: the O(n) accelerations of chain.py, unrolled."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

import rodgen
from rodgen.judge.peers import chain, drag, loads
from rodgen.judge.precision.contestant import Array

KNOWN = (*chain.KNOWN, "external_damping")
FUNCTIONS = {name: getattr(ca, name) for name in loads.NAMES}
DRAG = {**FUNCTIONS, "abs": ca.fabs}


def equations(scene: rodgen.Scene, middle: float) -> dict[str, Any]:
    """Symbols t and x (states,) in rodgen's order, and the rates ode, as they are in the stretch
    of that time."""
    half = len(scene.initial_state()) // 2
    base = 2 if scene.hold.translates else 0
    x, t = ca.SX.sym("x", 2 * half), ca.SX.sym("t")
    entries = ca.vertsplit(x)
    phi, omega = entries[base:half], entries[half + base :]
    given = loads.parameters(scene, middle, FUNCTIONS)(t)
    velocity = (entries[half], entries[half + 1]) if base else (0.0, 0.0)
    forces = drag.forces(scene, given, phi, omega, velocity, DRAG, _or_one)
    found = chain.accelerations(scene, given, phi, omega, ca.cos, ca.sin, forces=forces)
    return {"t": t, "x": x, "ode": ca.vertcat(x[half:], *found)}


def _or_one(square: Any) -> Any:
    return ca.if_else(square > 0, square, 1.0)


def evaluated(made: dict[str, Any], t: float, y: Array) -> Array:
    """The accelerations in numbers."""
    function = ca.Function("rates", [made["t"], made["x"]], [made["ode"]])
    rates: Array = np.ravel(function(t, y).full())
    return rates[len(rates) // 2 :]
