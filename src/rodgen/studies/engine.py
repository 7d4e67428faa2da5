"""A study from its specification to its store: blocks, and who computes them."""

from __future__ import annotations

import math
import random
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from rodgen.errors import InputError, StudyError
from rodgen.extras import how_to_have
from rodgen.integrate.endings import NO_RESULT
from rodgen.progress import announce, counting, duration, telling, working
from rodgen.scene import Scene
from rodgen.studies.adaptive import Rounds
from rodgen.studies.adaptive import rounds as rounds_of
from rodgen.studies.specification import Kept
from rodgen.studies.study import MANY, Study

if TYPE_CHECKING:
    import xarray as xr

    from rodgen.studies.store import Store
    from rodgen.studies.task import Arrays, Done

PIECE = 0.2  # seconds of work of points that are refined: a round waits for its last
BLOCK = 1.0  # seconds of work of a block: a task costs milliseconds
TASKS = 200  # of all workers in a second, of which a scheduler bears several times as many
SHARES = 4  # blocks for every worker at least, so that none waits long for the others at the end
MOST_POINTS = 10**5  # of a block
MOST_BYTES = 32 * 10**6  # of what a block keeps
MOST_WORKERS = 1024
MISSING = f"studies need more: {how_to_have('study')}"

Texts = dict[tuple[str, ...], str]


class Workers(Protocol):
    """Who computes blocks."""

    @property
    def count(self) -> int:
        """How many blocks are computed at once."""
        ...

    def timed(self, study: Study) -> tuple[float, Texts]:
        """Time that a point takes [s], and generated texts by their entries in the cache."""
        ...

    def compute(self, store: Store, blocks: Iterator[int], texts: Texts) -> Iterator[Done]:
        """Compute blocks, in whatever order they are done."""
        ...

    def pieces(
        self, store: Store, pieces: Iterator[list[int]], texts: Texts
    ) -> Iterator[tuple[list[int], Arrays]]:
        """Compute points that are no blocks; what comes out is not written."""
        ...


def study(
    scene: Scene | Study | str | Path,
    vary: Mapping[str, Any] | None = None,
    *,
    what: str = "run",
    keep: Sequence[Kept] | Kept = (),
    sample: Mapping[str, Any] | None = None,
    options: Mapping[str, Any] | None = None,
    time_limit: float | None = None,
    out: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    adaptive: float | None = None,
    by: str | None = None,
    yes: bool = False,
    progress: bool | None = None,
) -> xr.Dataset:
    """Compute a scene at many values of its keys.

    A point that cannot be computed has status "failed", its reason as message, and not-a-number;
    one that takes longer than it may has status "too long".

    Parameters
    ----------
    scene
        A Scene, the path of one, or a Study, which has all of what follows up to ``options``.
    vary
        Values of every key, by dotted name, such as {"loads.follower.force": [5, 10]}, or a table
        {bounds, count, scale}.
    what
        "run", "critical", "modes", "static", "lyapunov", "floquet" or "cycle".
    keep
        What is kept of every point: reductions of a run such as "max(phi_19)", quantities of an
        analysis, or functions of a Solution.
    sample
        {method, count, seed}: draw points from ranges, in place of a grid.
    options
        Further arguments of the analysis.
    time_limit
        Time that a point may take, by the clock [s]; the first of a structure has a minute more.
        Runs that are computed side by side have so much each together, and are else done again one
        by one.
    out
        Folder of the store, a Zarr group. Without it nothing is stored.
    workers
        Number of processes. By default one for each processor, or a single one if it takes less
        than 15 s. With 1 there is no Dask; the results are the same to the bit.
    scheduler
        Address of a Dask scheduler, whose workers are then used.
    resume
        Continue with an existing store.
    adaptive
        In a grid of two axes, compute only the points that are needed to find where neighbours
        differ, to this share of an axis (dimensionless). The other points have the status "".
    by
        The variable in which neighbours differ, or "variable > level". By default the first.
    yes
        Allow more than 1e8 points.
    progress
        False for no bar; by default there is one in a terminal and in a notebook.

    Returns
    -------
    xarray.Dataset
        Over the varied keys of a grid, or over the points of a sample.

    Raises
    ------
    InputError
        For values that cannot be used, before anything is computed.
    StudyError
        If workers or the scheduler are lost. The store keeps the points that are done.
    ImportError
        Without the extra `study`.

    Examples
    --------
    >>> import rodgen
    >>> scene = rodgen.Scene.example("ziegler")
    >>> data = rodgen.study(
    ...     scene, {"loads.follower.force": [1.5, 3.0]}, what="modes", keep=["stable"], workers=1
    ... )
    >>> data["stable"].values.tolist()
    [1, 0]
    """
    given = {"what": what, "keep": keep, "sample": sample, "options": options}
    made = scene if isinstance(scene, Study) else _made(scene, vary, **given, time_limit=time_limit)
    temporary = out is None
    with ExitStack() as stack:
        if progress is False:
            stack.enter_context(telling(lambda _: None))
        if out is None:
            out = Path(stack.enter_context(tempfile.TemporaryDirectory()), "study.zarr")
        run(
            *(made, Path(out)),
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            adaptive=adaptive,
            by=by,
            yes=yes,
        )
        from rodgen.studies.store import read

        found = read(out)
        return found.load() if temporary else found


