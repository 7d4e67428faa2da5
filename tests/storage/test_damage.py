"""Files that are not as they were written: refused, or read to the same numbers."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rodgen
from rodgen.integrate.files.result_file import FileWarning
from rodgen.integrate.files.stream import Stream
from tests.storage.conftest import STATS, same
from tests.told import numbers, refused

Make = Callable[..., Any]
REFUSED = rodgen.InputError


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
                file.write_status("running", "", STATS)
        return path, file, given

    return make


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


@pytest.mark.parametrize("ended", [True, False])
def test_random_damage_is_refused_or_harmless(whole: Make, ended: bool) -> None:
    """Any other error ends the test."""
    path, _, _ = whole(ended)
    due = rodgen.load(path)
    refused = read = 0
    for content in _random(path.read_bytes(), 84, 3):
        path.write_bytes(content)
        try:
            same(rodgen.load(path), due)
            read += 1
        except REFUSED as error:
            assert "\n" not in str(error)  # noqa: PT017  where it may also be read
            refused += 1
        with warnings.catch_warnings():  # what is left is read without a traceback
            warnings.simplefilter("ignore", FileWarning)
            try:
                part = rodgen.load(path, strict=False)
            except REFUSED:
                continue
        assert set(part.t) <= set(due.t)
        for t, y in zip(part.t, part.y, strict=True):
            assert y.tobytes() == due.y[due.t == t].tobytes()
    assert refused > 60
    assert read < 15  # what happened to change nothing


def test_a_byte_of_each_kind_that_changes_is_noticed(whole: Make) -> None:
    path, file, _ = whole()
    content, header = path.read_bytes(), file._file.header
    places = [0, 3, 4, 7, 8, header.start - 1, header.start, len(content) - 1]
    places += [v.begin + k for v in header.variables.values() for k in (0, v.size - 1)]
    places += [content.index(word) for word in (b"rodgen 3", b'"links"', b"units", b"finished")]
    damaged = [content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :] for at in places]
    for changed in (*damaged, content.replace(b"rodgen 3", b"rodgen 2", 1)):  # another format
        path.write_bytes(changed)
        assert refused(rodgen.load, path).value == str(path)


def test_damage_is_named_and_the_rest_is_had(whole: Make, samples: Make, tmp_path: Path) -> None:
    """How many samples are lost between which times; those that are left, and the events."""
    path, file, given = whole()
    content, header = path.read_bytes(), file._file.header
    start, size = header.start, header.record.itemsize
    head, first, second = (content[:start], *(content[at:][:size] for at in (start, start + size)))
    rest = content[start + 2 * size :]
    with samples(12, rod={"mass": 3.5}).create(tmp_path / "other.nc", events=4) as made:
        given.append(made, 0, 12)
    of_another_run = (tmp_path / "other.nc").read_bytes()[start : start + size]

    def flipped(*at: int) -> bytes:
        damaged = bytearray(content)
        for byte in at:
            damaged[byte] ^= 4
        return bytes(damaged)

    several = flipped(*(start + k * size + 11 for k in (0, 4, 5)))
    text_of_the_run = flipped(header.variables["run"].begin + 40)
    # What is left of the file, the numbers that are said of it, and the samples that are good.
    for damaged, due, good in (
        (several, [1, 0.01, 2, 0.03, 0.06], [1, 2, 3, *range(6, 12)]),
        (content[: start + 7 * size + 100], [5, 0.06], [*range(7)]),
        (text_of_the_run, [], [*range(12)]),
        (head + second + first + rest, [2, 0.02], [*range(2, 12)]),
        (head + of_another_run + second + rest, [1, 0.01], [*range(1, 12)]),
    ):
        path.write_bytes(damaged)
        for reader in (rodgen.load, lambda at: Stream.reopen(at, given.model)):
            told = refused(reader, path)
            assert told.value == str(path)
            assert told.numbers == due
        with pytest.warns(FileWarning) as warned:
            part = rodgen.load(path, strict=False)
        said = str(warned[0].message).replace(str(path), "")
        assert numbers(said) == due
        np.testing.assert_array_equal(part.t, given.t[good])
        np.testing.assert_array_equal(part.y, given.y[good])
        assert len(part.events) == 2
        assert part.status == ("finished" if due else "interrupted")
        with pytest.warns(FileWarning):
            assert len(rodgen.load(path, max_samples=2, strict=False).t) == 2


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
