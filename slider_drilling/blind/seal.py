"""Make a sealed log, its label in another folder, and its twins, repeats of the same run, in a third."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from slider_drilling.blind.cases import Case, case_from_json
from slider_drilling.blind.label import Label
from slider_drilling.blind.sealed_rig import draw_sealed_rig, write_first_log
from slider_drilling.campaign.job import Job
from slider_drilling.files.output_files import write_atomically
from slider_drilling.rig import Rig, load_rig

REPEATS = 3
"""Twins of each log: together they show what the true effects close in such a run better than the log alone."""


def seal_job(case: Case, rig: Path, logs: Path, labels: Path, twins: Path, repeats: int) -> Job:
    """Returns the job that makes a case.

    Args:
        case: What to seal.
        rig: Rig file.
        logs: Folder of the log.
        labels: Folder of the label.
        twins: Folder of the twins; only cases with catalogued effects have any.
        repeats: Number of twins.
    """
    stem = case.file_stem()
    outputs = [str(logs / f"{stem}.mcap"), str(labels / f"{stem}.json")]
    if case.kind in ("single", "two"):
        outputs += [str(twins / f"{stem}_{number + 1}.mcap") for number in range(repeats)]
    # `seal` reads the outputs in this order.
    return Job("slider_drilling.blind.seal:seal", stem, {"rig": str(rig)}, case.to_json(), case.seed, tuple(outputs))


def seal(job: Job) -> dict[str, Any]:
    """Writes the log and its twins, then the label."""
    log, label_path, *twins = (Path(output) for output in job.outputs)
    label = make(case_from_json(dict(job.options)), load_rig(job.inputs["rig"]), log, twins)
    write_atomically(label_path, (json.dumps(asdict(label), indent=1) + "\n").encode("utf-8"))
    return {}


def make(case: Case, base: Rig, path: Path, twins: Sequence[Path] = ()) -> Label:
    """Writes one sealed log and returns its label.

    Args:
        case: What to seal.
        base: Rig that wells, string and fluids are drawn from.
        path: Of the log.
        twins: Paths of repeats: the same run with another draw of noise and losses each.
    """
    return write_first_log(draw_sealed_rig(case, base), path, twins)
