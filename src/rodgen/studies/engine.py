"""Computation of a study into its store, block by block, by one process or by workers."""

from __future__ import annotations

import math
import random
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rodgen.errors import InputError, StudyError, install_command
from rodgen.integrate.stepper import NO_RESULT
from rodgen.progress import announce, format_duration, report_stages_to, show_count, show_work
from rodgen.scene import Scene
from rodgen.studies.adaptive import Rounds, refinement_rounds
from rodgen.studies.specification import Kept, Texts
from rodgen.studies.study import MANY, Study
from rodgen.system import System

if TYPE_CHECKING:
    import xarray as xr

    from rodgen.studies.cluster import Cluster
    from rodgen.studies.local import LocalWorker
    from rodgen.studies.store import StudyStore

PIECE = 0.2  # seconds of work of points that are refined: a round waits for its last
BLOCK = 1.0  # seconds of work of a block: a task costs milliseconds
TASKS = 200  # of all workers in a second, of which a scheduler bears several times as many
SHARES = 4  # blocks for every worker at least, so that none waits long for the others at the end
MOST_POINTS = 10**5  # of a block
MOST_BYTES = 32 * 10**6  # of what a block keeps
MOST_WORKERS = 1024
MISSING = f"studies need more: {install_command('study')}"


def study(
    scene: System | Scene | Study | str | Path,
    vary: Mapping[str, Any] | None = None,
    *,
    analysis: str = "run",
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
        A Scene, a System, the path of a scene, or a Study, which sets all arguments up to
        ``time_limit``.
    vary
        Values of every key, by dotted name, such as {"loads.follower.force": [5, 10]}, or a table
        {bounds, count, scale}.
    analysis
        "run", "critical", "modes", "static", "lyapunov", "floquet" or "cycle".
    keep
        Quantities kept of every point: reductions of a run such as "max(phi_19)", results of an
        analysis, or functions of a Solution.
    sample
        {method, count, seed}: draw points from ranges, in place of a grid.
    options
        Further arguments of the analysis.
    time_limit
        Time that a point may take, by the clock [s]; the first of a structure has a minute more.
        Runs that are computed side by side share the sum of their limits; where they exceed it,
        they are repeated one by one.
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
    ...     scene,
    ...     {"loads.follower.force": [1.5, 3.0]},
    ...     analysis="modes",
    ...     keep=["stable"],
    ...     workers=1,
    ... )
    >>> data["stable"].values.tolist()
    [1, 0]
    """
    if isinstance(scene, str | Path):
        scene = Scene.from_toml(scene)
    if not isinstance(scene, Study):
        if vary is None:
            raise InputError("vary", None, "values by keys of the scene")
        given: dict[str, Any] = {"sample": sample, "options": options, "time_limit": time_limit}
        scene = Study.of(scene, vary, analysis=analysis, keep=keep, **given)
    temporary = out is None
    with ExitStack() as stack:
        if progress is False:
            stack.enter_context(report_stages_to(lambda _: None))
        if out is None:
            out = Path(stack.enter_context(tempfile.TemporaryDirectory()), "study.zarr")
        run_study(
            *(scene, Path(out)),
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            adaptive=adaptive,
            by=by,
            yes=yes,
        )
        from rodgen.studies.store import read_store

        found = read_store(out)
        return found.load() if temporary else found


def run_study(
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
    """Compute a study into the store at a path; messages go to `said`.

    Raises what `study` raises.
    """
    check_extra(scheduled=scheduler is not None or workers != 1)
    from rodgen.studies.store import StudyStore

    path = path.absolute()
    _check_arguments(study, path, workers, scheduler, resume, yes)
    rounds = None if adaptive is None else refinement_rounds(study, adaptive, by)
    first = next(rounds) if rounds is not None else []
    how = "" if adaptive is None else f"{adaptive!r} {by or ''}"
    with ExitStack() as stack:
        there: StudyStore | None = None
        if path.exists():
            there = StudyStore.of(path, study, how)
            there.drop_damaged_blocks()
            if rounds is None and there.done_blocks().all():
                return
        pool = _choose_workers(stack, study, workers, scheduler, said)
        seconds, texts = PIECE, dict[tuple[str, ...], str]()
        if there is None or rounds is not None:
            with show_work(f"{study.name}: timing a point"):
                seconds, texts = pool.time_point(study)
        size = block_size(study, seconds, pool.count)
        plan = _describe_plan(study, seconds if there is None else None, pool.count, adaptive)
        announce(plan, said)
        store = there or StudyStore.create(path, study, size, how)
        if rounds is None:
            _compute_blocks(pool, store, texts, said)
        else:
            _refine(pool, store, rounds, first, max(1, int(PIECE / seconds)), texts, said)


def _describe_plan(
    study: Study, seconds: float | None, workers: int, adaptive: float | None
) -> str:
    """Describe what will be computed; seconds: time of a point, None where a store is resumed."""
    most = "" if adaptive is None else "at most "
    where = "1 processor" if workers == 1 else f"{workers} processors"
    plan = f"{study.name}: {most}{study.count} points on {where}"
    if seconds is None:
        return f"{plan}, of which those that are there are kept"
    about = format_duration(seconds * study.count / workers)
    return f"{plan}: about {about}, as points in the middle take"


def check_extra(scheduled: bool = True) -> None:
    """Raise ImportError where the extra `study` is not installed; scheduled: with Dask."""
    for name in ("zarr", "distributed", "cloudpickle", "cryptography") if scheduled else ("zarr",):
        if find_spec(name) is None:
            raise ImportError(f"{MISSING} (there is no {name})", name=name)


def block_size(study: Study, seconds: float, workers: int) -> int:
    """Choose the number of points of a block; seconds: processor time of a point."""
    from rodgen.studies.kept_quantities import variables

    sizes = ((64 if one.dtype.startswith("U") else 8, one.shape) for one in variables(study))
    each = sum(size * max(1, math.prod(shape)) for size, shape in sizes)
    shared = -(-study.count // (SHARES * workers))
    wanted = int(max(BLOCK, workers / TASKS) / max(seconds, 1e-9))
    return max(1, min(wanted, shared, MOST_POINTS, MOST_BYTES // each))


def _check_arguments(
    study: Study, path: Path, workers: Any, scheduler: Any, resume: bool, yes: bool
) -> None:
    """Raise InputError for arguments with which a study cannot be run."""
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


def _choose_workers(
    stack: ExitStack,
    study: Study,
    workers: int | None,
    scheduler: str | None,
    said: Callable[[str], None],
) -> LocalWorker | Cluster:
    if scheduler is None and workers in (None, 1):
        from rodgen.studies.local import LocalWorker

        with ExitStack() as alone, show_work(f"{study.name}: timing a point"):
            here = alone.enter_context(LocalWorker())
            if workers == 1 or here.is_enough(study):
                stack.push(alone.pop_all())
                return here
    from dask.system import CPU_COUNT

    from rodgen.studies.cluster import Cluster

    return stack.enter_context(Cluster(workers or CPU_COUNT, scheduler, said))


def _compute_blocks(
    pool: LocalWorker | Cluster, store: StudyStore, texts: Texts, said: Callable[[str], None]
) -> None:
    """Compute all blocks that are not marked. Raises StudyError where some are left."""
    done = store.done_blocks()
    layout, study = store.layout, store.study
    # Two clients that begin at once do not take the same blocks.
    start = random.SystemRandom().randrange(layout.count) if done.any() else 0
    order = (at % layout.count for at in range(start, start + layout.count))
    left = (block for block in order if not done[block] and not store.is_done(block))
    before = sum(layout.size(int(block)) for block in done.nonzero()[0])
    with show_count(study.name, study.count, before, said) as count:
        for block, failed in pool.compute(store, left, texts):
            count(layout.size(block), failed)
    missing = int((~store.done_blocks()).sum())
    if missing:
        raise StudyError(f"{missing} of {layout.count} blocks are not done")


def _refine(
    pool: LocalWorker | Cluster,
    store: StudyStore,
    rounds: Rounds,
    wanted: list[int],
    size: int,
    texts: Texts,
    said: Callable[[str], None],
) -> None:
    """Compute the points of every round, in pieces of so many points, but for those that the store
    has; wanted: the points of the first round."""
    from rodgen.studies.sampling import MARK
    from rodgen.studies.task import concatenate

    known = np.asarray(store.arrays[MARK][...]).ravel() != ""
    with show_count(store.study.name, store.study.count, int(known.sum()), said) as count:
        while True:
            new = [index for index in wanted if not known[index]]
            pieces = (new[at : at + size] for at in range(0, len(new), size))
            made = []
            for indices, arrays in pool.compute(store, pieces, texts):
                made.append((indices, arrays))
                count(len(indices), int(np.isin(arrays[MARK], NO_RESULT).sum()))
            if made:
                whole = [index for indices, _ in made for index in indices]
                store.write_points(whole, concatenate([arrays for _, arrays in made]))
                known[whole] = True
            try:
                wanted = rounds.send(store.read_points(wanted))
            except StopIteration:
                return
