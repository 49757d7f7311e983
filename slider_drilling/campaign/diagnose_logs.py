"""Many logs, each diagnosed by itself: a job a log, one table and one page over all."""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, write_atomically
from slider_drilling.pages import Link, Page, Section, Table, Tag
from slider_drilling.pages.page import Tone

SCHEMA = "slider_drilling/diagnoses/1"
HEADS = ("log", "verdict", "effect", "not told from", "site", "closes [95 %]", "worst channel", "off by", "failed")
_TONES: dict[str, Tone] = {"none": "good", "parameters": "good", "effect": "plain"}


@dataclass(frozen=True)
class DiagnoseOptions:
    """Of `diagnose`, as `slider_drilling.diagnosis.diagnose` has them; effects: ``module:Class`` and its file each;
    units: of the pages, by name."""

    rig: Path | None = None
    namespace: str | None = None
    seed: int = 0
    only: tuple[str, ...] = ()
    effects: tuple[tuple[str, str], ...] = ()
    until: float = 1.0
    units: str = "si"


@dataclass(frozen=True)
class LogRow:
    """One log's line of the table. folder: of its files; worst: the channel with the largest error as given, in its
    noise, and that error with its unit."""

    log: str
    folder: str
    verdict: str
    effects: tuple[str, ...]
    indistinguishable: tuple[str, ...]
    site: str | None
    closed: float | None
    closed_interval: tuple[float, float] | None
    worst_channel: str
    worst_error: str
    failure: str = ""


def find_logs(paths: Sequence[Path]) -> list[Path]:
    """The logs themselves, and all ``*.mcap`` below folders. Raises InputError for a folder without any."""
    found: list[Path] = []
    for path in paths:
        if not path.is_dir():
            found.append(path)
            continue
        inside = sorted(one for one in path.rglob("*.mcap") if not one.name.startswith("."))
        if not inside:
            raise InputError(f"{path}: holds no logs (*.mcap)")
        found += inside
    return found


def folder_names(logs: Sequence[Path]) -> list[str]:
    """A name for each log's folder: the log's own, with what is above it where two have the same."""
    names: list[str] = []
    for log in logs:
        parts = [log.stem, *(part for part in reversed(log.resolve().parent.parts) if part != "/")]
        name = parts[0]
        for part in parts[1:]:
            if name not in names:
                break
            name = f"{part}_{name}"
        names.append(name)
    return names


def user_effect_file(reference: str) -> str:
    """The file of an effect ``module:Class`` of the user's own: an edit of it is another effect. Raises InputError."""
    from slider_drilling.diagnosis.user_effects import load_effect

    load_effect(reference)
    return str(sys.modules[reference.partition(":")[0]].__file__)


def log_job(log: Path, options: DiagnoseOptions) -> Job:
    """The job that diagnoses one log."""
    inputs = {"log": str(log)}
    if options.rig is not None:
        inputs["rig"] = str(options.rig)
    inputs |= dict(options.effects)
    tree = {
        "namespace": options.namespace,
        "only": list(options.only),
        "until": options.until,
        "effects": [reference for reference, _ in options.effects],
        "units": options.units,
    }
    return Job("slider_drilling.campaign.diagnose_logs:diagnose_log", str(log), inputs, tree, options.seed)


def diagnose_log(job: Job) -> dict[str, Any]:
    """The files of one log's diagnosis: name and text."""
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.save import write_diagnosis
    from slider_drilling.diagnosis.user_effects import installed_effects, load_effect
    from slider_drilling.log import read_log
    from slider_drilling.rig import load_rig
    from slider_drilling.units import UNITS

    options, rig_path = job.options, job.inputs.get("rig")
    own = [*installed_effects(), *(load_effect(reference) for reference in options["effects"])]
    log = read_log(job.inputs["log"], rig_path, options["namespace"])
    rig = load_rig(rig_path) if rig_path is not None else log.rig()
    found = diagnose([log], rig, seed=job.seed, user_effects=own, only=options["only"], until=options["until"])
    with tempfile.TemporaryDirectory() as folder:
        paths = write_diagnosis(found, Path(folder), UNITS[options["units"]])
        return {"files": {path.name: path.read_text(encoding="utf-8") for path in paths}}


def write_report_files(result: JobResult, folder: Path) -> None:
    """Write a result's files into a folder of their own. Raises InputError."""
    make_folder(folder)
    for name, text in result.tree["files"].items():
        write_atomically(folder / name, text.encode("utf-8"))


def log_row(log: Path, folder: str, diagnosis: dict[str, Any]) -> LogRow:
    """The line of a log whose diagnosis.json (schema 3) is this tree."""
    gap = diagnosis["gap"]
    worst, off_by = _worst(gap)
    group = [name for entry in diagnosis["ranking"] if entry["in_answer"] for name in entry["group"]]
    interval = gap["closed_interval"]
    return LogRow(
        str(log),
        folder,
        diagnosis["verdict"],
        tuple(diagnosis["effects"]),
        tuple(group),
        diagnosis["site"],
        gap["closed"],
        None if interval is None else (interval[0], interval[1]),
        worst,
        off_by,
    )


def _worst(gap: dict[str, Any]) -> tuple[str, str]:
    """The channel whose error, with the rig file as given, is largest in its noise."""
    errors = {
        name: (error["nominal"] / gap["noise_floor"][name]["value"], error)
        for name, error in gap["rms"].items()
        if error["nominal"] is not None and gap["noise_floor"].get(name, {}).get("value")
    }
    if not errors:
        return "", ""
    name = max(errors, key=lambda one: errors[one][0])
    floors, error = errors[name]
    return name, f"{error['nominal']:.3g} {error['unit']}, {floors:.1f} times its noise"


def as_json(rows: Sequence[LogRow], code: str) -> dict[str, Any]:
    """The tree of diagnoses.json."""
    return {
        "schema": SCHEMA,
        "code": code,
        "logs": [
            {
                "log": row.log,
                "folder": row.folder,
                "verdict": row.verdict,
                "effects": list(row.effects),
                "group": list(row.indistinguishable),
                "site": row.site,
                "closed": row.closed,
                "closed_interval": None if row.closed_interval is None else list(row.closed_interval),
                "worst_channel": row.worst_channel,
                "off_by": row.worst_error,
                "failed": row.failure,
            }
            for row in rows
        ],
    }


def cells(row: LogRow) -> tuple[str, ...]:
    """One line of the table: a cell for each of `HEADS`."""
    share = "-" if row.closed is None else f"{row.closed:.2f}"
    if row.closed_interval is not None and row.closed is not None:
        share += f" [{row.closed_interval[0]:.2f}, {row.closed_interval[1]:.2f}]"
    return (
        row.log,
        row.verdict,
        " + ".join(row.effects),
        ", ".join(row.indistinguishable),
        row.site or "",
        share,
        row.worst_channel,
        row.worst_error,
        row.failure,
    )


def logs_page(rows: Sequence[LogRow]) -> Page:
    """The page over all logs."""
    body = []
    for row in rows:
        shown = cells(row)
        first = Link(row.log, f"{row.folder}/report.html") if not row.failure else row.log
        body.append((first, Tag(row.verdict, _TONES.get(row.verdict, "bad")), *shown[2:]))
    counts = Counter(row.verdict for row in rows)
    return Page(
        kind="Diagnoses",
        title=f"{len(rows)} logs",
        facts=tuple((verdict, str(count)) for verdict, count in counts.items()),
        sections=(Section("Every log", (Table(HEADS, tuple(body)),)),),
        notes=("Each log is diagnosed by itself; several logs of one rig tell more when they are fitted together.",),
    )
