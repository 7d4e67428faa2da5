"""MuJoCo: its steps of fixed length, all in one call of mj_step."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np
from integrate_jobs import Job
from our_runs import FIXED, steps
from work_precision import Contestant, Finish

from peers.mujoco_forward import mjcf
from peers.relative import absolute, relative

mujoco.set_mju_user_warning(lambda _: None)  # else a file of warnings is left behind


def euler(job: Job, asked: float) -> Iterator[Contestant]:
    """Semi-implicit Euler, MuJoCo's own choice."""
    return _family(job, asked, "Euler", *FIXED["semi_implicit_euler"])


def rk4(job: Job, asked: float) -> Iterator[Contestant]:
    """The Runge-Kutta method of fourth order."""
    return _family(job, asked, "RK4", *FIXED["rk4"])


def _family(
    job: Job, asked: float, integrator: str, reach: float, least: float
) -> Iterator[Contestant]:
    if asked < least:
        raise ValueError(f"its order is too low for an error of {asked:.0e}")
    return (_contestant(job, integrator, count) for count in steps(job, reach))


def _contestant(job: Job, integrator: str, count: int) -> Contestant:
    given, n, (first, last) = job.scene.parameters, job.scene.rod.links, job.span
    if set(job.scene.structure.terms) != {"follower"}:
        raise ValueError("this model has a thrust and nothing else")
    option = f'timestep="{(last - first) / count!r}" integrator="{integrator}"'
    model = mujoco.MjModel.from_xml_string(mjcf(n, given, option))
    data, half = mujoco.MjData(model), n + 2

    def integrate() -> Finish:
        mujoco.mj_resetData(model, data)
        data.ctrl[0] = given["follower_force"]
        data.qpos[:], data.qvel[:] = relative(job.start[:half]), relative(job.start[half:])
        mujoco.mj_step(model, data, nstep=count)
        if abs(data.time - (last - first)) > 1e-6:  # it starts again where it is unstable
            raise ArithmeticError("unstable")
        y = np.concatenate([absolute(data.qpos), absolute(data.qvel)])
        return Finish(y, f"{count} steps")

    return Contestant(f"{integrator}, {count} steps", integrate)
