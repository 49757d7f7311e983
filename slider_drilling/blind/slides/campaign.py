"""A campaign of sealed slides: make them, let the twin watch each, open the labels, score."""

from __future__ import annotations

import datetime
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slider_drilling.blind.check import JobRunner
from slider_drilling.blind.slides.case import SlideCase
from slider_drilling.blind.slides.label import read_slide_label
from slider_drilling.blind.slides.make import slide_job
from slider_drilling.blind.slides.score import ScoredSlide, score_slide
from slider_drilling.blind.slides.table import TableRow, campaign_table
from slider_drilling.blind.slides.watched import WatchedSlide, watch_job, watched_from_json
from slider_drilling.blind.totals import without_nan
from slider_drilling.campaign.code_version import code_version
from slider_drilling.campaign.run import CampaignOutcome
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, make_subfolder

SCHEMA = "slider_drilling/twin_campaign/1"
LOGS, LABELS, RESULTS = "logs", "labels", "results"


@dataclass(frozen=True)
class TwinCampaign:
    """What a campaign found.

    Attributes:
        scored: Score of each slide.
        watched: What the twin made of each, in the same order.
        failed: Why a slide could not be made or watched, by its log.
        stages: Outcome of each stage that was run.
    """

    scored: tuple[ScoredSlide, ...]
    watched: tuple[WatchedSlide, ...]
    failed: dict[str, str]
    stages: tuple[CampaignOutcome, ...]

    @property
    def exit_code(self) -> int:
        """See `CampaignOutcome.exit_code`."""
        return max((stage.exit_code for stage in self.stages), default=0)

    def table(self) -> list[TableRow]:
        """The table."""
        return campaign_table(self.scored, self.watched)


def run_campaign(
    cases: Sequence[SlideCase], rig: Path, folder: Path, run: JobRunner, diagnose: bool = True
) -> TwinCampaign:
    """Make the slides, watch them without their labels, and score.

    Args:
        cases: What to make.
        rig: Rig file that wells, strings and fluids are drawn from.
        folder: Of logs, labels and results; what is there already is not made again.
        run: Runs the jobs.
        diagnose: Whether the twin asks what has changed.

    Raises:
        InputError: No slide could be made.
    """
    logs, labels = folder / LOGS, folder / LABELS
    make_folder(logs)
    make_folder(labels)
    labels.chmod(0o700)  # no other user may read them; `Job.forbidden_folders` keeps the twin out
    made = run("making slides", [slide_job(case, rig, logs, labels) for case in cases], labels / "made")
    paths = [path for case in cases if (path := logs / f"{case.file_stem()}.mcap").is_file()]
    if made.stop_code:
        return TwinCampaign((), (), dict(made.failed), (made,))
    if not paths:
        raise InputError(f"{folder}: no slide could be made: {next(iter(made.failed.values()), 'none was asked for')}")
    forbidden = (str(labels.resolve()),)
    seen = run("watching", [watch_job(path, forbidden, diagnose) for path in paths], make_subfolder(folder, RESULTS))
    watched, scored = [], []
    for path, key in zip(paths, seen.keys, strict=True):
        result = seen.result(key)
        if result is not None:
            watched.append(watched_from_json(result.tree))
            scored.append(score_slide(read_slide_label(labels / f"{path.stem}.json"), watched[-1]))
    return TwinCampaign(tuple(scored), tuple(watched), {**made.failed, **seen.failed}, (made, seen))


def campaign_json(campaign: TwinCampaign, options: dict[str, Any]) -> dict[str, Any]:
    """The tree of twin_campaign.json."""
    date = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    tree: dict[str, Any] = without_nan({
        "schema": SCHEMA, "date": date, "code": code_version(), "options": options,
        "table": [asdict(row) for row in campaign.table()], "slides": [asdict(each) for each in campaign.scored],
        "watched": [asdict(each) for each in campaign.watched], "failed": campaign.failed,
    })  # fmt: skip
    return tree


def dump_campaign(campaign: TwinCampaign, options: dict[str, Any]) -> bytes:
    """The file twin_campaign.json."""
    return (json.dumps(campaign_json(campaign, options), indent=1, allow_nan=False) + "\n").encode("utf-8")
