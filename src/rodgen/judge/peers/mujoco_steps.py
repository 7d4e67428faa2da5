"""MuJoCo: its steps of fixed length, from sample to sample in calls of mj_step."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from rodgen.judge.peers import loads
from rodgen.judge.peers.agreement import agreed
from rodgen.judge.peers.mjcf import driven, mjcf
from rodgen.judge.peers.settings import fastest, stable, steps
from rodgen.judge.peers.stretches import Stretch, integrated
from rodgen.judge.peers.tree import KNOWN, Tree
from rodgen.judge.precision.contestant import Array, Contestant, Deadline, Finish, NotModelledError
from rodgen.judge.precision.job import Job

mujoco.set_mju_user_warning(lambda _: None)  # else a file of warnings is left behind

ORDERS = {"Euler": 1.0, "implicitfast": 1.0, "RK4": 4.0}
LARGEST = 400  # links: mass matrices are full, and a step of more takes tens of milliseconds


def euler(job: Job, quick: bool) -> Iterator[Contestant]:
    """Semi-implicit Euler, MuJoCo's own choice; implicit in the damping of joints."""
    check(job)
    return _family(job, "Euler", stable(2.0, _oscillator(job)), quick)


def implicitfast(job: Job, quick: bool) -> Iterator[Contestant]:
    """Euler, implicit in all forces that depend on velocities, but for those of Coriolis."""
    check(job)
    return _family(job, "implicitfast", stable(2.0, _oscillator(job)), quick)


def rk4(job: Job, quick: bool) -> Iterator[Contestant]:
    """The Runge-Kutta method of fourth order."""
    check(job)
    return _family(job, "RK4", stable(2.8, fastest(job).rate), quick)


def check(job: Job) -> None:
    """Raise NotModelledError for what MuJoCo cannot model."""
    loads.refuse("MuJoCo", job.scene, KNOWN)
    if job.scene.rod.links > LARGEST:
        raise NotModelledError(
            f"MuJoCo: full mass matrices, too slow for more than {LARGEST} links"
        )


def _oscillator(job: Job) -> float:
    """Its frequency without damping [rad/s]."""
    found = fastest(job)
    return float(np.sqrt(abs(found.value * found.partner)))


def _family(job: Job, integrator: str, limit: float, quick: bool) -> Iterator[Contestant]:
    rod = Rod(job, integrator)
    off = agreed(job, rod.accelerations)
    return (_contestant(job, rod, integrator, step, off) for step in steps(job, limit, quick))


class Rod:
    """The scene in MuJoCo."""

    def __init__(self, job: Job, integrator: str = "Euler"):
        self.job, self.tree = job, Tree.of(job.scene)
        self.half, self.driven = len(job.start) // 2, driven(job.scene)
        self.model = mujoco.MjModel.from_xml_string(mjcf(job.scene, f'integrator="{integrator}"'))
        self.data = mujoco.MjData(self.model)
        self.enter(Stretch(*job.span, job.times, 0), job.span[0], job.start)

    def enter(self, stretch: Stretch, t: float, y: Array) -> None:
        """A state at a time in a stretch."""
        self.stretch = stretch
        self.given = loads.parameters(self.job.scene, stretch.middle, loads.PLAIN)
        mujoco.mj_resetData(self.model, self.data)
        self.data.time = t
        self.data.qpos[:] = self.tree.relative(y[: self.half])
        self.data.qvel[:] = self.tree.relative(y[self.half :])
        self.drive(t)

    def drive(self, t: float) -> None:
        """The loads at a time."""
        given = self.given(self.stretch.inside(t))
        self.data.ctrl[:] = [given[name] for name in self.driven]

    def accelerations(self, t: float, y: Array) -> Array:
        """In rodgen's coordinates."""
        self.enter(Stretch(t - 1.0, t + 1.0, np.array([]), 0), t, y)
        mujoco.mj_forward(self.model, self.data)
        return self.tree.absolute(self.data.qacc)

    @property
    def state(self) -> Array:
        """In rodgen's order."""
        tree, data = self.tree, self.data
        return np.concatenate([tree.absolute(data.qpos), tree.absolute(data.qvel)])

    def called(self, _: mujoco.MjModel, data: mujoco.MjData) -> None:
        """For every evaluation: loads that change with time."""
        Deadline.look()
        self.drive(data.time)


def _contestant(job: Job, rod: Rod, integrator: str, step: float, off: float) -> Contestant:
    def over(stretch: Stretch, y: Array) -> Array:
        rod.enter(stretch, stretch.first, y)
        rows, before = [], stretch.first
        for at in stretch.times:
            Deadline.look()
            count = max(1, round(np.ceil((at - before) / step * (1 - 1e-9))))
            rod.model.opt.timestep = (at - before) / count
            mujoco.mj_step(rod.model, rod.data, nstep=count)
            if not abs(rod.data.time - at) <= 1e-6 * step * count:  # it starts anew from chaos
                raise ArithmeticError("unstable: MuJoCo started anew")
            rod.data.time, before = at, at
            rows.append(rod.state)
        return np.array(rows)

    def integrate() -> Finish:
        if job.scene.timed:
            mujoco.set_mjcb_control(rod.called)
        try:
            y = integrated(job, over)
        finally:
            mujoco.set_mjcb_control(None)
        first, last = job.span
        return Finish(y, {"steps": round((last - first) / step)})

    return Contestant(
        "MuJoCo",
        integrator,
        "MuJoCo",
        "step",
        step,
        integrate,
        order=ORDERS[integrator],
        agreed=off,
    )
