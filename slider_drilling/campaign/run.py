"""Run a campaign's jobs, here or on a cluster; whatever has a result already is left as it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult, ResultFolder, ResultNotSavedError
from slider_drilling.campaign.worker_processes import WorkerProcesses
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder
from slider_drilling.process.shutdown import signal_exit_code


@dataclass(frozen=True)
class WorkerSettings:
    """Where jobs run: so many processes of this machine, or the workers of a `dask.distributed` scheduler; patience:
    s to wait for a scheduler that was lost."""

    processes: int = 1
    scheduler: str = ""
    patience: float = 60.0


@dataclass
class CampaignOutcome:
    """What became of a campaign's jobs.

    keys: of all, in their order; results: where they are kept; kept: had a result before; done: have one since; unkept:
    what could not be written; failed: why by key, of those that ended without; stopped: the exit code where a signal, a
    lost scheduler or a full disk ended the campaign early, else 0.
    """

    keys: list[str]
    results: ResultFolder
    already_done: int = 0
    completed: int = 0
    unsaved: dict[str, JobResult] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    stop_code: int = 0
    stop_reason: str = ""

    def result(self, key: str) -> JobResult | None:
        """What came of a job; None where there is nothing yet. Raises InputError where its file is no result."""
        if key in self.unsaved:
            return self.unsaved[key]
        return self.results.read(key) if self.results.path(key).is_file() else None

    @property
    def not_run(self) -> int:
        """Jobs that were not run to an end."""
        return len(set(self.keys)) - self.already_done - self.completed - len(self.unsaved) - len(self.failed)

    def summary(self) -> str:
        """What to tell the user of it, in a line."""
        parts = [
            f"{self.completed} run",
            f"{self.already_done} kept from before",
            f"{len(self.unsaved)} run and not kept",
            f"{len(self.failed)} failed",
        ]
        if self.not_run:
            parts.append(f"{self.not_run} not run")
        end = f"; {self.stop_reason}: the same command goes on from here" if self.stop_code else ""
        return ", ".join(part for part in parts if not part.startswith("0 ")) + end

    @property
    def exit_code(self) -> int:
        """Exit code: 0 where every job has a result, 1 where some failed, more where it was stopped."""
        return self.stop_code or int(bool(self.failed))


JobCallback = Callable[[Job, str, str | None], None]
"""Called for every job that ended, with its key and why it failed or None."""


def run_jobs(
    jobs: Sequence[Job],
    folder: Path,
    workers: WorkerSettings = WorkerSettings(),
    on_job_end: JobCallback = lambda job, key, why: None,
    on_start: Callable[[int], None] = lambda count: None,
) -> CampaignOutcome:
    """Run the jobs that have no result in the folder yet. Never raises KeyboardInterrupt: see `Ran.stopped`.

    begin: called with how many are left to run. Raises InputError where an input cannot be read, the folder not be
    made or the scheduler not be reached.
    """
    results = ResultFolder(folder)
    make_folder(folder)
    keys = [job.key() for job in jobs]
    wanted = dict(zip(keys, jobs, strict=True))
    left = {key: job for key, job in wanted.items() if not results.is_done(key, job)}
    ran = CampaignOutcome(keys, results, already_done=len(wanted) - len(left))
    on_start(len(left))
    try:
        for job, key, why in _run(left, results, workers):
            if why is None:
                ran.completed += 1
            else:
                ran.failed[key] = why
            on_job_end(job, key, why)
    except KeyboardInterrupt:
        ran.stop_code, ran.stop_reason = signal_exit_code() or 130, "interrupted"
    except _Lost as lost:
        ran.stop_code, ran.stop_reason = 3, str(lost)
    except ResultNotSavedError as unkept:
        ran.stop_code, ran.stop_reason = 2, unkept.reason
        if unkept.result is not None:
            ran.unsaved[unkept.key] = unkept.result
    return ran


class _Lost(Exception):
    """The scheduler is gone."""


def _run(left: dict[str, Job], results: ResultFolder, where: WorkerSettings) -> Iterator[tuple[Job, str, str | None]]:
    if not left:
        return
    if where.scheduler:
        yield from _on_cluster(left, results, where)
        return
    from joblib import Parallel, delayed

    processes = WorkerProcesses()
    one = delayed(partial(_run_one, processes, results.folder))
    # A thread for each process, which waits for it.
    parallel = Parallel(where.processes, backend="threading", return_as="generator_unordered", batch_size=1)
    try:
        yield from parallel(one(job, key) for key, job in left.items())
    finally:
        processes.stop()


def _run_one(processes: WorkerProcesses, folder: Path, job: Job, key: str) -> tuple[Job, str, str | None]:
    why = processes.run(job, key, folder)
    # One that was killed by the end of the campaign has not failed.
    return job, key, why if processes.stopped else _recorded(ResultFolder(folder), key, why)


def _recorded(results: ResultFolder, key: str, why: str | None) -> str | None:
    """A process that died could not write down why."""
    if why is not None and results.error(key) != why:
        try:
            results.write_error(key, why)
        except InputError as error:
            raise ResultNotSavedError(f"{why}; and {error}", key, None) from None
    return why


def _on_cluster(
    left: dict[str, Job], results: ResultFolder, where: WorkerSettings
) -> Iterator[tuple[Job, str, str | None]]:
    """Through every loss of the scheduler that does not last longer than `Where.patience`."""
    from slider_drilling.campaign.cluster import SchedulerLostError, connect, run_on_cluster

    patience = 0.0
    while left:
        try:
            with connect(where.scheduler, patience) as client:
                patience = where.patience
                for key, why in run_on_cluster(client, left, results.folder.resolve()):
                    job = left[key]
                    left = {other: job for other, job in left.items() if other != key}
                    yield job, key, _recorded(results, key, why)
        except InputError as error:
            if not patience:
                raise
            raise _Lost(str(error)) from None
        except SchedulerLostError:
            # What workers wrote although nobody could be told.
            for key in [key for key, job in left.items() if results.is_done(key, job)]:
                yield left.pop(key), key, None
