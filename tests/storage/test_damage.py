"""Files that are not as they were written: refused, or read to the same numbers."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.files.result_file import FileWarning
from rodgen.integrate.files.storage import Excerpt
from rodgen.integrate.files.stream import Stream
from rodgen.integrate.solution import Solution, Stats
from tests.scene.tables import NUMBER, refused

Make = Callable[..., Any]
STATS = Stats(10, 2, 30, 4, 5, 0.25)
FORMER = Path(__file__).with_name("format_2.netcdf")  # written by rodgen before checksums
REFUSED = rodgen.SceneError
# Content, the numbers that are said of it, and the samples that are left.
Damage = tuple[bytes, list[float], list[int]]
TEN = [*range(2, 12)]


@pytest.fixture
def whole(samples: Make, tmp_path: Path) -> Callable[..., tuple[Path, Stream, Any]]:
    """A file of a run with 12 samples of two links and two events, and what it is made from."""

    def make(ended: bool = True) -> tuple[Path, Stream, Any]:
        given, path = samples(12, links=2), tmp_path / "run.nc"
        with given.create(path, events=4) as file:
            given.append(file, 0, 12)
            file.add_event(0, given.t[1], given.y[1])
            file.add_event(1, given.t[7], given.y[7])
            if ended:
                file.finish("finished", "well", STATS)
            else:
                file.note("running", "", STATS)
        return path, file, given

    return make


def _same(one: Solution, other: Solution) -> None:
    assert (one.scene, one.stats) == (other.scene, other.stats)
    assert (one.status, one.message) == (other.status, other.message)
    assert one.energy_error == other.energy_error
    assert one.work.keys() == other.work.keys()
    pairs = [(one.t, other.t), (one.y, other.y)]
    pairs += [(one.work[term], other.work[term]) for term in one.work]
    for a, b in zip(one.events, other.events, strict=True):
        assert a[:2] == b[:2]
        pairs.append((a.y, b.y))
    for x, due in pairs:
        assert x.tobytes() == due.tobytes()


def _every_byte(content: bytes) -> Iterator[bytes]:
    """Each byte changed in turn, in one bit or in all."""
    for at in range(len(content)):
        damaged = bytearray(content)
        damaged[at] ^= 0xFF if at % 2 else 1 << at % 8
        yield bytes(damaged)


def _random(content: bytes, count: int, seed: int) -> Iterator[bytes]:
    """Bits flipped, parts cut out, inserted, repeated, and overwritten."""
    random = np.random.default_rng(seed)
    size = len(content)
    for k in range(count):
        at, other = (int(i) for i in random.integers(size, size=2))
        long = int(random.choice([1, 2, 4, 8, 100, 1000]))
        rest = content[at + long :]
        flipped = bytes([content[at] ^ 1 << int(random.integers(8))])
        yield (
            content[:at] + flipped + content[at + 1 :],
            content[:at],
            content[:at] + rest,
            content[:at] + random.bytes(long) + content[at:],
            content[:at] + random.bytes(long) + rest,
            content[:at] + content[other : other + long] + rest,
            content[:at] + bytes(long) + rest,
        )[k % 7]


def _refused_or_same(path: Path, due: Solution, cases: Iterator[bytes]) -> tuple[int, int]:
    """How many were refused, and how many read. Any other error ends the test."""
    refused = read = 0
    original = path.read_bytes()
    for content in cases:
        path.write_bytes(content)
        for reader in (rodgen.load, Excerpt):
            try:
                found = reader(path)
            except REFUSED as error:
                assert "\n" not in str(error)  # noqa: PT017
                refused += 1
                continue
            read += 1
            if reader is rodgen.load:
                _same(found, due)
            else:
                assert found.t.tobytes() == due.t.tobytes()
        with warnings.catch_warnings():  # what is left is read without a traceback
            warnings.simplefilter("ignore", FileWarning)
            try:
                part = rodgen.load(path, strict=False)
            except REFUSED:
                continue
        assert set(part.t) <= set(due.t)
        for t, y in zip(part.t, part.y, strict=True):
            assert y.tobytes() == due.y[due.t == t].tobytes()
    path.write_bytes(original)
    return refused, read


@pytest.mark.parametrize("ended", [True, False])
def test_random_damage_is_refused_or_harmless(whole: Make, ended: bool) -> None:
    path, _, _ = whole(ended)
    due = rodgen.load(path)
    refused, read = _refused_or_same(path, due, _random(path.read_bytes(), 42, 3))
    assert refused > 60
    assert read < 15  # what happened to change nothing


@pytest.mark.nightly
@pytest.mark.parametrize("ended", [True, False])
def test_much_random_damage_is_refused_or_harmless(whole: Make, ended: bool) -> None:
    path, _, _ = whole(ended)
    _refused_or_same(path, rodgen.load(path), _random(path.read_bytes(), 800, 4))


@pytest.mark.nightly
def test_any_byte_that_changes_is_noticed(whole: Make) -> None:
    """Header, padding, labels, scene, events, room for events, samples: every byte of a file."""
    path, _, _ = whole()
    for content in _every_byte(path.read_bytes()):
        path.write_bytes(content)
        with pytest.raises(REFUSED):
            rodgen.load(path)


def test_a_byte_of_each_kind_that_changes_is_noticed(whole: Make) -> None:
    path, file, _ = whole()
    content, header = path.read_bytes(), file._file.header
    places = [0, 3, 4, 7, 8, header.start - 1, header.start, len(content) - 1]
    places += [v.begin + k for v in header.variables.values() for k in (0, v.size - 1)]
    places += [content.index(word) for word in (b"rodgen 3", b'"links"', b"units", b"finished")]
    for at in places:
        damaged = bytearray(content)
        damaged[at] ^= 1
        path.write_bytes(damaged)
        for reader in (rodgen.load, Excerpt):
            with pytest.raises(REFUSED):
                reader(path)


@pytest.fixture
def damages(whole: Make, samples: Make, tmp_path: Path) -> dict[str, Damage]:
    """What can happen to the file."""
    path, file, _ = whole()
    content, header = path.read_bytes(), file._file.header
    start, size = header.start, header.record.itemsize
    places = [start + k * size for k in range(3)]
    other = samples(12, rod={"mass": 3.5})
    with other.create(tmp_path / "other.nc", events=4) as made:
        other.append(made, 0, 12)
    stranger = (tmp_path / "other.nc").read_bytes()[start : start + size]
    first, second = (content[at : at + size] for at in places[:2])

    def flipped(*at: int) -> bytes:
        damaged = bytearray(content)
        for byte in at:
            damaged[byte] ^= 4
        return bytes(damaged)

    return {
        "samples": (
            flipped(*(start + k * size + 11 for k in (0, 4, 5))),
            [1, 0.01, 2, 0.03, 0.06],
            [1, 2, 3, *range(6, 12)],
        ),
        "cut": (content[: start + 7 * size + 100], [5, 0.06], [*range(7)]),
        "text of the run": (flipped(header.variables["run"].begin + 40), [], [*range(12)]),
        "exchanged": (content[:start] + second + first + content[places[2] :], [2, 0.02], TEN),
        "of another run": (content[:start] + stranger + content[places[1] :], [1, 0.01], [1, *TEN]),
    }


def test_damage_is_named_and_the_rest_is_had(damages: Any, tmp_path: Path, samples: Make) -> None:
    """How many samples are lost between which times; those that are left, and the events."""
    given, path = samples(12), tmp_path / "run.nc"
    for content, numbers, good in damages.values():
        path.write_bytes(content)
        for reader in (rodgen.load, Excerpt, lambda at: Stream.reopen(at, given.model)):
            told = refused(reader, path)
            assert told.value == str(path)
            assert told.numbers == numbers
        with pytest.warns(FileWarning) as warned:
            part = rodgen.load(path, strict=False)
        said = str(warned[0].message).replace(str(path), "")
        assert [float(number) for number in NUMBER.findall(said)] == numbers
        np.testing.assert_array_equal(part.t, given.t[good])
        np.testing.assert_array_equal(part.y, given.y[good])
        assert len(part.events) == 2
        assert part.status == ("finished" if numbers else "interrupted")
        some = Excerpt(path, strict=False)
        assert some.notes
        np.testing.assert_array_equal(some.at(np.array([0, 3])).y, given.y[good][[0, 3]])
        with pytest.warns(FileWarning):
            assert len(rodgen.load(path, most=2, strict=False).t) == 2


def test_what_is_behind_a_checkpoint_may_be_damaged(whole: Make) -> None:
    path, file, given = whole(ended=False)
    header = file._file.header
    damaged = bytearray(path.read_bytes())
    damaged[header.start + 9 * header.record.itemsize + 20] ^= 1
    path.write_bytes(damaged)
    assert refused(Stream.reopen, path, given.model, most=10).numbers[0] == 1
    with Stream.reopen(path, given.model, most=9) as again:
        given.append(again, 9, 12)
    np.testing.assert_array_equal(rodgen.load(path).y, given.y)


def test_cut_anywhere_is_refused(whole: Make) -> None:
    path, _, given = whole(ended=False)
    content = path.read_bytes()
    for size in (*range(0, len(content), 397), len(content) - 1):
        path.write_bytes(content[:size])
        for reader in (rodgen.load, lambda at: Stream.reopen(at, given.model)):
            with pytest.raises(REFUSED):
                reader(path)


def test_former_format_is_read_and_said_to_be_unchecked(tmp_path: Path) -> None:
    """Values as rodgen 2 read them from its own file."""
    path = tmp_path / "former.nc"
    shutil.copy(FORMER, path)
    with pytest.warns(FileWarning, match="'rodgen 2'"):
        sol = rodgen.load(path)
    assert (sol.status, sol.stats.rhs, len(sol.t)) == ("finished", 233, 21)
    assert [event.t for event in sol.events] == [0.2401428290248537, 0.6953027319186382]
    np.testing.assert_allclose(sol.y[-1], [0.14240068, -0.66433358], rtol=1e-7)  # as printed
    assert sol.energy_error == 1.6733003004032465e-09
    assert Excerpt(path).notes
    assert refused(Stream.reopen, path).value == str(path)
    path.write_bytes(path.read_bytes().replace(b"rodgen 2", b"rodgen 3", 1))
    assert refused(rodgen.load, path).value == str(path)


@pytest.mark.filterwarnings("ignore::rodgen.integrate.files.result_file.FileWarning")
def test_damage_to_the_former_format_is_no_traceback(tmp_path: Path) -> None:
    path = tmp_path / "former.nc"
    for content in _random(FORMER.read_bytes(), 70, 5):
        path.write_bytes(content)
        for reader in (rodgen.load, Excerpt):
            with suppress(REFUSED):
                reader(path)


def test_version_of_a_checked_file_cannot_be_turned_back(whole: Make) -> None:
    path, _, _ = whole()
    path.write_bytes(path.read_bytes().replace(b"rodgen 3", b"rodgen 2", 1))
    assert refused(rodgen.load, path).value == str(path)
