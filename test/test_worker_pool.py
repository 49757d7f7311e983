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
LARGE = """
import os, time
def large(folder, parent):
    open(f"{folder}/{os.getpid()}", "w").close()
    while os.getppid() == parent: time.sleep(0.01)
    return bytes(10_000_000)
"""
PROGRAM = """
import os, sys
from large_answers import large
from slider_drilling.process.worker_pool import map_in_processes
for _ in map_in_processes(large, [(sys.argv[1], os.getpid())] * 2, 2): pass
"""


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_call_gives_its_result(jobs: int) -> None:
    assert sorted(map_in_processes(divmod, ((k, 3) for k in range(7)), jobs)) == sorted(divmod(k, 3) for k in range(7))


def test_a_program_ends_after_a_failed_call() -> None:
    """More calls than workers: one of them waits for a worker when another fails."""
    code = "from slider_drilling.process.worker_pool import map_in_processes\n"
    code += "list(map_in_processes(divmod, [(1, 0)] + [(k, 3) for k in range(1000)], 2))"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)
    assert ended.returncode == 1 and "ZeroDivisionError" in ended.stderr


def alive(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
def test_workers_end_with_killed_parent(tmp_path: Path) -> None:
    modules, tmp_path = tmp_path / "modules", tmp_path / "workers"
    modules.mkdir(), tmp_path.mkdir()
    (modules / "large_answers.py").write_text(LARGE)
    environment = {**os.environ, "PYTHONPATH": f"{Path(__file__).parents[1]}:{modules}"}
    with subprocess.Popen([sys.executable, "-c", PROGRAM, tmp_path], env=environment) as process:
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


@pytest.mark.parametrize("name", ["queue", "random", "pickle", "selectors", "json", "multiprocessing"])
def test_files_of_the_working_directory_are_not_executed(name: str, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / f"{name}.py").write_text("raise SystemExit('executed')")
    monkeypatch.chdir(tmp_path)
    assert sorted(map_in_processes(divmod, [(7, 3), (8, 3)], 2)) == [(2, 1), (2, 2)]


def test_error_of_a_call_is_raised() -> None:
    with pytest.raises(ZeroDivisionError):
        list(map_in_processes(divmod, [(1, 1), (1, 0)], 2))


def test_prints_of_a_call_do_not_spoil_its_answer() -> None:
    assert list(map_in_processes(print, [("x",), ("y",)], 2)) == [None, None]


def test_worker_that_dies_is_an_error() -> None:
    with pytest.raises(RuntimeError, match="ended with code 3"):
        list(map_in_processes(os._exit, [(3,), (3,)], 2))
