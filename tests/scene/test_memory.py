"""The limit of memory, and how many links keep within it."""

from __future__ import annotations

import resource
from pathlib import Path

import pytest

from rodgen import memory
from rodgen.memory import check_memory, memory_limit
from tests.told import refused

MEGABYTE = 1e6


def test_as_many_links_as_fit_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(memory.SET, "1")
    for links in (1, 1000):
        check_memory("a thing", links, lambda n: MEGABYTE * n)
    for links in (1001, 10**6):
        told = refused(check_memory, "a thing", links, lambda n: MEGABYTE * n)
        assert (told.field, told.value, told.numbers[0]) == ("rod.links", links, 1000)
    told = refused(check_memory, "a thing", 10**5, lambda n: n * n * 8.0)
    assert told.numbers[0] == 11180  # the root of 1e9 / 8


def test_the_least_of_what_limits_it_counts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The machine, a container, the process, and above all what is asked for."""
    monkeypatch.delenv(memory.SET, raising=False)
    monkeypatch.setattr(memory.os, "sysconf", lambda name: 2**20 if "PHYS" in name else 4096)
    monkeypatch.setattr(memory, "GROUPS", tmp_path)
    monkeypatch.setattr(memory, "OWN_GROUPS", tmp_path / "cgroup")
    none = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
    monkeypatch.setattr(resource, "getrlimit", lambda _: none)
    assert memory_limit() == 2**31
    (tmp_path / "memory.max").write_text("max\n")
    assert memory_limit() == 2**31
    (tmp_path / "memory.max").write_text(f"{2**31}\n")
    assert memory_limit() == 2**30
    job = tmp_path / "batch" / "job"
    job.mkdir(parents=True)
    (tmp_path / "cgroup").write_text("1:name=systemd:/other\n0::/batch/job/step\n")
    (job / "memory.max").write_text(f"{2**30}\n")
    assert memory_limit() == 2**29
    (tmp_path / "memory" / "old").mkdir(parents=True)
    (tmp_path / "cgroup").write_text("4:cpu,memory:/old\n")
    (tmp_path / "memory" / "old" / "memory.limit_in_bytes").write_text(f"{2**29}\n")
    assert memory_limit() == 2**28
    monkeypatch.setattr(resource, "getrlimit", lambda _: (2**28, 2**40))
    assert memory_limit() == 2**27
    monkeypatch.setenv(memory.SET, "64")
    assert memory_limit() == 64e9
