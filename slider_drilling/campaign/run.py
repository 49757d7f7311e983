"""Run a campaign's jobs, here or on a cluster. Jobs that have a result are not run again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult, Parsed, ResultFolder, ResultNotSavedError
from slider_drilling.campaign.worker_processes import WorkerProcesses
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder
from slider_drilling.process.shutdown import signal_exit_code

_NOT_SAVED, _SCHEDULER_LOST, _INTERRUPTED = 2, 3, 130  # exit codes of a campaign that ended early


@dataclass(frozen=True)
class WorkerSettings:
    """Where jobs run.

    Attributes:
        processes: Processes of this machine.
        scheduler: Address of a `dask.distributed` scheduler whose workers run the jobs instead; empty for none.
        patience: How long to wait for a scheduler that was lost, s.
    """

    processes: int = 1
    scheduler: str = ""
    patience: float = 60.0


@dataclass
class CampaignOutcome:
    """What became of a campaign's jobs.

    Attributes:
        keys: Key of each job, in the order of the jobs.
        results: Where results are kept.
        already_done: Number of jobs that had a result before.
        completed: Number of jobs that have one since.
        unsaved: Results that could not be written, by key.
        failed: Why each job without a result failed, by key.
        stop_code: Exit code of a campaign that a signal, a lost scheduler or a full disk ended early; else 0.
        stop_reason: Why it ended early.
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
        """Returns a job's result, or None.

        Raises:
            InputError: Its file is not a result.
        """
        return self.parse(key, lambda result: result)

    def parse(self, key: str, parse: Callable[[JobResult], Parsed]) -> Parsed | None:
        """Returns what a function makes of a job's result, or None.

        Raises:
            InputError: Its file is not a result, or does not hold what the function needs.
        """
        if key in self.unsaved:
            return parse(self.unsaved[key])
        return self.results.parse(key, parse) if self.results.path(key).is_file() else None

    @property
    def not_run(self) -> int:
        """Number of jobs that did not run to an end."""
        return len(set(self.keys)) - self.already_done - self.completed - len(self.unsaved) - len(self.failed)

    def summary(self) -> str:
        """Returns the outcome in one line."""
        counts = {
            "completed": self.completed, "done before": self.already_done, "completed but not saved": len(self.unsaved),
            "failed": len(self.failed), "not run": self.not_run,
        }  # fmt: skip
        text = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
        return f"{text}; {self.stop_reason}: run the same command to continue" if self.stop_code else text

    @property
    def exit_code(self) -> int:
        """0 if every job has a result, 1 if some failed, more if the campaign ended early."""
        return self.stop_code or int(bool(self.failed))


JobCallback = Callable[[Job, str, str | None], None]
"""Called for each job that ended, with its key and why it failed or None."""


def run_jobs(
    jobs: Sequence[Job],
    folder: Path,
    workers: WorkerSettings = WorkerSettings(),
    on_job_end: JobCallback = lambda job, key, failure: None,
    on_start: Callable[[int], None] = lambda count: None,
) -> CampaignOutcome:
    """Runs the jobs that have no result in the folder. KeyboardInterrupt ends it early, see `stop_code`.

    Args:
        jobs: All jobs of the campaign.
        folder: Of the results.
        workers: Where jobs run.
        on_job_end: Called for each job that ended.
        on_start: Called with the number of jobs to run.

    Raises:
        InputError: An input cannot be read, the folder cannot be made, or the scheduler does not answer.
    """
    results = ResultFolder(folder)
    make_folder(folder)
    keys = [job.key() for job in jobs]
    distinct = dict(zip(keys, jobs, strict=True))
    pending = {key: job for key, job in distinct.items() if not results.is_done(key, job)}
    outcome = CampaignOutcome(keys, results, already_done=len(distinct) - len(pending))
    on_start(len(pending))
    try:
        for job, key, failure in _run(pending, results, workers):
            if failure is None:
                outcome.completed += 1
            else:
                outcome.failed[key] = failure
            on_job_end(job, key, failure)
    except KeyboardInterrupt:
        outcome.stop_code, outcome.stop_reason = signal_exit_code() or _INTERRUPTED, "interrupted"
    except _SchedulerGoneError as error:
        outcome.stop_code, outcome.stop_reason = _SCHEDULER_LOST, str(error)
    except ResultNotSavedError as error:
        outcome.stop_code, outcome.stop_reason = _NOT_SAVED, error.reason
        if error.result is not None:
            outcome.unsaved[error.key] = error.result
    return outcome


class _SchedulerGoneError(Exception):
    """The scheduler was lost and did not come back in time."""


def _run(
    pending: dict[str, Job], results: ResultFolder, workers: WorkerSettings
) -> Iterator[tuple[Job, str, str | None]]:
    if not pending:
        return
    if workers.scheduler:
        yield from _run_on_cluster(pending, results, workers)
        return
    from joblib import Parallel, delayed

    processes = WorkerProcesses()
    run_one = delayed(partial(_run_one, processes, results.folder))
    # One thread for each process, which waits for it.
    parallel = Parallel(workers.processes, backend="threading", return_as="generator_unordered", batch_size=1)
    try:
        yield from parallel(run_one(job, key) for key, job in pending.items())
    finally:
        processes.stop()


def _run_one(processes: WorkerProcesses, folder: Path, job: Job, key: str) -> tuple[Job, str, str | None]:
    failure = processes.run(job, key, folder)
    # A job that the end of the campaign killed has not failed.
    return job, key, failure if processes.stopped else _save_failure(ResultFolder(folder), key, failure)


def _save_failure(results: ResultFolder, key: str, failure: str | None) -> str | None:
    """Saves the failure of a process that died, since it could not do so itself."""
    if failure is not None and results.error(key) != failure:
        try:
            results.write_error(key, failure)
        except InputError as error:
            raise ResultNotSavedError(f"{failure}; and {error}", key, None) from None
    return failure


def _run_on_cluster(
    pending: dict[str, Job], results: ResultFolder, workers: WorkerSettings
) -> Iterator[tuple[Job, str, str | None]]:
    """Connects again after each loss of the scheduler that does not last longer than the patience."""
    from slider_drilling.campaign.cluster import SchedulerLostError, connect, run_on_cluster

    patience = 0.0
    while pending:
        try:
            with connect(workers.scheduler, patience) as client:
                patience = workers.patience
                for key, failure in run_on_cluster(client, pending, results.folder.resolve()):
                    job = pending[key]
                    # A new dictionary: `run_on_cluster` still iterates over the old one's jobs.
                    pending = {other: job for other, job in pending.items() if other != key}
                    yield job, key, _save_failure(results, key, failure)
        except InputError as error:
            if not patience:
                raise
            raise _SchedulerGoneError(str(error)) from None
        except SchedulerLostError:
            # Workers may have written results that could not be reported.
            for key in [key for key, job in pending.items() if results.is_done(key, job)]:
                yield pending.pop(key), key, None
