"""Pinocchio: its articulated-body algorithm on two sliders and hinges, called from Python."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin

from rodgen.arrays import Array
from rodgen_evidence.report.interleaved_timing import calls
from rodgen_evidence.report.peers.peer import Prepared, rod
from rodgen_evidence.report.peers.tree import Tree


def prepare(links: int) -> Prepared:
    """Springs as joint torques, the thrust as a force fixed in the last link."""
    scene = rod(links)
    tree, half, given = Tree.of(scene), links + 2, scene.parameters
    model = _model(tree)
    thrust = _thrust(tree, given["follower_force"], given["follower_angle"])
    data, stiffness = model.createData(), np.array([0.0, 0.0, *tree.stiffness])
    q, v, tau = np.zeros(half), np.zeros(half), np.zeros(half)

    def rhs(y: Array) -> Array:
        q[:], v[:] = tree.relative(y[:half]), tree.relative(y[half:])
        tau[:] = -stiffness * q
        found = pin.aba(model, data, q, v, tau, thrust)
        return np.concatenate([y[half:], tree.absolute(found)])

    return Prepared(rhs, calls(partial(pin.aba, model, data, q, v, tau, thrust)))


def _model(tree: Tree) -> Any:
    model, l = pin.Model(), tree.length
    model.gravity = pin.Motion.Zero()
    origin, start = pin.SE3.Identity(), pin.SE3.Identity()
    joint = model.addJoint(0, pin.JointModelPX(), origin, "x")
    joint = model.addJoint(joint, pin.JointModelPY(), origin, "y")
    inertia = pin.Inertia(tree.mass, np.array([l / 2, 0.0, 0.0]), tree.inertia * np.eye(3))
    for i in range(tree.links):
        joint = model.addJoint(joint, pin.JointModelRZ(), start, f"link{i}")
        model.appendBodyToJoint(joint, inertia, origin)
        start = pin.SE3(np.eye(3), np.array([l, 0.0, 0.0]))
    return model


def _thrust(tree: Tree, P: float, nu: float) -> Any:
    """In the frame of every joint; only the last link bears one, at its tail."""
    force = -P * np.array([np.cos(nu), np.sin(nu), 0.0])
    forces = [pin.Force.Zero() for _ in range(tree.links + 3)]
    forces[-1] = pin.Force(force, np.array([0.0, 0.0, tree.length * force[1]]))
    return pin.StdVec_Force(forces)
