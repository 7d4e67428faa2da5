"""An open-ended run, whose parameters and method can be changed while it goes on."""

from __future__ import annotations

import math
import time
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from rodgen.arrays import Array
from rodgen.errors import InputError
from rodgen.integrate.diagnosis import step_doubts
from rodgen.integrate.methods.method_choice import Choice, choose
from rodgen.integrate.quantity_formulas import loads_at_work
from rodgen.integrate.stability import largest_stable_step
from rodgen.loading.generated_module import call_module
from rodgen.scene import Scene
from rodgen.scene.integration import AUTO
from rodgen.system import System
from rodgen_live.live_steps import LiveError, LiveSteps, SystemSteps
from rodgen_live.pull import Pull, check_number, check_point, with_idle_support, with_pull
from rodgen_live.sample_store import Chunk

__all__ = ["Live", "LiveError"]

# What a run is integrated with that is to be looked at alone, on rods of 20 to 1000 links 20 to 600
# times cheaper than at rtol 1e-8. The first is taken first: where a rod of many links swings about
# upright, errors of a thousandth of the angle hold more energy than the motion itself. After a kick
# or a pull of a single link of many, gauss rings on; of a rod with damping radau does not.
FOR_LOOKING: tuple[dict[str, Any], ...] = tuple(
    {"method": method, "rtol": rtol, "atol": 1e-3 * rtol}
    for method, rtol in (("gauss", 1e-5), ("gauss", 1e-3), ("radau", 1e-3))
)
SAFE = 0.5  # of the largest stable step
PAUSE = 0.5  # seconds that values have to rest before `auto` is asked anew


