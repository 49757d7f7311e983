"""A job in a process of its own, so that one that dies takes nothing else along."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult, ResultNotSavedError
from slider_drilling.campaign.worker import ONE_THREAD, as_line


class WorkerProcesses:
    """The worker processes of this one, each used by one thread; kept from job to job, for what they have loaded."""

    def __init__(self) -> None:
        self._mine = threading.local()
        self._lock = threading.Lock()
        self._all: list[_WorkerProcess] = []
        self.stopped = False

    def run(self, job: Job, key: str, folder: Path) -> str | None:
        """Run a job; None, or why there is no result. A process that died is replaced for the next job.

        Raises UnkeptError where there is a result and no room for it.
        """
        process: _WorkerProcess | None = getattr(self._mine, "process", None)
        with self._lock:
            if self.stopped:
                return "stopped"
            if process is None or not process.alive():
                self._mine.process = process = _WorkerProcess()
                self._all.append(process)
        return process.run(job, key, folder)

    def stop(self) -> None:
        """Kill them all: whoever waits in `run` hears of it, nothing is started any more."""
        with self._lock:
            self.stopped = True
            for process in self._all:
                process.kill()


class _WorkerProcess:
    def __init__(self) -> None:
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  closed by `_obituary`, or with this process
        self._process = subprocess.Popen(
            [sys.executable, "-m", "slider_drilling.campaign.worker"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said, text=True, encoding="utf-8",
            env=_environment(), start_new_session=True,
        )  # fmt: skip

    def alive(self) -> bool:
        return self._process.poll() is None

    def kill(self) -> None:
        self._process.kill()

    def run(self, job: Job, key: str, folder: Path) -> str | None:
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(as_line(job, key, folder) + "\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            return self._obituary()
        said = json.loads(answer)
        if "unkept" in said:
            raise ResultNotSavedError(said["unkept"], key, JobResult(**said["result"]))
        error: str | None = said.get("error")
        return error

    def _obituary(self) -> str:
        code = self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        self._said.seek(0)
        words = self._said.read().decode("utf-8", "replace").strip().splitlines()
        self._said.close()
        how = f"killed by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
        return f"its process was {how}" if code < 0 or not words else f"its process {how}: {words[-1]}"


def _environment() -> dict[str, str]:
    """This process's, with one thread each, and with the modules that this one finds (a user's own may lie there)."""
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
    return {**os.environ, **ONE_THREAD, "PYTHONPATH": path}


_HERE = WorkerProcesses()


def run_on_cluster_worker(job: Job, key: str, folder: str) -> str | None:
    """What a cluster's worker is sent: `Processes.run` in the processes of that worker."""
    return _HERE.run(job, key, Path(folder))
