"""Speed of whole integrations at equal error, beside what is asked and what others offer.

    python benchmarks/integrate.py [--quick] [lines] [fixed] [peers]

lines: what is asked, each beside its opponent; fixed: the cost of a step and the thesis's job;
peers: the cheapest setting of every peer on the reference job. --quick leaves out heyoka unrolled,
which compiles for minutes. Peers that are not installed are named: pip install rodgen[bench].
References are those of data/, made by references.py.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import our_runs
from integrate_jobs import JOBS, R50, THESIS, Job, rod
from integrate_lines import lines
from peers.runs import GRACE, PEERS, families
from report import Report, duration
from rhs import flags, machine
from rich.console import Console
from rich.table import Table
from work_precision import ENOUGH, PATIENCE, best

import rodgen
from rodgen.loading import BuildError
from rodgen.scene import tables

ROUNDS = 5
PEER_PATIENCE = 15.0  # seconds that all settings of a peer may take
LEVELS = (4e-5, 4e-6, 6e-9)  # errors at which the peers are set side by side


def fixed(quick: bool, say: Callable[[str], None]) -> Table:
    """What is asked of steps, whatever their error."""
    report = Report("steps")
    for method in ("gauss", "radau"):
        what = f"{method}, a step of n=2000 over one of n=200, damped"
        if "gauss" not in tables.METHODS:  # radau is SciPy's yet, of dense matrices
            report.note(what, "-", "at most 11", "NOT: not offered")
            continue
        say(what)
        short, long = Job("n200", rod(200, 5.0, 1.0)), Job("n2000", rod(2000, 5.0, 1.0))
        pairs = [(_per_step(long, method), _per_step(short, method)) for _ in range(ROUNDS)]
        cost = statistics.median(a / b for a, b in pairs)
        shown = f"{cost:.1f} ({', '.join(duration(s) for s in pairs[-1])})"
        report.row(what, cost, 11.0, shown, "at most 11")
    say("the thesis's job")
    job = our_runs.contestant(THESIS, "thesis", method="semi_implicit_euler", step=0.0006)
    what = "n=50, 200 s, semi_implicit_euler, step 0.6 ms"
    try:
        report.time(what, _median(job.integrate), 0.5)
    except rodgen.RunError as error:
        report.note(what, "-", "at most 500 ms", f"NOT: {error}")
    return report.table


def _per_step(job: Job, method: str) -> float:
    run = rodgen.simulate(
        job.scene, target="c", method=method, rtol=1e-4, atol=1e-4, output_every=1.0
    )
    return run.stats.wall_seconds / (run.stats.steps + (run.stats.rejected or 0))


def peers(quick: bool, say: Callable[[str], None]) -> Table:
    """Every peer on the reference job, at its cheapest."""
    table = Table(title=f"peers: {R50.name}, 10 s; the cheapest setting within an error")
    for column in ("asked", "what", "off by", "time", "set-up", "cost"):
        table.add_column(column, justify="left" if column in ("what", "cost") else "right")
    for asked in LEVELS:
        for name in PEERS:
            if quick and name == "heyoka":
                continue
            say(f"{name} at {asked:.0e}")
            row = _peer(name, asked)
            say(f"    {', '.join(row)}")
            table.add_row(f"{asked:.0e}", *row)
        table.add_section()
    return table


def _peer(name: str, asked: float) -> list[str]:
    allowed = asked * GRACE.get(name, 1.0)
    found, why = best(families([name], R50, asked), R50, allowed, PEER_PATIENCE)
    if found is None or found.finish is None:
        return [name, "-", "-", "-", f"cannot be had: {why}"]
    setup = duration(found.who.setup) if found.who.setup else ""
    shown = duration(_median(found.who.integrate))
    return [found.who.label, f"{found.error:.1e}", shown, setup, found.finish.counts]


def _median(run: Callable[[], object]) -> float:
    """Seconds of five runs, or of one that takes long."""
    seconds: list[float] = []
    while len(seconds) < ROUNDS and sum(seconds) < ENOUGH / ROUNDS:
        start = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def say(what: str) -> None:
    """What is being looked at, on standard error: it takes minutes."""
    print(f"{time.strftime('%H:%M:%S')} {what}", file=sys.stderr, flush=True)


SECTIONS = {"lines": lines, "fixed": fixed, "peers": peers}


def main() -> None:
    console = Console(width=None if sys.stdout.isatty() else 230)  # else tables fold at 80
    quick, chosen = "--quick" in sys.argv, [a for a in sys.argv[1:] if a != "--quick"]
    if unknown := [name for name in chosen if name not in SECTIONS]:
        sys.exit(f"{unknown[0]}: one of --quick, {', '.join(SECTIONS)}")
    for name in chosen or SECTIONS:
        try:
            console.print(SECTIONS[name](quick, say))
        except (rodgen.RunError, BuildError) as error:
            console.print(f"{name}: {error}", markup=False)
    known = ", ".join(f"{job.name} {job.reference['error_estimate']:.0e}" for job in JOBS)
    console.print(
        f"errors of the references: {known}; no method is given more than {PATIENCE:g} s",
        highlight=False,
    )
    console.print(f"{machine()}; C flags: {flags()}", highlight=False)


if __name__ == "__main__":
    main()
