"""Pinocchio: its articulated-body algorithm on two sliders and n hinges, called from Python."""

from __future__ import annotations

from functools import partial

import numpy as np
import pinocchio as pin
from problem import VALUES, Vector
from timing import calls

from peers import Prepared
from peers.relative import absolute, relative

NAME, SIZES = "Pinocchio, aba", (20, 50, 200)


def prepare(n: int) -> Prepared:
    """Springs as joint torques, the thrust as a force fixed in the last link."""
    m, l = VALUES["mass"] / n, VALUES["length"] / n
    model, thrust = _model(n, m, l), _thrust(n, l)
    data = model.createData()
    stiffness = np.full(n + 2, VALUES["bending_stiffness"] / l)
    stiffness[:3] = 0.0
    q, v, tau = np.zeros(n + 2), np.zeros(n + 2), np.zeros(n + 2)

    def rhs(y: Vector) -> Vector:
        q[:], v[:] = relative(y[: n + 2]), relative(y[n + 2 :])
        tau[:] = -stiffness * q
        return np.concatenate([y[n + 2 :], absolute(pin.aba(model, data, q, v, tau, thrust))])

    return Prepared(rhs, calls(partial(pin.aba, model, data, q, v, tau, thrust)))


def _model(n: int, m: float, l: float) -> pin.Model:
    model = pin.Model()
    model.gravity = pin.Motion.Zero()
    origin, start = pin.SE3.Identity(), pin.SE3.Identity()
    joint = model.addJoint(0, pin.JointModelPX(), origin, "x")
    joint = model.addJoint(joint, pin.JointModelPY(), origin, "y")
    inertia = pin.Inertia(m, np.array([l / 2, 0.0, 0.0]), m * l**2 / 12 * np.eye(3))
    for i in range(n):
        joint = model.addJoint(joint, pin.JointModelRZ(), start, f"link{i}")
        model.appendBodyToJoint(joint, inertia, origin)
        start = pin.SE3(np.eye(3), np.array([l, 0.0, 0.0]))
    return model


def _thrust(n: int, l: float) -> pin.StdVec_Force:
    """In the frame of every joint; only the last link bears one, at its tail."""
    P, nu = VALUES["follower_force"], VALUES["follower_angle"]
    force = -P * np.array([np.cos(nu), np.sin(nu), 0.0])
    forces = [pin.Force.Zero() for _ in range(n + 3)]
    forces[-1] = pin.Force(force, np.array([0.0, 0.0, l * force[1]]))
    return pin.StdVec_Force(forces)
