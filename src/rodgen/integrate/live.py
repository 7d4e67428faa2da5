"""A run without an end, whose parameters and method can be changed while it goes on."""

from __future__ import annotations

import math
import time
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from rodgen.integrate.catalogue import loads_at_work
from rodgen.integrate.diagnosis import step_warnings
from rodgen.integrate.live_progress import Course, LiveError, Progress
from rodgen.integrate.methods.choose import Choice, choose
from rodgen.integrate.pull import Pull, check_number, check_point, pulled, with_place
from rodgen.integrate.samples import Samples
from rodgen.integrate.stability import largest
from rodgen.integrate.stepper import Array
from rodgen.loading.module import asked
from rodgen.model.terms import PULL
from rodgen.scene import Scene, SceneError
from rodgen.scene.integration import AUTO

__all__ = ["Live", "LiveError", "Samples"]

# What a run is integrated with that is to be looked at alone, on rods of 20 to 1000 links 20 to 600
# times cheaper than at rtol 1e-8. The first is taken first: where a rod of many links swings about
# upright, errors of a thousandth of the angle hold more energy than the motion itself. After a kick
# or a pull of a single link of many, gauss rings on; of a rod with damping radau does not.
FOR_LOOKING: tuple[dict[str, Any], ...] = tuple(
    {"method": method, "rtol": rtol, "atol": 1e-3 * rtol, "step": None}
    for method, rtol in (("gauss", 1e-5), ("gauss", 1e-3), ("radau", 1e-3))
)
SAFE = 0.5  # of the largest stable step
PAUSE = 0.5  # seconds that values have to rest before `auto` is asked anew


