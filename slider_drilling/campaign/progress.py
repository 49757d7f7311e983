"""A campaign at the terminal: a progress bar, a line for each failed job, and a summary."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.run import CampaignOutcome, WorkerSettings, run_jobs
from slider_drilling.console.streams import progress_bar, stderr


def run_with_progress(stage: str, jobs: Sequence[Job], folder: Path, workers: WorkerSettings) -> CampaignOutcome:
    """Runs jobs, see `run_jobs`, with a progress bar and messages on stderr.

    Args:
        stage: Name of what the jobs do, for the bar and the messages.
        jobs: All jobs of the campaign.
        folder: Of the results.
        workers: Where jobs run.
    """
    from rich.progress import BarColumn, MofNCompleteColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "left",
               TimeRemainingColumn(elapsed_when_finished=False))  # fmt: skip
    with progress_bar(*columns) as bar:
        task = bar.add_task(stage, total=None)

        def on_job_end(job: Job, key: str, failure: str | None) -> None:
            bar.advance(task)
            if failure is not None:
                stderr().print(f"{stage}: {job.name} failed: {failure}")

        outcome = run_jobs(jobs, folder, workers, on_job_end, lambda count: bar.update(task, total=count))
    stderr().print(f"{stage}: {outcome.summary()}")
    return outcome
