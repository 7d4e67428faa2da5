"""MuJoCo: a scene in its XML; steps of fixed length from sample to sample, and mj_forward."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from math import cos, sin

import mujoco
import numpy as np

import rodgen
from rodgen.analyse.precision.contestant import Deadline
from rodgen.analyse.precision.job import Job, Stretch
from rodgen.arrays import Array
from rodgen_evidence.report.interleaved_timing import calls
from rodgen_evidence.report.peers import loads
from rodgen_evidence.report.peers.peer import (
    Over,
    Peer,
    Prepared,
    at_most,
    fastest,
    rod,
    stable,
    steps,
    whole_steps,
)
from rodgen_evidence.report.peers.tree import KNOWN, Tree

mujoco.set_mju_user_warning(lambda _: None)  # else a file of warnings is left behind

# The names of the actuators are those of the parameters that drive them.
ACTUATORS = ("follower_force", "tip_force_x", "tip_force_y")
MOST_RATES = 500  # links whose rates are timed


def mjcf(scene: rodgen.Scene, option: str = "") -> str:
    """The model; option: attributes of its option, the integrator say.

    The thrust acts at a site on the tail, with which MuJoCo turns it; the dead force at the tail in
    directions of a site of the world.
    """
    tree = Tree.of(scene)
    x, y = tree.base
    sliders = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
    before = f'<body pos="{x!r} {y!r} 0">{sliders if tree.translates else ""}'
    bodies = "".join(
        (f'<body pos="{tree.length!r} 0 0">' if i else before) + _hinge(tree, i) + _inertial(tree)
        for i in range(tree.links)
    )
    ends = f'<site name="tail" pos="{tree.length!r} 0 0"/>{"</body>" * tree.links}'
    flags = '<flag contact="disable" constraint="disable"/>'
    return f"""<mujoco>
        <compiler angle="radian" boundmass="0" boundinertia="0"/>
        <size memory="256M"/>
        <option gravity="0 {-tree.gravity!r} 0" {option}>{flags}</option>
        <worldbody><site name="world"/>{bodies}{ends}</worldbody>
        <actuator>{_actuators(scene)}</actuator>
    </mujoco>"""


def _hinge(tree: Tree, i: int) -> str:
    rest = f'springref="{tree.rest!r}"' if i == 0 else ""
    spring = f'stiffness="{tree.stiffness[i]!r}" damping="{tree.damping[i]!r}"'
    return f'<joint type="hinge" axis="0 0 1" {spring} {rest}/>'


def _inertial(tree: Tree) -> str:
    J = tree.inertia
    middle = f'pos="{tree.length / 2!r} 0 0"'
    return f'<inertial {middle} mass="{tree.mass!r}" diaginertia="{J!r} {J!r} {J!r}"/>'


def _actuators(scene: rodgen.Scene) -> str:
    nu = scene.parameters.get("follower_angle", 0.0)
    gears = {
        "follower_force": f'gear="{-cos(nu)!r} {-sin(nu)!r} 0 0 0 0"',
        "tip_force_x": 'refsite="world" gear="1 0 0 0 0 0"',
        "tip_force_y": 'refsite="world" gear="0 1 0 0 0 0"',
    }
    return "".join(f'<general site="tail" {gears[name]}/>' for name in driven(scene))


def driven(scene: rodgen.Scene) -> list[str]:
    """The parameters that the actuators follow, in their order."""
    return [name for name in ACTUATORS if name in scene.loads.parameters]


class MujocoRod(Peer):
    """Euler: semi-implicit, MuJoCo's own choice, implicit in the damping of joints; implicitfast:
    implicit in all forces that depend on velocities, but for those of Coriolis; RK4."""

    who = target = "MuJoCo"
    kind, knows = "step", KNOWN
    orders = {"Euler": 1.0, "implicitfast": 1.0, "RK4": 4.0}
    # A step of more links takes tens of milliseconds.
    most, why = 400, "full mass matrices, too slow"

    def __init__(self, job: Job, method: str = "Euler"):
        super().__init__(job, method)
        self.tree, self.driven = Tree.of(job.scene), driven(job.scene)
        self.model = mujoco.MjModel.from_xml_string(mjcf(job.scene, f'integrator="{method}"'))
        self.data = mujoco.MjData(self.model)
        self.enter(Stretch(*job.span, job.sample_times, 0), job.span[0], job.initial_state)

    def enter(self, stretch: Stretch, t: float, y: Array) -> None:
        """A state at a time in a stretch."""
        self.stretch = stretch
        self.given = loads.parameters(self.job.scene, stretch.middle, loads.PLAIN)
        mujoco.mj_resetData(self.model, self.data)
        self.data.time = t
        self.data.qpos[:], self.data.qvel[:] = map(self.tree.relative, np.split(y, 2))
        self.drive(t)

    def drive(self, t: float) -> None:
        """The loads at a time."""
        given = self.given(self.stretch.clip(t))
        self.data.ctrl[:] = [given[name] for name in self.driven]

    def apply_loads(self, _: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Apply loads that change with time, in every evaluation."""
        Deadline.check()
        self.drive(data.time)

    def accelerations(self, t: float, y: Array) -> Array:
        """Accelerations by mj_forward."""
        self.enter(Stretch(t - 1.0, t + 1.0, np.array([]), 0), t, y)
        mujoco.mj_forward(self.model, self.data)
        return self.tree.absolute(self.data.qacc)

    def settings(self, quick: bool) -> Iterator[float]:
        """Yield steps from the longest stable one; Euler's is that of an undamped oscillator."""
        found = fastest(self.job)
        undamped = float(np.sqrt(abs(found.value * found.partner)))
        limit = stable(2.8, found.rate) if self.method == "RK4" else stable(2.0, undamped)
        return steps(self.job, limit, quick)

    def integrator(self, setting: float) -> Over:
        """Step from sample to sample; loads that change with time are called back."""

        def over(stretch: Stretch, y: Array) -> Array:
            self.enter(stretch, stretch.first, y)
            mujoco.set_mjcb_control(
                self.apply_loads if self.job.scene.time_dependent_loads else None
            )
            try:
                times = pairwise([stretch.first, *stretch.times])
                return np.array([self._step(*pair, setting) for pair in times])
            finally:
                mujoco.set_mjcb_control(None)

        return over

    def _step(self, before: float, at: float, step: float) -> Array:
        """The state at a time from that at the time before."""
        Deadline.check()
        data, count = self.data, whole_steps(at - before, step)
        self.model.opt.timestep = (at - before) / count
        mujoco.mj_step(self.model, data, nstep=count)
        if not abs(data.time - at) <= 1e-6 * step * count:  # it starts anew from chaos
            raise ArithmeticError("unstable: MuJoCo started anew")
        data.time = at
        self.counts["nsteps"] += count
        return np.concatenate([self.tree.absolute(half) for half in (data.qpos, data.qvel)])


def prepare(links: int) -> Prepared:
    """The thrust is an actuator at a site on the tail, so MuJoCo turns it with the link."""
    at_most("MuJoCo", links, MOST_RATES, "full mass matrices are too slow")
    one = MujocoRod(Job("rod", rod(links)))

    def rhs(y: Array) -> Array:
        return np.concatenate([y[links + 2 :], one.accelerations(0.0, y)])

    return Prepared(rhs, calls(partial(mujoco.mj_forward, one.model, one.data)))
