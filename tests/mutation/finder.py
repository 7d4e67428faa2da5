"""Plugin of a run with a fault: cheap tests come first, and that which finds it is written down."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

NOTE = "RODGEN_FAULT_NOTE"  # where: a file
ONLY = "RODGEN_FAULT_TESTS"  # names of tests, a line each, of which alone those are run that exist
failed: list[str] = []


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Slow tests come last."""
    if only := os.environ.get(ONLY):
        items[:] = [item for item in items if item.nodeid in only.splitlines()]
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep the name of a test that fails."""
    _keep(report)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    """Keep the name of a file that cannot be imported."""
    _keep(report)


def _keep(report: pytest.TestReport | pytest.CollectReport) -> None:
    if report.failed:
        failed.append(report.nodeid)


def pytest_sessionfinish() -> None:
    """Write them down, and the processor time [s]."""
    note = {"failed": failed, "processor": round(sum(os.times()[:4]), 1)}
    Path(os.environ[NOTE]).write_text(json.dumps(note), encoding="utf-8")