class Live(LiveSteps):
    """An open-ended run, with a sample every so many seconds.

    Only what is asked for here ends or holds it: the end of the span (which serves as a time scale
    alone), max_steps and events do not. Steps are not cut at samples: they are those of `simulate`
    over the span, and over others of that length behind it.

    A change or a kick acts at the end of the last step; where that is beyond a sample that was not
    given out yet, at the last one that was. So all samples that are given out later have felt it.

    system: what is run, as it was given last, without a place for a pull of its own; choice: its
    method, and why; rough: which of FOR_LOOKING is taken instead of that and of its tolerances,
    counted from 1, and 0 for none; pulls: whether the module has a place for a pull; pulling: the
    present pull, if any. To be used from one thread at a time; an InputError, for what cannot be
    used, leaves the run as it was.
    """

    choice: Choice
    rough = 0
    pulls = False
    pulling: Pull | None = None
    _placed: tuple[System, System] | None = None
    _origin: float  # start of the run [s]
    _choice_due = math.inf  # time by the clock [s] when `auto` is asked anew

    def __init__(self, system: System | Scene, model: ModuleType, every: float):
        self.system, self.model = System.of(system), model
        self._begin(self.system, _check_period(every))

    @property
    def scene(self) -> Scene:
        """Scene that is run."""
        return self.system.scene

    def _run_steps(self, goal: int, wall: float | None) -> Chunk:
        self._choose_again()
        return super()._run_steps(goal, wall)

    def warnings(self) -> list[str]:
        """Doubts about the step or the tolerance, as of the initial state."""
        with np.errstate(all="ignore"):
            return [*map(str, step_doubts(self._course.system, self.model))]

    def step_for(self, method: str) -> float:
        """Step [s] for a method of equal steps: half of the largest that is stable about the
        present state and about the one at the start; where it has no limit, that between samples.
        Raises InputError for a method that is unstable with every step."""
        start, here = self.system.settings.span[0], self.here()
        states = (start, self.system.y0), (float(here.t[-1]), here.y[-1])
        with np.errstate(all="ignore"):
            most = min(largest_stable_step(method, self.model, t, y, self.p) for t, y in states)
        if most == 0:
            allowed = f"one that is stable: with every step of {method} this rod swings ever wider"
            raise InputError("integrate.method", method, allowed)
        return float(f"{SAFE * most:.3g}") if math.isfinite(most) else self.every

    def restart(self, system: System | Scene | None = None) -> None:
        """Go back to the initial state, that of another system of the same structure if it is
        given; counts, works and energy given begin at zero."""
        system = System.of(system or self.system)
        self._check_structure(system)
        self._begin(system, self.every)

    def change(self, system: System | Scene) -> bool:
        """Go on with the parameters, method, step and tolerances of another system of the same
        structure; its initial state counts when the run is restarted.

        Returns whether the motion changes by that. Raises InputError.
        """
        system, now = System.of(system), self.system
        self._check_structure(system)
        same = system.settings == now.settings and np.array_equal(system.p, now.p)
        if same and not self._failed:
            self.system = system
            return False
        rough = self.rough * (_step_settings(system) == _step_settings(now))
        asked_for, choice = self._with_pull(system), self.choice
        if system.settings.method == now.settings.method == AUTO:
            # A change is to be seen at once: `auto` is asked once values rest.
            self._choice_due = time.perf_counter() + PAUSE
        else:
            choice = self._choose(asked_for)
        self._switch(system=system, choice=choice, rough=rough)
        return True

    def roughen(self, on: bool) -> None:
        """Go on by the next of FOR_LOOKING that is coarser than what the system asks for, or, if
        not on, by method and tolerances of the system again; another method, step or tolerance of
        the system takes that back. Raises InputError where it cannot be had."""
        self._switch(rough=self._next_coarser() if on else 0)

    def _next_coarser(self) -> int:
        asked = self.system.settings
        finest = 0.0 if asked.has_fixed_step else asked.rtol
        left = range(self.rough + 1, len(FOR_LOOKING))
        return next((i for i in left if FOR_LOOKING[i - 1]["rtol"] > finest), len(FOR_LOOKING))

    def kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        """Apply an impulse [N s] at a share of a link, from 0 at its start to 1 at its end: M du is
        its generalised force. Raises InputError."""
        check_point("kick", link, share, self.model.N)
        force = np.array([check_number("kick.impulse", part) for part in impulse])
        if force.shape != (2,):
            raise InputError("kick.impulse", impulse, "two numbers, in N s")
        t, y, _ = self._point_of_change()
        after = y.copy()
        # On one thread: others would be waited for longer than they help.
        with np.errstate(all="ignore"), _threads().limit(limits=1, user_api="blas"):
            M = call_module(self.model, "mass_matrix", t, y, self.p)
            pushed = self.model.generalised_force(y, self.p, link, share, force)
            try:
                jump = np.linalg.solve(M, pushed)
            except np.linalg.LinAlgError:
                jump = np.full(len(pushed), math.nan)
        after[len(jump) : 2 * len(jump)] += jump
        if not np.isfinite([*after, *self.energies(t, after, self.p)]).all():
            raise InputError("kick.impulse", impulse, "such that rates and energy stay finite")
        self._switch(after)

    @property
    def system_with_support(self) -> System:
        """System as its module has it: with a support that does nothing, where that has a place for
        a pull."""
        return self._with_idle_support(self.system)

    @property
    def system_in_use(self) -> System:
        """System as its module has it, with the method and tolerances in use, without a pull."""
        return self._with_method(self.system_with_support)

    def allow_pulls(self, model: ModuleType) -> None:
        """Go on in the same state by the module of `with_idle_support`, which has a place for
        pulls."""
        t, y, work = self._point_of_change()
        known, works = dict(zip(self.works, work, strict=True)), loads_at_work(model)
        work = np.array([known.get(name, 0.0) for name in works])
        self._go_on(t, y, work, self.every, model=model, pulls=True, works=works)

    def pull(self, pull: Pull | None) -> None:
        """Pull the rod from here on, or stop that if None; energy that the spring gains by the
        change is given. Raises InputError."""
        self._switch(pulling=pull)

    def _with_pull(self, system: System) -> System:
        """Another system of the same structure, with the present pull. Raises InputError."""
        placed = self._with_idle_support(system)
        return placed if self.pulling is None else with_pull(placed, self.pulling)

    def _with_idle_support(self, system: System) -> System:
        if not self.pulls:
            return system
        if self._placed is None or self._placed[0] is not system:
            self._placed = system, with_idle_support(system)
        return self._placed[1]

    def go_back(self, sample: Chunk) -> None:
        """Go back to an earlier sample."""
        t, y, work = float(sample.t[-1]), sample.y[-1], sample.work[-1]
        self._go_on(t, y, work, self.every, pulling=None)
        self.given = sample.given + self._energy(t, y, self.p) - self._energy(t, y, sample.p)

    def sample_every(self, every: float) -> None:
        """Set the seconds between two samples, from here on."""
        self._go_on(*self._point_of_change(), _check_period(every))

    def _begin(self, system: System, every: float) -> None:
        """Begin at the initial state of a system."""
        t, y = system.settings.span[0], system.y0
        choice = self._choose(self._with_idle_support(system))
        course = self._make_course(t, y, system=system, choice=choice, pulling=None, _origin=t)
        self._start(course, every, loads_at_work(self.model))
        *_, self.raised_start = energies = self.energies(t, y, self.p)
        self.given, self.energy_start = 0.0, sum(energies)

    def _switch(self, kicked: Array | None = None, **changes: Any) -> None:
        """Go on from here, after a kick if its state is given, and count the energy given."""
        t, y, work = self._point_of_change()
        before = self._energy(t, y, self.p)
        self._go_on(t, y if kicked is None else kicked, work, **changes)
        self.given += self._energy(t, self.y, self.p) - before

    def _go_on(
        self, t: float, y: Array, work: Array, every: float | None = None, **changes: Any
    ) -> None:
        """Go on from a state and works with other values of attributes. Raises InputError."""
        self._take_up(self._make_course(t, y, **changes), work, every)

    def _make_course(self, t: float, y: Array, **changes: Any) -> SystemSteps:
        """Run from (t, y) with other values of attributes, which stay as they were if it cannot.
        Raises InputError."""
        before = vars(self).copy()
        vars(self).update(changes)
        try:
            system = self._with_method(self._with_pull(self.system))
            with np.errstate(all="ignore"):
                return SystemSteps(system, self.model, t, y, self._origin)
        except Exception:  # whatever it is: the run goes on as it was
            self.__dict__ = before
            raise

    def _choose(self, system: System) -> Choice:
        """Choose the method of a system: its own, or what `auto` takes it to need."""
        self._choice_due = math.inf
        with np.errstate(all="ignore"):
            return choose(system, self.model)

    def _choose_again(self) -> None:
        """Choose the method, if that was put off while values were changed."""
        if time.perf_counter() >= self._choice_due:
            choice = self._choose(self._with_pull(self.system))
            if choice.method != self.choice.method:
                self._switch(choice=choice)
            self.choice = choice

    def _with_method(self, system: System) -> System:
        if self.rough:
            return system.with_settings(**FOR_LOOKING[self.rough - 1])
        return system.with_method(self.choice.method)

    def _check_structure(self, system: System) -> None:
        if system.structure != self.system.structure:
            allowed = f"of the same structure as {self.system.name}, which the module is for"
            raise InputError("scene", system.name, allowed)

    def energies(self, t: float, y: Array, p: Array) -> list[float]:
        """Kinetic energy of a state, that in springs, and that in gravity [J]."""
        with np.errstate(all="ignore"):
            return [float(one) for one in call_module(self.model, "energy", t, y, p)]

    def _energy(self, t: float, y: Array, p: Array) -> float:
        return sum(self.energies(t, y, p))


def _step_settings(system: System) -> tuple[Any, ...]:
    settings = system.settings
    return settings.method, settings.step, settings.rtol, settings.atol


def _check_period(every: float) -> float:
    if not (isinstance(every, int | float) and math.isfinite(every) and every > 0):
        raise InputError("every", every, "a positive number of seconds")
    return float(every)


@lru_cache(maxsize=1)
def _threads() -> ThreadpoolController:
    return ThreadpoolController()
