"""A study beside a thread that reads standard input."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import os, sys, threading, time
import rodgen
threading.Thread(target=lambda: sys.stdin.buffer.read(1), daemon=True).start()
time.sleep(0.2)  # it waits by then
scene = rodgen.Scene.example("ziegler")
vary = {"loads.follower.force": [1.0, 2.0]}
data = rodgen.study(scene, vary=vary, what="modes", workers=1)
print(data.sizes["loads.follower.force"], flush=True)
os._exit(0)  # the thread would hold up the end
"""


@pytest.mark.slow
def test_it_does_not_wait_for_who_reads() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout is not None
            process.wait(timeout=600)
            assert process.stdout.read().strip() == "2"
        finally:
            process.kill()
