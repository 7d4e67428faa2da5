"""All tables, two at a time."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed

from rodgen.errors import DoubtWarning
from rodgen_evidence.thesis.clamp import table_clamp
from rodgen_evidence.thesis.critical_forces import table_3_4, table_3_6
from rodgen_evidence.thesis.frequencies import table_3_1, table_3_2
from rodgen_evidence.thesis.largest_steps import table_4_1
from rodgen_evidence.thesis.mass_spring_table import table_3_5
from rodgen_evidence.thesis.outlook import table_outlook
from rodgen_evidence.thesis.run_times import table_4_2
from rodgen_evidence.thesis.static_deflection import table_3_3
from rodgen_evidence.thesis.table import ThesisTable

# What takes longest first; what needs the modules of another table after it.
TABLES: dict[str, Callable[[], ThesisTable]] = {
    "3.4": table_3_4,
    "3.6": table_3_6,
    "4.1": table_4_1,
    "3.5": table_3_5,
    "3.2": table_3_2,
    "3.1": table_3_1,
    "4.2": table_4_2,
    "3.3": table_3_3,
    "clamp": table_clamp,
    "outlook": table_outlook,
}
AT_ONCE = 2  # more would disturb the run times that are measured


def rebuild(done: Callable[[str], None] = lambda _: None) -> list[ThesisTable]:
    """Every table, with the time that it took; done: told the number of each that is there."""
    made: dict[str, ThesisTable] = {}
    # Started anew, not forked: this process has threads.
    context = multiprocessing.get_context("spawn")
    at_once = min(AT_ONCE, os.cpu_count() or 1)
    with ProcessPoolExecutor(at_once, context, initializer=_quietly) as pool:
        try:
            futures = {pool.submit(_make, number): number for number in TABLES}
            for future in as_completed(futures):
                made[futures[future]] = future.result()
                done(futures[future])
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                process.terminate()
            raise
    return [made[number] for number in sorted(TABLES)]


def _make(number: str) -> ThesisTable:
    begin = time.perf_counter()
    table = TABLES[number]()
    table.seconds = time.perf_counter() - begin
    return table


def _quietly() -> None:
    """Ctrl-C is for the process that waits; it ends the others. Tables have unstable states on
    purpose, and say themselves how far to trust their numbers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warnings.simplefilter("ignore", DoubtWarning)
