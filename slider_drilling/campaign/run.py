"""Run a campaign's jobs, here or on a cluster; whatever has a result already is left as it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from slider_drilling.campaign.isolated import Processes
from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import Result, Results, UnkeptError
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder
from slider_drilling.process.shutdown import signal_exit_code


@dataclass(frozen=True)
class Where:
    """Where jobs run: so many processes of this machine, or the workers of a `dask.distributed` scheduler; patience:
    s to wait for a scheduler that was lost."""

    processes: int = 1
    scheduler: str = ""
    patience: float = 60.0


@dataclass
class Ran:
    """What became of a campaign's jobs.

    keys: of all, in their order; results: where they are kept; kept: had a result before; done: have one since; unkept:
    what could not be written; failed: why by key, of those that ended without; stopped: the exit code where a signal, a
    lost scheduler or a full disk ended the campaign early, else 0.
    """

    keys: list[str]
    results: Results
    kept: int = 0
    done: int = 0
    unkept: dict[str, Result] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    stopped: int = 0
    why: str = ""

    def result(self, key: str) -> Result | None:
        """What came of a job; None where there is nothing yet. Raises InputError where its file is no result."""
        if key in self.unkept:
            return self.unkept[key]
        return self.results.read(key) if self.results.path(key).is_file() else None

    @property
    def missing(self) -> int:
        """Jobs that were not run to an end."""
        return len(set(self.keys)) - self.kept - self.done - len(self.unkept) - len(self.failed)

    def sentence(self) -> str:
        """What to tell the user of it, in a line."""
        parts = [f"{self.done} run", f"{self.kept} kept from before", f"{len(self.unkept)} run and not kept",
                 f"{len(self.failed)} failed"]  # fmt: skip
        if self.missing:
            parts.append(f"{self.missing} not run")
        end = f"; {self.why}: the same command goes on from here" if self.stopped else ""
        return ", ".join(part for part in parts if not part.startswith("0 ")) + end

    @property
    def code(self) -> int:
        """Exit code: 0 where every job has a result, 1 where some failed, more where it was stopped."""
        return self.stopped or int(bool(self.failed))


Said = Callable[[Job, str, str | None], None]
"""Called for every job that ended, with its key and why it failed or None."""


def run_jobs(
    jobs: Sequence[Job],
    folder: Path,
    where: Where = Where(),
    said: Said = lambda job, key, why: None,
    begin: Callable[[int], None] = lambda count: None,
) -> Ran:
    """Run the jobs that have no result in the folder yet. Never raises KeyboardInterrupt: see `Ran.stopped`.

    begin: called with how many are left to run. Raises InputError where an input cannot be read, the folder not be
    made or the scheduler not be reached.
    """
    results = Results(folder)
    make_folder(folder)
    keys = [job.key() for job in jobs]
    wanted = dict(zip(keys, jobs, strict=True))
    left = {key: job for key, job in wanted.items() if not results.done(key, job)}
    ran = Ran(keys, results, kept=len(wanted) - len(left))
    begin(len(left))
    try:
        for job, key, why in _run(left, results, where):
            if why is None:
                ran.done += 1
            else:
                ran.failed[key] = why
            said(job, key, why)
    except KeyboardInterrupt:
        ran.stopped, ran.why = signal_exit_code() or 130, "interrupted"
    except _Lost as lost:
        ran.stopped, ran.why = 3, str(lost)
    except UnkeptError as unkept:
        ran.stopped, ran.why = 2, unkept.why
        if unkept.result is not None:
            ran.unkept[unkept.key] = unkept.result
    return ran


class _Lost(Exception):
    """The scheduler is gone."""


def _run(left: dict[str, Job], results: Results, where: Where) -> Iterator[tuple[Job, str, str | None]]:
    if not left:
        return
    if where.scheduler:
        yield from _on_cluster(left, results, where)
        return
    from joblib import Parallel, delayed

    processes = Processes()
    one = delayed(partial(_run_one, processes, results.folder))
    # A thread for each process, which waits for it.
    parallel = Parallel(where.processes, backend="threading", return_as="generator_unordered", batch_size=1)
    try:
        yield from parallel(one(job, key) for key, job in left.items())
    finally:
        processes.stop()


def _run_one(processes: Processes, folder: Path, job: Job, key: str) -> tuple[Job, str, str | None]:
    why = processes.run(job, key, folder)
    # One that was killed by the end of the campaign has not failed.
    return job, key, why if processes.stopped else _recorded(Results(folder), key, why)


def _recorded(results: Results, key: str, why: str | None) -> str | None:
    """A process that died could not write down why."""
    if why is not None and results.error(key) != why:
        try:
            results.write_error(key, why)
        except InputError as error:
            raise UnkeptError(f"{why}; and {error}", key, None) from None
    return why


def _on_cluster(left: dict[str, Job], results: Results, where: Where) -> Iterator[tuple[Job, str, str | None]]:
    """Through every loss of the scheduler that does not last longer than `Where.patience`."""
    from slider_drilling.campaign.cluster import LostError, connected, results_of

    patience = 0.0
    while left:
        try:
            with connected(where.scheduler, patience) as client:
                patience = where.patience
                for key, why in results_of(client, left, results.folder.resolve()):
                    job = left[key]
                    left = {other: job for other, job in left.items() if other != key}
                    yield job, key, _recorded(results, key, why)
        except InputError as error:
            if not patience:
                raise
            raise _Lost(str(error)) from None
        except LostError:
            # What workers wrote although nobody could be told.
            for key in [key for key, job in left.items() if results.done(key, job)]:
                yield left.pop(key), key, None
