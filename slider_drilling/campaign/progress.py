"""A campaign at the terminal: a bar with the time left, a line for each job that failed, what became of all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.run import CampaignOutcome, WorkerSettings, run_jobs
from slider_drilling.console.streams import progress_bar, stderr


def run_with_progress(
    what: str,
    jobs: Sequence[Job],
    folder: Path,
    workers: WorkerSettings,
    said: Callable[[Job, str], None] = lambda job, key: None,
) -> CampaignOutcome:
    """`run_jobs` with a bar and remarks on stderr; said: called with each job that has a result now, and its key."""
    from rich.progress import BarColumn, MofNCompleteColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "left",
               TimeRemainingColumn(elapsed_when_finished=False))  # fmt: skip
    with progress_bar(*columns) as bar:
        task = bar.add_task(what, total=None)

        def ended(job: Job, key: str, why: str | None) -> None:
            bar.advance(task)
            if why is None:
                said(job, key)
            else:
                stderr().print(f"{what}: {job.name} failed: {why}")

        ran = run_jobs(jobs, folder, workers, ended, lambda count: bar.update(task, total=count))
    stderr().print(f"{what}: {ran.summary()}")
    return ran
