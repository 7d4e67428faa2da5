"""Links to a run: a scene, its plots, a view and a state, packed into an address."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import tomli_w

from rodgen.errors import InputError
from rodgen.model.terms import EMPTYING
from rodgen.scene import Scene
from rodgen.scene.plain_tables import is_number, parse_toml
from rodgen_live.grid_recorder import Samples
from rodgen_live.run.scene_edits import LARGEST

if TYPE_CHECKING:
    from rodgen_live.run.live_run import LiveRun

PAGE = "page"  # the table beside those of the scene
MOST_STATES = 2000  # an address of more would be refused on its way


@dataclass(frozen=True)
class RunSample:
    """State of a run in a link: t [s], y, work of each load without potential since the start [J],
    given and start: energy that changes have put in, and total energy at the start [J]."""

    t: float
    y: tuple[float, ...]
    work: tuple[float, ...]
    given: float
    start: float

    @classmethod
    def from_dict(cls, table: Any) -> RunSample:
        """Make a state from the table in an address. Raises InputError."""
        try:
            single = [table[name] for name in ("t", "given", "start")]
            several = [tuple(table[name]) for name in ("y", "work")]
        except (TypeError, KeyError):
            raise _refusal("page.state", table) from None
        for value in (*single, *several[0], *several[1]):
            if not (is_number(value) and math.isfinite(value)):
                raise _refusal("page.state", value)
        t, given, start = map(float, single)
        return cls(t, several[0], several[1], given, start)

    def to_dict(self) -> dict[str, Any]:
        """Convert the state to a table for `from_dict`."""
        y, work = list(self.y), list(self.work)
        return {"t": self.t, "y": y, "work": work, "given": self.given, "start": self.start}


@dataclass(frozen=True)
class Link:
    """Content of an address: a scene; plots, as PlotSpec.from_dict takes them; view of the rod;
    state to begin in, or None for the scene's own; file: scene before any change, None if equal."""

    scene: Scene
    plots: tuple[dict[str, Any], ...] = ()
    view: str = ""
    state: RunSample | None = None
    file: Scene | None = None

    def pack(self) -> str:
        """Pack the link into letters, digits, - and _, for an address. Raises InputError for a
        scene that is too long for one."""
        page: dict[str, Any] = {"plots": list(self.plots), "view": self.view}
        if self.state is not None and len(self.state.y) <= MOST_STATES:
            page["state"] = self.state.to_dict()
        if self.file is not None:
            page["file"] = self.file.to_dict()
        text = self.scene.to_toml() + "\n" + tomli_w.dumps({PAGE: page})
        if len(text.encode()) > LARGEST:
            allowed = f"of at most {LARGEST} bytes in a link: save it as a file"
            raise InputError("scene", f"{len(text.encode())} bytes", allowed)
        return base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")

    @classmethod
    def unpack(cls, text: str) -> Link:
        """Read a link from a text that `pack` made. Raises InputError for anything else."""
        try:
            data = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
            content = zlib.decompressobj().decompress(data, LARGEST + 1)
        except (binascii.Error, zlib.error, ValueError):
            raise _refusal("scene", text[:40]) from None
        if len(content) > LARGEST:
            raise InputError("scene", f"{len(content)} bytes", f"at most {LARGEST} bytes")
        table = parse_toml(content, "this address")
        page = table.pop(PAGE, {})
        scene = Scene.from_dict(table)
        if not isinstance(page, dict):
            raise _refusal(PAGE, page)
        plots, view, state = page.get("plots", []), page.get("view", ""), page.get("state")
        file = Scene.from_dict(page["file"]) if "file" in page else None
        if not (isinstance(plots, list) and all(isinstance(one, dict) for one in plots)):
            raise _refusal("page.plots", plots)
        if not isinstance(view, str):
            raise _refusal("page.view", view)
        begun = None if state is None else RunSample.from_dict(state)
        return cls(scene, tuple(plots), view, begun, file)


def _refusal(field: str, value: Any) -> InputError:
    return InputError(field, value, "as the link button gives it")


def make_link(run: LiveRun, view: str) -> Link:
    """Make a link to a run: its scene and that of its file, its plots, a view, and the state that
    its page looks at. To be called in the thread of the run."""
    sample, placed = run.page_sample, run.live.system_with_support
    now = replace(sample, p=placed.p)  # without a pull
    before, after = (
        float(run.catalogue.columns(["total_energy"], chunk)[-1, 0]) for chunk in (sample, now)
    )
    own = np.isin(run.live.works, [*run.live.system.structure.loads, EMPTYING])
    work = sample.work[-1]
    plots = [plot.spec.to_dict() for plot in run.plots.values()]
    state = RunSample(
        t=float(sample.t[-1]),
        y=tuple(sample.y[-1].tolist()),
        work=tuple(work[own].tolist()),
        given=sample.given + float(work[~own].sum()) + after - before,
        start=sample.start,
    )
    choices = ({key: plot[key] for key in plot if key != "id"} for plot in plots)
    scene, file = run.live.scene, run.undo.file
    return Link(scene, tuple(choices), view, state, None if file == scene else file)


def apply_link(run: LiveRun, link: Link) -> None:
    """Begin a run of a link's scene in the link's state, with its plots. To be called in the thread
    of the run. Raises InputError for what cannot be had."""
    run.undo.file = link.file or link.scene
    if link.state is not None:
        state, live = link.state, run.live
        if (len(state.y), len(state.work)) != (live.states, len(live.works)):
            raise InputError("page.state", len(state.y), f"{live.states} numbers")
        sample = Samples(*map(np.array, ([state.t], [state.y], [state.work])))
        run.begin_at(sample, state.given, state.start)
    for choice in link.plots:
        run.add_plot(choice)
