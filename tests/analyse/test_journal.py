"""Curves of commands that were killed: what is in the journal is not computed again, and the whole
is to the bit what it would have been."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from rodgen.analyse.curves import continuation
from rodgen.analyse.curves.curve import ContinuationProblem, CurvePoint, SpecialPoint
from rodgen.analyse.curves.journal import Journal, Step, use_journal
from rodgen.arrays import Array
from rodgen.result import doubt
from tests.analyse.test_interruption import _boundary, _cycles, _equilibria
from tests.sets import sets

COMMAND = {"command": "test"}


class _Near(ContinuationProblem):
    """A problem of which only the length of a change is asked for."""

    def __init__(self) -> None:
        self.weights = np.ones(4)

    def evaluate(self, u: Array) -> tuple[Array, Array]:
        raise AssertionError


NEAR = _Near()


class Killed(BaseException):
    """In place of a signal."""


def _both_ways() -> Any:
    """A straight column from the middle of the range, and the bent branch that crosses it."""
    follow, *_ = _equilibria(across=0.0)
    return lambda **given: follow(start=-8.0, branch_point=1, **given)


KINDS: dict[str, Callable[[], Any]] = {
    "branch": _both_ways,
    "boundary": lambda: _boundary()[0],
    "cycle": lambda: _cycles()[0],
}


def _kept(follow: Any, journal: Journal | None, last: float = np.inf) -> tuple[Any, int]:
    """The curve, of which the journal has what is new, and how many steps were computed; killed by
    the point of a number."""
    seen, steps = 0, 0
    step = continuation._Follower._try_step

    def counted(*given: Any) -> Any:
        nonlocal steps
        steps += 1
        return step(*given)

    def watch(_: Any) -> None:
        nonlocal seen
        seen += 1
        if seen >= last:
            raise Killed

    with pytest.MonkeyPatch.context() as patch, use_journal(journal):
        patch.setattr(continuation._Follower, "_try_step", counted)
        return follow(callback=watch), steps


@pytest.mark.parametrize("kind", sets(["branch", "boundary"], slow=["cycle"]))
def test_what_was_killed_goes_on_to_the_same_bits(kind: str, tmp_path: Path) -> None:
    """Killed early, then late, each time in the middle of a line; and at last begun anew in the
    place of a journal whose curves are others."""
    follow, path = KINDS[kind](), tmp_path / "curve.steps"
    whole, all_steps = _kept(follow, None)
    count = 2 * whole.sizes["point"] // 3
    journal: Journal | None = Journal(path, COMMAND)
    for last in (4, count):
        with pytest.raises(Killed):
            _kept(follow, journal, last)
        with path.open("ab") as file:
            file.write(b'0123abcd {"point": {"u"')
        journal = Journal.read(path)
        assert journal is not None
        assert journal.command == COMMAND
        assert journal.n_unread >= last - 3  # without a start, or two
    again, steps = _kept(follow, journal)
    xr.testing.assert_identical(again, whole)
    assert steps < all_steps - count / 2
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([lines[0], *lines[3:]]))  # its first start is no line of its own
    other, steps = _kept(follow, Journal.read(path))
    xr.testing.assert_identical(other, whole)
    assert steps == all_steps
    assert path.read_bytes().splitlines(keepends=True) == lines


def test_steps_are_read_as_they_were_written(tmp_path: Path) -> None:
    """Of numbers that few decimal digits have, and of what is not known."""
    u, tangent = np.array([0.1 + 0.2, -0.0, 1e-310, 4.0]), np.array([1 / 3, 2.0, 1e308, 0.0])
    point = CurvePoint(u, tangent, None, -1)
    ways = np.array([[1.0, 2.0], [3.0, 4.0]])
    special = [SpecialPoint("branch", u, 3, 0.7, ways, "why"), SpecialPoint("hopf", u)]
    step, path = (
        Step(point, special, [doubt("a\nnote", value=1 / 3), doubt("é")], 0.3, 2),
        tmp_path / "a.steps",
    )
    made = Journal(path, COMMAND)
    assert not path.exists()  # before there is anything to lose
    made.begin(NEAR, point)
    made.add(step)
    found = Journal.read(path)
    assert found is not None
    assert found.n_unread == 1
    found.begin(NEAR, point._replace(u=u + 1e-9))
    back = found.next_step()
    assert back is not None
    assert (back.notes, back.h, back.before) == (step.notes, 0.3, 2)
    for a, b in zip((back.point, *back.special), (point, *special), strict=True):
        np.testing.assert_equal(a._asdict(), b._asdict())
    assert found.next_step() is None
    other = Journal.read(path)
    assert other is not None
    other.begin(NEAR, point._replace(u=u + 1e-3))  # another curve: nothing of this one counts
    assert other.next_step() is None
    assert len(path.read_bytes().splitlines()) == 2
    other.discard()
    assert Journal.read(path) is None
