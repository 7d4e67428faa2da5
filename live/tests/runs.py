"""Live runs without a page: what a page would get of them."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

import rodgen
from live.tests.view import until
from rodgen.arrays import Array
from rodgen.scene import Scene
from rodgen_live.plot_quantities import Catalogue
from rodgen_live.run.live_run import LiveRun
from rodgen_live.sample_store import Chunk


def decoded(message: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Header and arrays of a message, by the rule alone: uint32, header, arrays from multiples of 8
    bytes on."""
    (length,) = struct.unpack_from("<I", message)
    header, at = json.loads(message[4 : 4 + length]), 4 + length
    arrays = {}
    for name, kind, count in header.pop("arrays"):
        assert at % 8 == 0  # typed arrays of the browser need it
        arrays[name] = np.frombuffer(message, f"<{kind}", count, at)
        at += -(-arrays[name].nbytes // 8) * 8
    assert at == len(message)
    return header, arrays


def does(run: LiveRun, *works: Callable[[], Any]) -> Any:
    """Each in the run's own thread, in turn; what comes of the last."""
    return [run.submit(work).result() for work in works][-1]


def to(run: LiveRun, t: float) -> None:
    """Samples up to a time, without a clock."""
    run.submit(lambda: run._record(run.live.advance(t, 60.0))).result()


def prepared(scene: Scene) -> tuple[Catalogue, Callable[..., Chunk]]:
    """The quantities of a scene, and chunks of times (K,) and states (K, states)."""
    model = rodgen.build(scene)
    catalogue = Catalogue(scene, model)
    p = model.parameters(**scene.parameters)

    def chunk(t: Array, y: Array, **other: Any) -> Chunk:
        works = catalogue.works
        return Chunk(t, y, np.zeros((len(t), len(works))), works, p, **other)

    return catalogue, chunk


class Page:
    """What a page sees."""

    def __init__(self, run: LiveRun):
        self.run = run
        self.headers: list[dict[str, Any]] = []  # with the arrays of their messages
        self.rows: dict[str, list[np.ndarray]] = {}
        run.page.attach(self.take)
        run.wake_up()

    def take(self, message: bytes) -> None:
        header, arrays = decoded(message)
        for name, array in arrays.items():
            if name.startswith("plot!"):
                self.rows[name[5:]] = [array]
            elif name.startswith("plot:"):
                self.rows.setdefault(name[5:], []).append(array)
        self.headers.append(header | arrays)

    def gets(self, count: int) -> dict[str, Any]:
        """Wait for so many messages or more; the last of them."""
        until(lambda: len(self.headers), lambda got: got >= count, "no message")
        return self.headers[-1]

    def acknowledge(self) -> None:
        self.run.page.acknowledge(self.headers[-1]["frame"])

    def table(self, plot: str, width: int) -> np.ndarray:
        """All rows of a plot up to now."""
        return np.concatenate(self.rows[plot]).reshape(-1, width)


def gets(run: LiveRun) -> Page:
    """A page that has come now, and has got all there is."""
    page = Page(run)
    page.gets(1)
    return page