class Live(Progress):
    """A run of a scene that goes on as long as it is asked to, with a sample every so many seconds.

    Nothing but what is asked for here ends or holds it: the end of the scene's span (which counts
    as a time scale alone), max_steps and events do not. Steps are not cut at samples: they are
    those of `simulate` over the span, and over others of that length behind it.

    A change or a kick acts at the end of the last step; where that is beyond a sample that was not
    given out yet, at the last one that was. So all samples that are given out later have felt it.

    choice: the method that the scene has, and why; rough: which of FOR_LOOKING is taken instead of
    that and of the scene's tolerances, counted from 1, and 0 for none; given: energy [J] that
    changes and kicks have put in since the start; energy_start: total energy there [J]; pulls:
    whether the module has a place for a pull; pulling: the pull that there is. To be used from one
    thread at a time; a SceneError, for what cannot be used, leaves the run as it was.
    """

    choice: Choice
    rough: int
    given: float
    energy_start: float
    pulls = False
    pulling: Pull | None = None
    _placed: tuple[Scene, Scene] | None = None
    _origin: float  # start of the run [s]
    _warnings: list[str] | None

    def __init__(self, scene: Scene, model: ModuleType, every: float):
        self.scene, self.model = scene, model
        self._chooser, self.rough = Chooser(model), 0
        self._begin(scene, _period(every))

    def advance(self, to: float, wall: float) -> Samples:
        self._choose_again()
        return super().advance(to, wall)

    def one_step(self) -> Samples:
        self._choose_again()
        return super().one_step()

    def warnings(self) -> list[str]:
        """What is wrong with the step or the tolerance, as of the scene's initial state."""
        if self._warnings is None:
            with np.errstate(all="ignore"):
                self._warnings = list(step_warnings(self._course.scene, self.model, self.p))
        return self._warnings

    def step_for(self, method: str) -> float:
        """A step [s] for a method of equal steps: half of the largest that is stable about the
        state at present and about the one at the start; where it has no limit, that between
        samples. Raises SceneError for a method that is unstable with every step."""
        start, here = self.scene.integrate.span[0], self.here()
        states = (start, self.scene.initial_state()), (float(here.t[-1]), here.y[-1])
        with np.errstate(all="ignore"):
            most = min(largest(method, self.model, t, y, self.p) for t, y in states)
        if most == 0:
            allowed = f"one that is stable: with every step of {method} this rod swings ever wider"
            raise SceneError("integrate.method", method, allowed)
        return float(f"{SAFE * most:.3g}") if math.isfinite(most) else self.every

    def restart(self, scene: Scene | None = None) -> None:
        """Go back to the initial state, that of another scene of the same structure if it is given;
        counts, works and energy given begin at zero."""
        scene = scene or self.scene
        self._same_structure(scene)
        self._begin(scene, self.every)

    def change(self, scene: Scene) -> None:
        """Go on with the parameters, method, step and tolerances of another scene of the same
        structure; its initial state counts when the run is restarted."""
        self._same_structure(scene)
        same = scene.integrate == self.scene.integrate and scene.parameters == self.scene.parameters
        if same and not self._failed:
            self.scene = scene
            return
        before, self.rough = self.rough, self.rough * (_steps(scene) == _steps(self.scene))
        try:
            asked_for = self.with_pull(scene)
            choice = self._chooser.choose_sparingly(asked_for, self.scene, self.choice)
            self._change_to(scene, choice)
        except SceneError:
            self.rough = before
            raise

    def roughen(self, on: bool) -> None:
        """Go on by the next of FOR_LOOKING that is coarser than what the scene asks for, or by the
        method and tolerances of the scene again; another method, step or tolerance of the scene
        takes that back. Raises SceneError where it cannot be had."""
        before, self.rough = self.rough, self._coarser() if on else 0
        try:
            self._change_to(self.scene, self.choice)
        except SceneError:
            self.rough = before
            raise

    @property
    def coarsest(self) -> bool:
        """Whether nothing coarser can be taken for looking."""
        return self.rough == len(FOR_LOOKING)

    def _coarser(self) -> int:
        """The number of what is taken for looking next."""
        asked = self.scene.integrate
        finest = 0.0 if asked.fixed else asked.rtol
        left = range(self.rough + 1, len(FOR_LOOKING))
        return next((i for i in left if FOR_LOOKING[i - 1]["rtol"] > finest), len(FOR_LOOKING))

    def kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        """An impulse [N s] at a share of a link, from 0 at its start to 1 at its end."""
        t, y, work = self._here()
        after = kicked(self.model, t, y, self.p, link, share, impulse)
        self._go_on_by(self._made(self.scene, self.choice, t, after), t, y, work)

    @property
    def placed(self) -> Scene:
        """The scene as its module has it: where that has a place for a pull, with a support that
        does nothing."""
        return self._with_place(self.scene)

    def allow_pulls(self, model: ModuleType) -> None:
        """Go on in the same state by the module of the scene `with_place`, where there is none."""
        t, y, work = self._here()
        known, was = dict(zip(self.works, work, strict=True)), self.model
        self.model, self.pulls = model, True
        try:
            course = self._made(self.scene, self.choice, t, y)
        except Exception:  # whatever it is: the run goes on as it was
            self.model, self.pulls = was, False
            raise
        self._chooser = Chooser(model)
        self.works = (*loads_at_work(model), PULL)
        before = np.array([known.get(name, 0.0) for name in self.works])
        self._take_up(course, before, self.every)

    def pull(self, pull: Pull | None) -> None:
        """Pull the rod so from here on, or not at all; what the spring holds more by that is work
        of the pull. Raises SceneError."""
        t, y, work = self._here()
        before, was = self._energy(t, y, self.p), self.pulling
        self.pulling = pull
        try:
            course = self._made(self.scene, self.choice, t, y)
        except SceneError:
            self.pulling = was
            raise
        after = work.copy()
        after[self.works.index(PULL)] += self._energy(t, y, course.p) - before
        self._take_up(course, after)

    def with_pull(self, scene: Scene) -> Scene:
        """Another scene of the same structure, with the pull that there is. Raises SceneError."""
        placed = self._with_place(scene)
        return placed if self.pulling is None else pulled(placed, self.pulling)

    def _with_place(self, scene: Scene) -> Scene:
        if not self.pulls:
            return scene
        if self._placed is None or self._placed[0] is not scene:
            self._placed = scene, with_place(scene)
        return self._placed[1]

    def go_back(self, sample: Samples, p: Array, given: float) -> None:
        """Go on from one sample of before, at which p held and so much energy [J] was given."""
        t, y, work = float(sample.t[-1]), sample.y[-1], sample.work[-1]
        before, self.pulling = self._energy(t, y, p), None
        self._take_up(self._made(self.scene, self.choice, t, y), work, self.every)
        self.given = given + self._energy(t, y, self.p) - before

    def sample_every(self, every: float) -> None:
        """Other seconds between two samples, from here on."""
        t, y, work = self._here()
        self._take_up(self._made(self.scene, self.choice, t, y), work, _period(every))

    def _begin(self, scene: Scene, every: float) -> None:
        """Begin at the initial state of a scene."""
        t, y = scene.integrate.span[0], scene.initial_state()
        self.pulling = None
        held = self.with_pull(scene)
        choice = self._chooser.choose(held)
        course = self._made(scene, choice, t, y, t)
        works = loads_at_work(self.model)
        self._start(course, every, (*works, PULL) if self.pulls else works)
        self.scene, self.choice, self._warnings = scene, choice, None
        self._origin, self.given, self.energy_start = t, 0.0, self._energy(t, y, self.p)

    def _change_to(self, scene: Scene, choice: Choice) -> None:
        """Other values from here on."""
        t, y, work = self._here()
        course = self._made(scene, choice, t, y)
        self.scene, self.choice, self._warnings = scene, choice, None
        self._go_on_by(course, t, y, work)

    def _go_on_by(self, course: Course, t: float, y: Array, work: Array) -> None:
        """Take up another course, from the state y and the works up to here."""
        before = self._energy(t, y, self.p)
        self._take_up(course, work)
        self.given += self._energy(t, self.y, self.p) - before

    def _choose_again(self) -> None:
        """Choose the method, if that was put off while values were changed."""
        if self._chooser.due:
            choice = self._chooser.choose(self.with_pull(self.scene))
            if choice.method != self.choice.method:
                self._change_to(self.scene, choice)
            self.choice = choice

    def _made(
        self, scene: Scene, choice: Choice, t: float, y: Array, origin: float | None = None
    ) -> Course:
        """A course from (t, y), of a run that began at the origin [s]. Raises SceneError."""
        origin = self._origin if origin is None else origin
        scene = self.with_pull(scene).integrated_by(choice.method)
        if self.rough:
            settings = scene.integrate.model_copy(update=FOR_LOOKING[self.rough - 1])
            scene = scene.model_copy(update={"integrate": settings})
        with np.errstate(all="ignore"):
            return Course(scene, self.model, t, y, origin)

    def _same_structure(self, scene: Scene) -> None:
        if scene.structure != self.scene.structure:
            allowed = f"of the same structure as {self.scene.name}, which the module is for"
            raise SceneError("scene", scene.name, allowed)

    def _energy(self, t: float, y: Array, p: Array) -> float:
        """Total energy of a state [J]."""
        with np.errstate(all="ignore"):
            return float(sum(asked(self.model, "energy", t, y, p)))


