"""A run without an end, whose parameters and method can be changed while it goes on."""

from __future__ import annotations

import math
import time
from functools import lru_cache
from types import ModuleType

import numpy as np
from threadpoolctl import ThreadpoolController

from rodgen.integrate.catalogue import loads_at_work
from rodgen.integrate.diagnosis import step_warnings
from rodgen.integrate.live_progress import Course, LiveError, Progress
from rodgen.integrate.methods.choose import Choice, choose
from rodgen.integrate.samples import Samples
from rodgen.integrate.stepper import Array
from rodgen.loading.module import asked
from rodgen.scene import Scene, SceneError
from rodgen.scene.integration import AUTO
from rodgen.scene.plain import is_number

__all__ = ["Live", "LiveError", "Samples"]

PAUSE = 0.5  # seconds between two choices of a method while values are changed


class Live(Progress):
    """A run of a scene that goes on as long as it is asked to, with a sample every so many seconds.

    Nothing but what is asked for here ends or holds it: the end of the scene's span (which counts
    as a time scale alone), max_steps and events do not. Steps are not cut at samples: they are
    those of `simulate` over the span, and over others of that length behind it.

    A change or a kick acts at the end of the last step; where that is beyond a sample that was not
    given out yet, at the last one that was. So all samples that are given out later have felt it.

    choice: the method in use, and why; given: energy [J] that changes and kicks have put in since
    the start; energy_start: total energy there [J]. To be used from one thread at a time; a
    SceneError, for what cannot be used, leaves the run as it was.
    """

    choice: Choice
    given: float
    energy_start: float
    _origin: float  # start of the run [s]
    _warnings: list[str] | None

    def __init__(self, scene: Scene, model: ModuleType, every: float):
        self.scene, self.model = scene, model
        self._chooser = Chooser(model)
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
        self._change_to(scene, self._chooser.choose_sparingly(scene, self.scene, self.choice))

    def kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        """An impulse [N s] at a share of a link, from 0 at its start to 1 at its end."""
        t, y, work = self._here()
        after = kicked(self.model, t, y, self.p, link, share, impulse)
        self._go_on_by(self._made(self.scene, self.choice, t, after), t, y, work)

    def sample_every(self, every: float) -> None:
        """Other seconds between two samples, from here on."""
        t, y, work = self._here()
        self._take_up(self._made(self.scene, self.choice, t, y), work, _period(every))

    def _begin(self, scene: Scene, every: float) -> None:
        """Begin at the initial state of a scene."""
        t, y = scene.integrate.span[0], scene.initial_state()
        choice = self._chooser.choose(scene)
        course = self._made(scene, choice, t, y, t)
        self._start(course, every, loads_at_work(scene, self.model))
        self.scene, self.choice, self._warnings = scene, choice, None
        self._origin, self.given, self.energy_start = t, 0.0, self._energy(t, y)

    def _change_to(self, scene: Scene, choice: Choice) -> None:
        """Other values from here on."""
        t, y, work = self._here()
        course = self._made(scene, choice, t, y)
        self.scene, self.choice, self._warnings = scene, choice, None
        self._go_on_by(course, t, y, work)

    def _go_on_by(self, course: Course, t: float, y: Array, work: Array) -> None:
        """Take up another course, from the state y and the works up to here."""
        before = self._energy(t, y)
        self._take_up(course, work)
        self.given += self._energy(t, self.y) - before

    def _choose_again(self) -> None:
        """Choose the method, if that was put off while values were changed."""
        if self._chooser.due:
            choice = self._chooser.choose(self.scene)
            if choice.method != self.method:
                self._change_to(self.scene, choice)
            self.choice = choice

    def _made(
        self, scene: Scene, choice: Choice, t: float, y: Array, origin: float | None = None
    ) -> Course:
        """A course from (t, y), of a run that began at the origin [s]. Raises SceneError."""
        origin = self._origin if origin is None else origin
        scene = scene.integrated_by(choice.method)
        with np.errstate(all="ignore"):
            return Course(scene, self.model, t, y, origin)

    def _same_structure(self, scene: Scene) -> None:
        if scene.structure != self.scene.structure:
            allowed = f"of the same structure as {self.scene.name}, which the module is for"
            raise SceneError("scene", scene.name, allowed)

    def _energy(self, t: float, y: Array) -> float:
        """Total energy of a state [J], with the parameters in use."""
        with np.errstate(all="ignore"):
            return float(sum(asked(self.model, "energy", t, y, self.p)))


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
        """The choice for a scene, put off for a while if that before it left it to `auto`, too."""
        auto = scene.integrate.method == before.integrate.method == AUTO
        if auto and time.perf_counter() - self._at < PAUSE:
            self._late = True
            return present
        return self.choose(scene)

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
    if isinstance(link, bool) or not isinstance(link, int) or not 0 <= link < model.N:
        raise SceneError("kick.link", link, f"the number of a link, from 0 to {model.N - 1}")
    if not 0 <= _number("kick.share", share) <= 1:
        raise SceneError("kick.share", share, "from 0 at the start of the link to 1 at its end")
    force = np.array([_number("kick.impulse", part) for part in impulse])
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


def _number(field: str, value: object) -> float:
    """A finite number. Raises SceneError."""
    if is_number(value) and math.isfinite(value):
        return float(value)
    raise SceneError(field, value, "a finite number")
