"""Every benchmark starts, with sizes that take no time."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from rodgen_evidence.benchmarks import Times
from rodgen_evidence.benchmarks.analyse import analyse
from rodgen_evidence.benchmarks.cycles import Start, cycles, of_auto
from rodgen_evidence.benchmarks.cycles import of_rodgen as of_rodgen_cycle
from rodgen_evidence.benchmarks.exponents import exponents, of_heyoka, of_rodgen
from rodgen_evidence.benchmarks.main_job import main_job
from rodgen_evidence.benchmarks.many import many
from rodgen_evidence.benchmarks.rhs import rhs
from rodgen_evidence.benchmarks.study_points import study
from rodgen_evidence.benchmarks.thrust_tables import tables

pytestmark = [pytest.mark.nightly, pytest.mark.compiler]


def check(times: Times, capsys: pytest.CaptureFixture[str]) -> None:
    """All times are there, and the table is printed."""
    assert times.rows
    assert all(its > 0 for *_, its in times.rows)
    times.show()
    assert times.rows[-1][0].split(",")[0] in capsys.readouterr().out


def test_main_job(capsys: pytest.CaptureFixture[str]) -> None:
    check(main_job(((2, 1),), runs=1), capsys)


def test_rhs(capsys: pytest.CaptureFixture[str]) -> None:
    check(rhs((5,), peers=False), capsys)


def test_exponents(capsys: pytest.CaptureFixture[str]) -> None:
    check(exponents(3, 1.0, rounds=1), capsys)


def test_tangents_are_those_of_heyoka() -> None:
    """Both begin with the same frame, and follow the same motion for eight seconds."""
    pytest.importorskip("heyoka", reason="it is no dependency")
    np.testing.assert_allclose(of_rodgen(8), of_heyoka(8)[1], atol=1e-4)


def test_cycles(capsys: pytest.CaptureFixture[str]) -> None:
    check(cycles((2,), rounds=1), capsys)


def test_a_period_is_that_of_auto() -> None:
    """By collocation in 80 intervals, whose error falls by 2^8 from that in 40, 2e-9."""
    pytest.importorskip("bifpy", reason="it is no dependency")
    start = Start.of(2)
    assert of_auto(start, 80) == pytest.approx(of_rodgen_cycle(start), rel=2e-10)


def test_many_runs(capsys: pytest.CaptureFixture[str]) -> None:
    check(many((5,), 40, rounds=1), capsys)


def test_studies(capsys: pytest.CaptureFixture[str]) -> None:
    check(study(20, 3, 12), capsys)


def test_analyses(capsys: pytest.CaptureFixture[str]) -> None:
    check(analyse((5,), (5,), 100, rounds=1), capsys)


def test_tables(capsys: pytest.CaptureFixture[str]) -> None:
    check(tables(100, rounds=1, target="numpy"), capsys)


def test_live(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("playwright.sync_api")
    from rodgen_evidence.benchmarks.live import BROWSERS, live

    if not any(map(shutil.which, BROWSERS)):
        pytest.skip("no browser is installed, whose frames are counted")
    live(2.0, (5,), samples=2000)
    assert "frames/s" in capsys.readouterr().out
