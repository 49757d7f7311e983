"""Worker processes for jobs: a job that crashes its process costs itself only."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import tempfile
import threading
from pathlib import Path

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult, ResultNotSavedError
from slider_drilling.campaign.worker import ONE_THREAD, job_line
from slider_drilling.process.own_path import worker_command


class WorkerProcesses:
    """The worker processes of this process, one for each thread that runs jobs.

    A worker is kept from job to job because of what it has imported and compiled. `concurrent.futures` and joblib do
    not fit: there, one worker that dies fails all other jobs too.
    """

    def __init__(self) -> None:
        self._of_thread = threading.local()
        self._lock = threading.Lock()
        self._all: list[_WorkerProcess] = []
        self.stopped = False

    def run(self, job: Job, key: str, folder: Path) -> str | None:
        """Runs a job in the worker of this thread. A worker that died is replaced by the next call.

        Args:
            job: The job.
            key: Its key.
            folder: Of the results.

        Returns:
            None, or why there is no result.

        Raises:
            ResultNotSavedError: There is a result that cannot be written.
        """
        worker: _WorkerProcess | None = getattr(self._of_thread, "worker", None)
        with self._lock:
            if self.stopped:
                return "stopped"
            if worker is not None and job.new_process and worker.is_alive():
                worker.end()
            if worker is None or not worker.is_alive():
                self._of_thread.worker = worker = _WorkerProcess()
                self._all.append(worker)
        return worker.run(job, key, folder)

    def stop(self) -> None:
        """Kills all workers. Every `run` that waits returns, and no job is started any more."""
        with self._lock:
            self.stopped = True
            for worker in self._all:
                worker.kill()


class _WorkerProcess:
    """A process of `slider_drilling.campaign.worker`: one line in and one line out for each job."""

    def __init__(self) -> None:
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115  closed by `_how_it_ended`, or with this process
        # A session of its own: an interrupt at the terminal must not reach it before this process has stopped it.
        self._process = subprocess.Popen(
            worker_command("slider_drilling.campaign.worker", "main"),
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._stderr, text=True, encoding="utf-8",
            env={**os.environ, **ONE_THREAD}, start_new_session=True,
        )  # fmt: skip

    def is_alive(self) -> bool:
        return self._process.poll() is None

    def kill(self) -> None:
        self._process.kill()

    def end(self) -> None:
        self.kill()
        self._how_it_ended()

    def run(self, job: Job, key: str, folder: Path) -> str | None:
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(job_line(job, key, folder) + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except BrokenPipeError:
            line = ""
        if not line:
            return self._how_it_ended()
        answer = json.loads(line)
        if "not_saved" in answer:
            raise ResultNotSavedError(answer["not_saved"], key, JobResult(**answer["result"]))
        error: str | None = answer.get("error")
        return error

    def _how_it_ended(self) -> str:
        """Waits for the end of a process that died; returns its signal, or its exit code and last words."""
        code = self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        self._stderr.seek(0)
        lines = self._stderr.read().decode("utf-8", "replace").strip().splitlines()
        self._stderr.close()
        if code < 0:
            return f"its process was killed by {signal.Signals(-code).name}"
        return f"its process ended with code {code}" + (f": {lines[-1]}" if lines else "")


_CLUSTER_PROCESSES = WorkerProcesses()


def run_on_cluster_worker(job: Job, key: str, folder: str) -> str | None:
    """Runs a job in a process of a dask worker; see `WorkerProcesses.run`."""
    return _CLUSTER_PROCESSES.run(job, key, Path(folder))
