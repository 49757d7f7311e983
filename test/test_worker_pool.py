"""Calls in worker processes: results in any order, and no process left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from slider_drilling.process.worker_pool import map_in_processes

PATIENCE = 60.0  # s
# Each worker says that it is there and, once its parent is not, has more to hand over than a pipe holds.
PROGRAM = """
import os, sys, time
from slider_drilling.process.worker_pool import map_in_processes
def large(folder, parent):
    open(f"{folder}/{os.getpid()}", "w").close()
    while os.getppid() == parent: time.sleep(0.01)
    return bytes(10_000_000)
for _ in map_in_processes(large, [(sys.argv[1], os.getpid())] * 2, 2): pass
"""


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_call_gives_its_result(jobs: int) -> None:
    assert sorted(map_in_processes(divmod, ((k, 3) for k in range(7)), jobs)) == sorted(divmod(k, 3) for k in range(7))


def alive(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
def test_workers_end_with_killed_parent(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", PROGRAM, tmp_path], cwd=Path(__file__).parents[1]) as process:
        deadline = time.monotonic() + PATIENCE
        while len(workers := [int(one.name) for one in tmp_path.iterdir()]) < 2:
            assert time.monotonic() < deadline, "two workers at work"
            assert process.poll() is None
            time.sleep(0.05)
        process.kill()
    while (left := [number for number in workers if alive(number)]) and time.monotonic() < deadline:
        time.sleep(0.05)
    for number in left:
        os.kill(number, signal.SIGKILL)
    assert left == []
