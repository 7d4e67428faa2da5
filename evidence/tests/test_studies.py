"""The benchmarks of studies do what they say, on the smallest sizes."""

from __future__ import annotations

import pytest

from rodgen_evidence.benchmarks.many_heyoka import Point, at, many_heyoka
from rodgen_evidence.benchmarks.study_engine import memories, study_engine
from rodgen_evidence.benchmarks.study_kills import study_kills
from rodgen_evidence.benchmarks.study_load import study_load
from rodgen_evidence.benchmarks.study_workers import bits, computing, waiting

pytestmark = [pytest.mark.nightly, pytest.mark.compiler]


def test_costs(capsys: pytest.CaptureFixture[str]) -> None:
    times = study_engine(40, 10)
    assert len(times.rows) == 6
    assert all(seconds > 0 and its > 0 for _, seconds, _, its in times.rows)
    whole, shares = times.rows[1], times.rows[2:4]
    assert whole[1] > whole[3]  # a whole study takes more than its runs
    assert all(seconds < its for _, seconds, _, its in shares)
    times.show()
    assert "in C" in capsys.readouterr().out


def test_memory(capsys: pytest.CaptureFixture[str]) -> None:
    memories((100,), (1,))
    assert capsys.readouterr().out.count(" MB, worker ") == 1


def test_kills() -> None:
    (one, *_) = study_kills(1, points=40, span=3.0, kills=2)
    assert one.same
    assert one.workers + one.clients <= 2


def test_load(capsys: pytest.CaptureFixture[str]) -> None:
    each = study_load(100, 2)
    assert len(each) == 3
    assert sum(each) > 0
    assert capsys.readouterr().out.splitlines()[-1].split()[0] == "100"


def test_workers() -> None:
    """Blocks that wait are done sooner by two workers, whatever else the machine has to do."""
    one, two = waiting(6, (1, 2), seconds=0.5)
    assert one < 1
    assert 1.2 < two / one < 2.5
    assert computing(2, (1,)) == [1.0]
    assert all(equal for *_, equal in bits(10, (2,), (3, 10)))


def test_time_at_equal_error() -> None:
    """On a straight line in logarithms, and no further than it goes."""
    points = [Point(1e-3, 1e-6), Point(4e-3, 1e-10)]
    assert at(1e-8, points) == pytest.approx(2e-3)
    assert at(1e-3, points) == pytest.approx(1e-3)


def test_many_runs_beside_heyoka() -> None:
    pytest.importorskip("heyoka", reason="it is no dependency")
    times = many_heyoka(3, 16, rounds=1)
    assert all(seconds > 0 and its > 0 for _, seconds, _, its in times.rows)
