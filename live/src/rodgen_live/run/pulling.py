"""Kicks of the rod of a live run, and pulls by a spring to a place that is moved by hand."""

from __future__ import annotations

from dataclasses import replace

from rodgen.loading import build_fastest
from rodgen.scene import Structure
from rodgen.system import System
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.pull import Pull, widen_parameters, with_idle_support
from rodgen_live.run.change_history import ChangeMark
from rodgen_live.run.plot import Plot
from rodgen_live.run.run_record import RunRecord


class PulledRun(RunRecord):
    """A run whose rod can be kicked and pulled; the far end of a pull goes where it was moved last,
    once a frame."""

    _to: tuple[float, float] | None = None

    def allow_pulls(self, made: Structure | None = None) -> System | None:
        """Switch to a module that has a place for a pull, in the same state. Returns the system
        whose module is to be made first, or None; made: the structure of a module that is there,
        beside that of the run."""
        live = self.live
        if live.pulls:
            return None
        here, wanted = live.system.structure, with_idle_support(live.system)
        if wanted.structure not in (made, here):
            return wanted
        model = build_fastest(wanted.structure)
        live.allow_pulls(model)
        self.model = model
        self.store = self.store.widen(
            live.works, lambda p: widen_parameters(p, here, wanted.structure, live.p)
        )
        self.whole = None
        self.catalogue = Catalogue(wanted, self.model)
        self.plots = {name: Plot(one.spec, self.catalogue) for name, one in self.plots.items()}
        if self.past is not None:
            self.past = self.store.nearest(float(self.past.t[-1]))
        for plot in self.plots.values():
            plot.beside = self.ghost
        self.shown = live.here()
        self.page.resend(self)
        self._notify_page()
        return None

    def go_back_to(self, mark: ChangeMark) -> None:
        """Go back to the last sample before a kick or a pull; what came after it is forgotten."""
        sample = self.store.truncate(mark.t)
        self.marks.drop_from(mark)
        self.live.go_back(sample)
        self._note_change("")
        self.page.resend(self)
        self._restart_clock()
        self._clear_stop()

    def kick(self, link: int, share: float, impulse: tuple[float, float]) -> None:
        """Kick a link by an impulse [N s]."""
        self.live.kick(link, share, impulse)
        self._note_change(f"kick ({impulse[0]:.4g}, {impulse[1]:.4g}) N s upon link {link}")
        self.undo.note_mark(self.live.system, self.marks.every[-1])
        self._clear_stop()

    def pull(self, pull: Pull) -> None:
        """Pull the rod from here on, by a module that allows it. Raises InputError."""
        self._to = None
        self.live.pull(pull)
        self._note_change(f"pull at link {pull.link} by {pull.stiffness:.4g} N/m")
        self.undo.note_mark(self.live.system, self.marks.every[-1])
        self._clear_stop()

    def move_pull(self, to: tuple[float, float]) -> None:
        """Move the far end of the pull, if there is one, before the next frame."""
        self._to = to

    def release_pull(self) -> None:
        """End the pull, if there is one."""
        if self.live.pulling is not None:
            self._follow_hand()
            self.live.pull(None)
            self._note_change("pull ends")
            self._notify_page()

    def _follow_hand(self) -> None:
        """Move the far end of the pull to where the hand is. Raises InputError."""
        to, self._to = self._to, None
        now = self.live.pulling
        if now is not None and to is not None and to != now.to:
            self.live.pull(replace(now, to=to))
            self._note_change("")
            self.page.invalidate_picture()