def run(
    study: Study,
    path: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    adaptive: float | None = None,
    by: str | None = None,
    yes: bool = False,
    said: Callable[[str], None] = lambda _: None,
) -> None:
    """Compute a study into the store at a path; what it says on the way goes to `said`.

    Raises what `study` raises.
    """
    check_extra(scheduled=scheduler is not None or workers != 1)
    from rodgen.studies.store import Store

    path = path.absolute()
    _check(study, path, workers, scheduler, resume, yes)
    rounds = None if adaptive is None else rounds_of(study, adaptive, by)
    first = next(rounds) if rounds is not None else []
    how = "" if adaptive is None else f"{adaptive!r} {by or ''}"
    with ExitStack() as stack:
        there: Store | None = None
        if path.exists():
            there = Store.of(path, study, how)
            there.drop_damaged()
            if rounds is None and there.done().all():
                return
        pool = _workers(stack, study, workers, scheduler, said)
        seconds, texts = PIECE, Texts()
        if there is None or rounds is not None:
            with working(f"{study.name}: timing a point"):
                seconds, texts = pool.timed(study)
        size = size_of(study, seconds, pool.count)
        announce(_plan(study, seconds if there is None else None, pool.count, adaptive), said)
        store = there or Store.make(path, study, size, how)
        if rounds is None:
            _compute(pool, store, texts, said)
        else:
            _refine(pool, store, rounds, first, max(1, int(PIECE / seconds)), texts, said)


def _plan(study: Study, seconds: float | None, workers: int, adaptive: float | None) -> str:
    """What will be done; seconds: of a point, where that is known."""
    most = "" if adaptive is None else "at most "
    where = "1 processor" if workers == 1 else f"{workers} processors"
    plan = f"{study.name}: {most}{study.count} points on {where}"
    if seconds is None:
        return f"{plan}, of which those that are there are kept"
    return (
        f"{plan}: about {duration(seconds * study.count / workers)}, as points in the middle take"
    )


def check_extra(scheduled: bool = True) -> None:
    """Raise ImportError, in a line, where the extra is not installed; scheduled: with Dask."""
    for name in ("zarr", "distributed", "cloudpickle", "cryptography") if scheduled else ("zarr",):
        if find_spec(name) is None:
            raise ImportError(f"{MISSING} (there is no {name})", name=name)


