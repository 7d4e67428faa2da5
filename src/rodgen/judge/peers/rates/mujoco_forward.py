"""MuJoCo: mj_forward on two sliders and hinges with springs, called from Python."""

from __future__ import annotations

from functools import partial

import mujoco
import numpy as np

from rodgen.judge.peers.mjcf import driven, mjcf
from rodgen.judge.peers.rates.prepared import Prepared, at_most, rod
from rodgen.judge.peers.tree import Tree
from rodgen.judge.precision.contestant import Array
from rodgen.judge.timing import calls

LARGEST = 500  # links: mass matrices are full


def prepare(links: int) -> Prepared:
    """The thrust is an actuator at a site on the tail, so MuJoCo turns it with the link."""
    at_most("MuJoCo", links, LARGEST, "full mass matrices are too slow")
    scene = rod(links)
    tree, half = Tree.of(scene), links + 2
    model = mujoco.MjModel.from_xml_string(mjcf(scene))
    data = mujoco.MjData(model)
    data.ctrl[:] = [scene.parameters[name] for name in driven(scene)]

    def rhs(y: Array) -> Array:
        data.qpos[:], data.qvel[:] = tree.relative(y[:half]), tree.relative(y[half:])
        mujoco.mj_forward(model, data)
        return np.concatenate([y[half:], tree.absolute(data.qacc)])

    return Prepared(rhs, calls(partial(mujoco.mj_forward, model, data)))
