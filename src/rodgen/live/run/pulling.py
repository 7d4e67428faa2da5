"""What of a live run kicks the rod, and pulls it by a spring to a place that is moved by hand."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from types import ModuleType

from rodgen.arrays import Array
from rodgen.integrate.pull import Pull, widened, with_place
from rodgen.integrate.samples import Samples
from rodgen.live.catalogue import Catalogue
from rodgen.live.run.marks import Mark
from rodgen.live.run.plot import Plot
from rodgen.live.run.plotting import Plotting
from rodgen.live.run.undo import Undo
from rodgen.live.samples import Chunk
from rodgen.loading import build_fastest
from rodgen.model.terms import PULL
from rodgen.scene import Structure
from rodgen.system import System


class Pulling(Plotting):
    """The part of a LiveRun that kicks and pulls; the far end of a pull goes where it was moved
    last, once a frame."""

    model: ModuleType
    past: Chunk | None
    undo: Undo
    _to: tuple[float, float] | None = None

    @abstractmethod
    def _changed_motion(self, what: str) -> None:
        """Keep apart the samples from here on."""

    @abstractmethod
    def _mended(self) -> None:
        """Let a run that was stopped go on, if its state is of use."""

    @abstractmethod
    def _look(self) -> None:
        """Show the state as it is now."""

    @abstractmethod
    def _resume(self) -> None:
        """Count time from the state that is shown."""

    def allow_pulls(self, made: Structure | None = None) -> System | None:
        """Go on in the same state by a module that has a place for a pull. The system whose module
        is to be made first, or None; made: the structure of one that is there, beside that of the
        run."""
        live = self.live
        if live.pulls:
            return None
        here, wanted = live.system.structure, with_place(live.system)
        if wanted.structure not in (made, here):
            return wanted
        model = build_fastest(wanted.structure)
        live.allow_pulls(model)
        self.model = model

        def wide(p: Array) -> Array:
            return widened(p, here, wanted.structure, live.p)

        self.store = self.store.widened(live.works, wide)
        self.store.change(live.p, live.given)
        self.catalogue = Catalogue(wanted, self.model, (PULL,))
        self.plots = {name: Plot(one.spec, self.catalogue) for name, one in self.plots.items()}
        if self.past is not None:
            self.past = self.store.near(float(self.past.t[-1]))
        self._anew()
        self.page.structure_changed()
        self._changed()
        return None

    def _anew(self) -> None:
        """Show the state, and all that is kept, as if nothing had been shown."""
        self._look()
        self.page.restarted(self.plots)
        for plot in self.plots.values():
            plot.beside = self.ghost
            self.page.added(plot, self.store.chunks())

    def back_to(self, mark: Mark) -> None:
        """Go on from the last sample before a kick or a pull; what came after it is forgotten."""
        sample = self.store.back_to(mark.t)
        self.marks.back_to(mark)
        self.live.go_back(Samples(sample.t, sample.y, sample.work), sample.p, sample.given)
        self._changed_motion("")
        self._anew()
        self._resume()
        self._mended()

    def kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        """Kick a link by an impulse [N s]."""
        self.live.kick(link, share, impulse)
        self._changed_motion(f"kick ({impulse[0]:.4g}, {impulse[1]:.4g}) N s upon link {link}")
        self.undo.note_mark(self.live.system, self.marks.every[-1])
        self._mended()

    def pull(self, pull: Pull) -> None:
        """Pull the rod from here on, where that is allowed. Raises InputError."""
        self._to = None
        self.live.pull(pull)
        self._changed_motion(f"pull at link {pull.link} by {pull.stiffness:.4g} N/m")
        self.undo.note_mark(self.live.system, self.marks.every[-1])
        self._mended()

    def move_pull(self, to: tuple[float, float]) -> None:
        """Move the far end of the pull, if there is one, before the next frame."""
        self._to = to

    def let_go(self) -> None:
        """End the pull, if there is one."""
        if self.live.pulling is not None:
            self._follow_hand()
            self.live.pull(None)
            self._changed_motion("pull ends")
            self._changed()

    def _follow_hand(self) -> None:
        """Have the far end where it was moved to. Raises InputError."""
        to, self._to = self._to, None
        now = self.live.pulling
        if now is not None and to is not None and to != now.to:
            self.live.pull(replace(now, to=to))
            self._changed_motion("")
            self.page.moved()
