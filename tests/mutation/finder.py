"""Plugin of a run with a fault: cheap tests come first, and that which finds it is written down."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

NOTE = "RODGEN_FAULT_NOTE"  # where: a file
found = ""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Slow tests come last."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep the name of the first test that fails."""
    _keep(report)


def pytest_collectreport(report: pytest.CollectReport) -> None:
    """Keep the name of the first file that cannot be imported."""
    _keep(report)


def _keep(report: pytest.TestReport | pytest.CollectReport) -> None:
    global found
    found = found or (report.nodeid if report.failed else "")


def pytest_sessionfinish() -> None:
    """Write it down, with the processor time [s]."""
    note = {"by": found, "processor": round(sum(os.times()[:4]), 1)}
    Path(os.environ[NOTE]).write_text(json.dumps(note), encoding="utf-8")
