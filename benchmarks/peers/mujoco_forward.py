"""MuJoCo: mj_forward on two sliders and n hinges with springs, called from Python."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import mujoco
import numpy as np
from problem import VALUES, Vector
from timing import calls

from peers import Prepared
from peers.relative import absolute, relative

NAME, SIZES = "MuJoCo, mj_forward", (20, 50, 200)


def prepare(n: int) -> Prepared:
    """The thrust is an actuator at a site on the tail, so MuJoCo turns it with the link."""
    model = mujoco.MjModel.from_xml_string(mjcf(n, VALUES))
    data = mujoco.MjData(model)
    data.ctrl[0] = VALUES["follower_force"]

    def rhs(y: Vector) -> Vector:
        data.qpos[:], data.qvel[:] = relative(y[: n + 2]), relative(y[n + 2 :])
        mujoco.mj_forward(model, data)
        return np.concatenate([y[n + 2 :], absolute(data.qacc)])

    return Prepared(rhs, calls(partial(mujoco.mj_forward, model, data)))


def mjcf(n: int, values: Mapping[str, Any], option: str = "") -> str:
    """The model of a rod with these values; option: attributes of its option, the step say."""
    m, l = values["mass"] / n, values["length"] / n
    k, J, nu = values["bending_stiffness"] / l, m * l**2 / 12, values["follower_angle"]
    hinge = '<joint type="hinge" axis="0 0 1" stiffness="{}"/>'
    inertial = f'<inertial pos="{l / 2!r} 0 0" mass="{m!r}" diaginertia="{J!r} {J!r} {J!r}"/>'
    sliders = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
    first = f"<body>{sliders}{hinge.format(0)}{inertial}"
    later = f'<body pos="{l!r} 0 0">{hinge.format(repr(k))}{inertial}'
    gear = f"{-np.cos(nu):.17g} {-np.sin(nu):.17g} 0 0 0 0"
    return f"""<mujoco>
        <compiler angle="radian" boundmass="0" boundinertia="0"/>
        <option gravity="0 0 0" {option}><flag contact="disable" constraint="disable"/></option>
        <worldbody>
            {first}{later * (n - 1)}<site name="tail" pos="{l!r} 0 0"/>{"</body>" * n}
        </worldbody>
        <actuator><general site="tail" gear="{gear}"/></actuator>
    </mujoco>"""