def _steps(scene: Scene) -> tuple[Any, ...]:
    """By what steps a scene asks to be integrated."""
    settings = scene.integrate
    return settings.method, settings.step, settings.rtol, settings.atol


def _period(every: float) -> float:
    """Seconds between two samples. Raises SceneError."""
    if not (isinstance(every, int | float) and math.isfinite(every) and every > 0):
        raise SceneError("every", every, "a positive number of seconds")
    return float(every)


class Chooser:
    """The methods of scenes of one module: `auto` is not asked anew for every value that a slider
    passes."""

    def __init__(self, model: ModuleType):
        self._model, self._at, self._late = model, -math.inf, False

    def choose(self, scene: Scene) -> Choice:
        """What `auto` takes a scene to need, or the method that it asks for."""
        self._at, self._late = time.perf_counter(), False
        with np.errstate(all="ignore"):
            return choose(scene, self._model)

    def choose_sparingly(self, scene: Scene, before: Scene, present: Choice) -> Choice:
        """The choice for a scene, put off until its values rest if that before it left it to `auto`
        as well: a change is to be seen at once."""
        if not scene.integrate.method == before.integrate.method == AUTO:
            return self.choose(scene)
        self._at, self._late = time.perf_counter(), True
        return present

    @property
    def due(self) -> bool:
        """Whether a choice was put off that is to be made now."""
        return self._late and time.perf_counter() - self._at >= PAUSE


def kicked(
    model: ModuleType,
    t: float,
    y: Array,
    p: Array,
    link: int,
    share: float,
    impulse: tuple[float, float],
) -> Array:
    """The state (states,) after an impulse [N s] at a share of a link, from 0 at its start to 1 at
    its end: M du is its generalised force. Raises SceneError."""
    check_point("kick", link, share, model.N)
    force = np.array([check_number("kick.impulse", part) for part in impulse])
    if force.shape != (2,):
        raise SceneError("kick.impulse", impulse, "two numbers, in N s")
    # On one thread: others would be waited for longer than they help.
    with np.errstate(all="ignore"), _threads().limit(limits=1, user_api="blas"):
        M = asked(model, "mass_matrix", t, y, p)
        pushed = model.generalised_force(y, p, link, share, force)
        try:
            jump = np.linalg.solve(M, pushed)
        except np.linalg.LinAlgError:
            jump = np.full(len(pushed), math.nan)
        after: Array = y.copy()
        after[len(jump) : 2 * len(jump)] += jump
        finite = np.isfinite(after).all() and np.isfinite(asked(model, "energy", t, after, p)).all()
    if not finite:
        raise SceneError("kick.impulse", impulse, "such that rates and energy stay finite")
    return after


@lru_cache(maxsize=1)
def _threads() -> ThreadpoolController:
    return ThreadpoolController()
