"""Other users of the machine: what a study has open answers nobody who has no certificate of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import psutil
import pytest

from rodgen.studies.cluster import Cluster
from rodgen.studies.local import compute_in_process
from rodgen.studies.worker_tasks import SAFE_PATH
from tests.studies.test_workers import study_of

pytestmark = pytest.mark.slow
NOBODY = 65534
# Asks every port, as that user, who it is: in plain text, with a certificate of its own, and for
# pages. A port that is closed is asked first: that user may not be able to read what is imported.
STRANGER = """
import asyncio, encodings.idna, http.client, json, os, sys, urllib.request
import distributed
from distributed.core import rpc

ports, user = json.loads(sys.argv[1]), int(sys.argv[2])
own = distributed.Security.temporary().get_connection_args("client")

async def ask(port, scheme, given):
    try:
        async with rpc(f"{scheme}://127.0.0.1:{port}", timeout=1, connection_args=given) as other:
            await asyncio.wait_for(other.identity(), 5)
    except (OSError, TimeoutError, ValueError, MemoryError):  # of what speaks otherwise
        return []
    return [[port, scheme]]

def pages(port):
    for page in ("status", "json/counts.json", "health", "metrics"):
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/{page}", timeout=1)
        except (OSError, http.client.HTTPException):
            continue
        yield [port, "http"]

async def main(ports):
    asked = [ask(port, *how) for port in ports for how in (("tcp", None), ("tls", own))]
    return sum(await asyncio.gather(*asked), [])

def answers(ports):
    return asyncio.run(main(ports)) + [one for port in ports for one in pages(port)]

assert not answers([1])
if user:
    os.setgroups([])
    os.setgid(user)
    os.setuid(user)
print(json.dumps([os.getuid(), answers(ports)]))
"""


def listening() -> list[int]:
    """Ports at which this process and those that it has started listen."""
    own = psutil.Process()
    found = (c for one in (own, *own.children(True)) for c in one.net_connections("inet"))
    return sorted({one.laddr.port for one in found if one.status == psutil.CONN_LISTEN})


def answers(ports: list[int], user: int) -> set[str]:
    """By which ways somebody else is answered at a port."""
    command = [sys.executable, "-c", STRANGER, json.dumps(ports), str(user)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    uid, found = json.loads(done.stdout)
    assert uid == (user or os.getuid())
    return {way for _, way in found}


@pytest.mark.parametrize("user", [0, NOBODY])
def test_a_running_study_answers_no_stranger(user: int, scheduler: Any) -> None:
    """At its scheduler, its workers and for pages; one without certificates answers everybody."""
    if user and os.getuid() != 0:
        pytest.skip("needs root, to ask as another user")
    port = int(scheduler.scheduler_address.rpartition(":")[2])
    assert answers([port], user) == {"tcp"}  # its pages are among the settings of a study
    others = listening()  # of servers of other tests in this process, too
    with Cluster(2) as workers:
        ports = sorted({*listening()} - {*others})
        assert len(ports) >= 8  # scheduler, two workers and their nannies, and for pages
        assert answers(ports, user) == set()
        assert workers.client.submit(os.getuid).result() == os.getuid()


def test_workers_import_from_no_folder_of_others(tmp_path: Path) -> None:
    with Cluster(1) as workers:
        for folder in workers.client.run(lambda dask_worker: dask_worker.local_directory).values():
            above = [one for one in Path(folder).parents if one.name.startswith("rodgen-")]
            assert above
            assert above[0].stat().st_mode & 0o777 == 0o700
    assert not above[0].exists()


def test_nothing_is_imported_from_the_folder_of_a_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which may be that of somebody else: by workers, and by the process of a point alone."""
    for name in ("multiprocessing", "pickle", "typing", "subprocess"):
        text = f"open({str(tmp_path / 'flag')!r}, 'w').close()\nraise SystemExit(9)\n"
        (tmp_path / f"{name}.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    before = os.environ.get(SAFE_PATH)
    with Cluster(1) as workers:
        assert workers.client.submit(os.getcwd).result() == str(tmp_path)
    study = study_of()
    assert compute_in_process(study, [0])["status"].tolist() == ["finished"]
    assert not (tmp_path / "flag").exists()
    assert os.environ.get(SAFE_PATH) == before