def size_of(study: Study, seconds: float, workers: int) -> int:
    """How many points a block has, where one takes so many seconds of a processor."""
    from rodgen.studies.keep import variables

    each = sum(_bytes(one.dtype) * max(1, math.prod(one.shape)) for one in variables(study))
    shared = -(-study.count // (SHARES * workers))
    wanted = int(max(BLOCK, workers / TASKS) / max(seconds, 1e-9))
    return max(1, min(wanted, shared, MOST_POINTS, MOST_BYTES // each))


def _bytes(dtype: str) -> int:
    return 64 if dtype.startswith("U") else 8


def _made(scene: Any, vary: Any, **given: Any) -> Study:
    """A study from the arguments of `study`."""
    if isinstance(scene, str | Path):
        scene = Scene.from_toml(scene)
    if vary is None:
        raise InputError("vary", None, "values by keys of the scene")
    return Study.of(scene, vary, **given)


def _check(study: Study, path: Path, workers: Any, scheduler: Any, resume: bool, yes: bool) -> None:
    """Raise InputError for what cannot be run this way."""
    whole = isinstance(workers, int) and not isinstance(workers, bool)
    if workers is not None and not (whole and 0 < workers <= MOST_WORKERS):
        raise InputError("workers", workers, f"a whole number from 1 to {MOST_WORKERS}")
    if workers is not None and scheduler is not None:
        raise InputError("workers", workers, "absent: the scheduler has workers of its own")
    if study.count > MANY and not yes:
        allowed = f"at most {MANY:.0e} points, or asked for with --yes (yes=True)"
        raise InputError("vary", study.count, allowed)
    if path.exists() and not resume:
        allowed = "a place where there is nothing yet, or --resume (resume=True) to go on with it"
        raise InputError("out", str(path), allowed)


def _workers(
    stack: ExitStack,
    study: Study,
    workers: int | None,
    scheduler: str | None,
    said: Callable[[str], None],
) -> Workers:
    if scheduler is None and workers in (None, 1):
        from rodgen.studies.here import Here

        with ExitStack() as alone, working(f"{study.name}: timing a point"):
            here = alone.enter_context(Here())
            if workers == 1 or here.is_enough(study):
                stack.push(alone.pop_all())
                return here
    from dask.system import CPU_COUNT

    from rodgen.studies.cluster import Cluster

    return stack.enter_context(Cluster(workers or CPU_COUNT, scheduler, said))


def _compute(pool: Workers, store: Store, texts: Texts, said: Callable[[str], None]) -> None:
    """Compute all blocks that are not marked. Raises StudyError where some are left."""
    done = store.done()
    layout, study = store.layout, store.study
    # Two clients that begin at once do not take the same blocks.
    start = random.SystemRandom().randrange(layout.count) if done.any() else 0
    order = (at % layout.count for at in range(start, start + layout.count))
    left = (block for block in order if not done[block] and not store.is_done(block))
    before = sum(layout.points(int(block)) for block in done.nonzero()[0])
    with counting(study.name, study.count, before, said) as count:
        for one in pool.compute(store, left, texts):
            count(one.points, one.failed)
    missing = int((~store.done()).sum())
    if missing:
        raise StudyError(f"{missing} of {layout.count} blocks are not done")


def _refine(
    pool: Workers,
    store: Store,
    rounds: Rounds,
    wanted: list[int],
    size: int,
    texts: Texts,
    said: Callable[[str], None],
) -> None:
    """Compute the points that are asked for round by round, in pieces of a size, but those that the
    store has; wanted: those of the first round."""
    from rodgen.studies.layout import MARK
    from rodgen.studies.task import joined

    known = np.asarray(store.arrays[MARK][...]).ravel() != ""
    with counting(store.study.name, store.study.count, int(known.sum()), said) as count:
        while True:
            new = [index for index in wanted if not known[index]]
            pieces = (new[at : at + size] for at in range(0, len(new), size))
            made = []
            for indices, arrays in pool.pieces(store, pieces, texts):
                made.append((indices, arrays))
                count(len(indices), int(np.isin(arrays[MARK], NO_RESULT).sum()))
            if made:
                whole = [index for indices, _ in made for index in indices]
                store.put(whole, joined([arrays for _, arrays in made]))
                known[whole] = True
            try:
                wanted = rounds.send(store.take(wanted))
            except StopIteration:
                return
