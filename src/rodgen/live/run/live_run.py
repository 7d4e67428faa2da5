"""A live run in a thread of its own: it steps, keeps what came out, and tells one page of it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from rodgen.integrate.endings import FAILED, FINISHED
from rodgen.integrate.live import Live, LiveError, Samples
from rodgen.integrate.solution import Stats
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.page_state import PageState
from rodgen.live.run.plot import Plot
from rodgen.live.run.plot_spec import PlotSpec, transfer
from rodgen.live.run.worker import FRAME, Critical, Pace, Worker
from rodgen.live.samples import Chunk, Recorded, Store
from rodgen.live.texts import Present
from rodgen.loading import build_fastest
from rodgen.scene import Scene, SceneError

RUNNING, PAUSED, STOPPED = "running", "paused", "stopped"
SLICE = 0.012  # seconds of a frame, for steps
BEYOND = 1e6  # times the initial state, or 1
MOST_PLOTS, MOST_NOTES = 24, 200


class LiveRun(Worker):
    """A run, its samples, its plots, and the page that looks at it.

    Everything but `do`, `page` and `close` is for the run's own thread: others hand it work by
    `do`. taken: how many scenes it has taken up so far; file: the file that one of them came from,
    and its number, which a page notes. told: called in that thread when the status, the scene or
    the plots have changed.
    """

    def __init__(self, scene: Scene, told: Callable[[], None] = lambda: None):
        """The module of the scene should be in the cache already: it is loaded here."""
        super().__init__()
        self.told, self.page = told, PageState()
        self.status, self.message = PAUSED, ""
        self.plots: dict[str, Plot] = {}
        self._numbers, self.greeted = itertools.count(1), False  # whether it got its first plots
        self.pace, self.taken = Pace(), 0
        self.file: tuple[str, int] | None = None
        self.critical = Critical(lambda: self.do(self.page.touched))
        self.take(scene)
        self.start()

    def close(self) -> None:
        """End the thread, and with it the run."""
        self.critical.cancel()
        super().close()

    # The frames --------------------------------------------------------------------------------

    @property
    def busy(self) -> bool:
        """Whether another frame is due."""
        return self.status == RUNNING or self.page.waits

    @property
    def lost(self) -> bool:
        """Whether the state has grown so far that no other value leads on from it."""
        start = np.abs(self.live.scene.initial_state()).max(initial=1.0)
        return not np.abs(self.shown.y[-1]).max(initial=0.0) <= BEYOND * start

    def show(self) -> None:
        """Send the page what there is to see of the run."""
        self.page.show(self)

    def failed(self, message: str) -> None:
        """A defect stops the run, and the page says so."""
        self._stop(message)

    def slice(self) -> None:
        """Take as many steps as are due and fit into a frame."""
        if self.status != RUNNING:
            return
        due = self.pace.due()
        most = self.live.t + 1000 * self.live.every  # samples, where it goes as fast as it can
        failure = ""
        try:
            samples = self.live.advance(min(due, most), SLICE)
        except LiveError as error:
            samples, failure = error.samples, str(error)
        self._took(samples)
        if not len(samples.t):  # steps are slow: the picture moves on between samples
            self._look()
            self.page.moved()
        self.pace.reached(self.shown.t[-1])
        if failure:
            self._stop(failure)

    def _took(self, samples: Samples) -> None:
        if not len(samples.t):
            return
        chunk = self.store.add(samples)
        self.shown = chunk.last()
        self.page.fed(self.plots, chunk)

    def _stop(self, message: str) -> None:
        self.status, self.message = STOPPED, message
        self._changed()

    def _changed(self) -> None:
        """Tell the page that something beside the picture is other than before."""
        self.page.touched()
        self.told()

    # What can be asked of it: in its thread ----------------------------------------------------

    def take(self, scene: Scene) -> None:
        """Run another scene, from its start; plots go on as far as it has their quantities."""
        model = build_fastest(scene)
        live, catalogue = Live(scene, model, self._every(scene)), Catalogue(scene, model)
        plots = self.plots.values()
        specs = [transfer(p.spec, self.new_name(), p.catalogue, catalogue) for p in plots]
        self.plots = {spec.id: Plot(spec, catalogue) for spec in specs if spec}
        self.model, self.live, self.catalogue = model, live, catalogue
        self.taken += 1
        self.page.structure_changed()
        self._begin()

    def restart(self, scene: Scene | None = None) -> None:
        """Go back to the initial state."""
        self.live.restart(scene)
        self._begin()

    def _begin(self) -> None:
        live = self.live
        self.store = Store(live.states, live.works, live.energy_start)
        self.store.change(live.p, 0.0)
        self.history: list[str] = []
        if self.status != RUNNING:
            self.status = PAUSED
        self.message = ""
        self.page.restarted(self.plots)
        self._first()
        self._resume()
        self.critical.look(live.scene)
        self._warned()
        self._changed()

    def _first(self) -> None:
        """Take the sample at the start."""
        self._look()
        try:
            self._took(self.live.advance(self.live.scene.integrate.span[0], 0.0))
        except LiveError as error:
            self._took(error.samples)
            self.status, self.message = STOPPED, str(error)

    def _look(self) -> None:
        """Show the state as it is now, after something has changed it."""
        live, (t, y, work) = self.live, self.live.here()
        self.shown = Chunk(t, y, work, live.works, live.p, live.given, live.energy_start)

    def _resume(self) -> None:
        self.pace.start(float(self.shown.t[-1]))

    def _warned(self) -> None:
        """Look at what is wrong with the step or the tolerance, which have changed."""
        self.warnings = self.live.warnings()

    def go(self) -> None:
        """Let a run that is paused go on."""
        if self.status == PAUSED:
            self.status = RUNNING
            self._resume()
            self._changed()

    def pause(self) -> None:
        """Pause the run."""
        if self.status == RUNNING:
            self.status = PAUSED
            self._changed()

    def one_step(self) -> None:
        """Pause the run and take a single step of the method."""
        self.pause()
        if self.status == STOPPED:
            return
        try:
            self._took(self.live.one_step())
        except LiveError as error:
            self._took(error.samples)
            self._stop(str(error))
        self._changed()

    def change(self, scene: Scene, what: str = "") -> None:
        """Take other values of parameters, method, tolerances; what: in words, for the record."""
        then, p = self.live.scene.integrate, self.live.p
        self.live.change(scene)
        if scene.integrate.output_every != then.output_every:
            self.live.sample_every(self._every(scene))
        if scene.integrate != then:
            self._warned()
        if p is not self.live.p:
            self._changed_motion(what)
            self.critical.look(scene)
        if self.status == STOPPED:
            self.status, self.message = PAUSED, ""
        self._changed()

    def kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        """Kick a link by an impulse [N s]."""
        self.live.kick(link, share, impulse)
        self._changed_motion(f"kick ({impulse[0]:.4g}, {impulse[1]:.4g}) N s upon link {link}")
        if self.status == STOPPED:
            self.status, self.message = PAUSED, ""
        self._changed()

    def _changed_motion(self, what: str) -> None:
        """Keep apart the samples from here on: the rod moves otherwise."""
        self._note(what)
        self.store.change(self.live.p, self.live.given)
        self._look()

    def _note(self, what: str) -> None:
        """Note a change for the record; of a slider that is dragged, the last value."""
        key = what.partition(" = ")[0]
        if self.history and " = " in what and self.history[-1].startswith(f"{key} = "):
            self.history.pop()
        if what:
            self.history.append(f"{what} at t = {self.live.t:.6g} s")
            del self.history[MOST_NOTES:-1]  # the first ones, and the last

    def set_speed(self, speed: float) -> None:
        """Set the simulated seconds per second; infinite: as fast as it goes."""
        self.pace.speed = speed
        every = self._every(self.live.scene)
        if not math.isclose(every, self.live.every):
            self.live.sample_every(every)
        self._resume()
        self._changed()

    def _every(self, scene: Scene) -> float:
        """Seconds between samples: the scene's, or less where frames need it."""
        wanted = scene.integrate.output_every
        return min(wanted, self.pace.speed * FRAME) if math.isfinite(self.pace.speed) else wanted

    # Plots -------------------------------------------------------------------------------------

    def new_name(self) -> str:
        """A name of a plot, unlike all before."""
        return f"p{next(self._numbers)}"

    def add_plot(self, choice: dict[str, Any]) -> None:
        """Add a plot, which begins with what was before it. Raises SceneError."""
        if len(self.plots) >= MOST_PLOTS:
            raise SceneError("plots", len(self.plots) + 1, f"at most {MOST_PLOTS} on a page")
        spec = PlotSpec.from_dict({**choice, "id": self.new_name()}, self.catalogue)
        self.plots[spec.id] = plot = Plot(spec, self.catalogue)
        self.page.added(plot, self.store.chunks())
        self._changed()

    def remove_plot(self, name: str) -> None:
        """Remove the plot of this name, if it is there."""
        self.plots.pop(name, None)
        self.page.removed(name)
        self._changed()

    def arrange_plots(self, names: list[str]) -> None:
        """Show the plots in another order."""
        place = {name: at for at, name in enumerate(names)}
        ordered = sorted(self.plots, key=lambda name: place.get(name, len(place)))
        self.plots = {name: self.plots[name] for name in ordered}

    # What is taken away -------------------------------------------------------------------------

    def solution(self) -> Recorded:
        """All samples that are kept, each with the parameters that it was made with."""
        pieces = tuple(self.store.chunks()) or (self.shown,)
        work = np.concatenate([piece.work for piece in pieces])
        settings = self.live.scene.integrate.model_copy(update={"method": self.live.method})
        return Recorded(
            scene=self.live.scene.model_copy(update={"integrate": settings}),
            t=np.concatenate([piece.t for piece in pieces]),
            y=np.concatenate([piece.y for piece in pieces]),
            work={term: work[:, at] for at, term in enumerate(self.live.works)},
            stats=Stats.of(self.live.counts, self.live.seconds),
            status=FAILED if self.status == STOPPED else FINISHED,
            message="; ".join(filter(None, (self.message, *self.history))),
            model=self.model,
            pieces=pieces,
        )

    # For the page ------------------------------------------------------------------------------

    def present(self) -> Present:
        """The present of the run, for the panel of values."""
        live = self.live
        return Present(
            chunk=self.shown,
            counts=live.counts,
            seconds=live.seconds,
            ratio=self.pace.ratio if self.status == RUNNING else None,
            method=live.method,
            critical=self.critical.value,
        )
