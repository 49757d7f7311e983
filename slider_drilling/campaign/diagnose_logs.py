"""Many logs, each diagnosed by itself: one job for each log, one table and one page over all."""

from __future__ import annotations

import json
import os
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.campaign.job import Job
from slider_drilling.campaign.results import JobResult
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import check_outputs, delete_old, make_subfolder, write_atomically
from slider_drilling.log.log_files import logs_below
from slider_drilling.pages import Link, Page, Section, Table, Tag
from slider_drilling.schema.option_types import check_option_types
from slider_drilling.user_code import source_files

SCHEMA = "slider_drilling/diagnoses/2"
HEADS = ("log", "verdict", "effect", "indistinguishable", "site", "closes [95 %]", "worst channel", "its error",
         "failure")  # fmt: skip


@dataclass(frozen=True)
class DiagnoseOptions:
    """Options of `slider_drilling.diagnosis.diagnose`.

    Attributes:
        rig: Rig file; None for the one in the log.
        namespace: Of the log's topics.
        topics: File that says which topic is which; None where they have the names of a rig's.
        seed: Of the diagnosis.
        only: Effects that are considered; all if empty.
        effects: User effects, ``module:Class``.
        until: Gap at which the diagnosis stops.
        units: Name of the units of the pages.
    """

    rig: Path | None = None
    namespace: str | None = None
    topics: Path | None = None
    seed: int = 0
    only: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()
    until: float = 1.0
    units: str = "si"

    def __post_init__(self) -> None:
        check_option_types(self, "diagnose")


@dataclass(frozen=True)
class LogRow:
    """One log in the table.

    Attributes:
        log: Path of the log.
        folder: Folder of its report.
        verdict: Of its diagnosis, or ``failed``.
        effects: Named effects.
        indistinguishable: Effects that the log cannot distinguish from the named ones.
        site: Where the gap lies.
        closed: Share of the gap that the named effects close.
        closed_interval: Its 95 % interval.
        worst_channel: Channel whose error with the rig file as given is largest in units of its noise.
        worst_error: That error, with its unit and in units of the noise.
        failure: Why the diagnosis failed; empty if it did not.
    """

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
    """Returns the logs among the paths, and all logs and bags in and below the folders among them.

    Raises:
        InputError: A folder holds no log.
    """
    logs: list[Path] = []
    for path in paths:
        if not path.is_dir():
            logs.append(path)
            continue
        inside = logs_below(path)
        if not inside:
            raise InputError(f"{path}: holds no logs (.mcap, .db3, .bag)")
        logs += inside
    return logs


def folder_names(logs: Sequence[Path]) -> list[str]:
    """Returns a name for each log's folder: the log's own, with parent folders in front where two are the same."""
    names: list[str] = []
    for log in logs:
        name = log.stem
        for part in reversed(log.resolve().parent.parts):
            if name not in names or part == "/":
                break
            name = f"{part}_{name}"
        names.append(name)
    return names


def check_effect_names(options: DiagnoseOptions) -> None:
    """Check the names of the effects that are considered. Raises InputError."""
    from slider_drilling.diagnosis.catalogue import check_names
    from slider_drilling.diagnosis.user_effects import installed_effects, load_effect
    from slider_drilling.effects import EFFECTS

    own = [*installed_effects(), *(load_effect(reference) for reference in options.effects)] if options.only else []
    check_names(options.only, (*EFFECTS, *(user.effect.name for user in own)))


def user_effect_files(references: Sequence[str]) -> dict[str, str]:
    """Returns the source files of user effects, those of installed packages too. An edit changes the result of a job.

    Args:
        references: Of effects ``module:Class``.

    Returns:
        Paths by name.

    Raises:
        InputError: There is no such effect.
    """
    from slider_drilling.diagnosis.user_effects import installed_effects, load_effect

    effects = [*installed_effects(), *(load_effect(reference) for reference in references)]
    modules = {type(effect.user_object).__module__ for effect in effects}
    modules |= {reference.partition(":")[0] for reference in references}
    return {
        f"{module} {number}": str(path)
        for module in sorted(modules)
        for number, path in enumerate(source_files(module))
    }


def log_job(log: Path, options: DiagnoseOptions) -> Job:
    """Returns the job that diagnoses one log."""
    inputs = {"log": str(log)}
    if options.rig is not None:
        inputs["rig"] = str(options.rig)
    if options.topics is not None:
        inputs["topics"] = str(options.topics)
    inputs |= user_effect_files(options.effects)
    tree = {
        "namespace": options.namespace,
        "only": list(options.only),
        "until": options.until,
        "effects": list(options.effects),
        "units": options.units,
    }
    return Job("slider_drilling.campaign.diagnose_logs:diagnose_log", str(log), inputs, tree, options.seed)


def diagnose_log(job: Job) -> dict[str, Any]:
    """Returns the files of one log's report: name and text."""
    from slider_drilling.diagnosis.diagnose import diagnose
    from slider_drilling.diagnosis.save import write_diagnosis
    from slider_drilling.diagnosis.user_effects import installed_effects, load_effect
    from slider_drilling.log import read_log
    from slider_drilling.rig import load_rig
    from slider_drilling.units import UNITS

    options, rig_path = job.options, job.inputs.get("rig")
    user_effects = [*installed_effects(), *(load_effect(reference) for reference in options["effects"])]
    log = read_log(job.inputs["log"], rig_path, options["namespace"], job.inputs.get("topics"))
    rig = load_rig(rig_path) if rig_path is not None else log.rig()
    diagnosis = diagnose(
        [log], rig, seed=job.seed, user_effects=user_effects, only=options["only"], until=options["until"]
    )
    with tempfile.TemporaryDirectory() as folder:
        paths = write_diagnosis(diagnosis, Path(folder), UNITS[options["units"]])
        return {"files": {path.name: path.read_text(encoding="utf-8") for path in paths}}


def report_files(result: JobResult) -> dict[str, str]:
    """Returns the files of a log's report: name and text.

    Raises:
        ValueError: They are not those that `diagnose_log` returns.
    """
    from slider_drilling.diagnosis.save import FILES, NEXT_PROGRAMME

    files: dict[str, str] = result.tree["files"]
    if set(files) - {NEXT_PROGRAMME} != set(FILES) or not all(isinstance(text, str) for text in files.values()):
        raise ValueError
    return files


def row_of_result(log: Path, folder: str, result: JobResult) -> LogRow:
    """Returns the row of a log from its job's result.

    Raises:
        ValueError, LookupError, TypeError, AttributeError: It is not what `diagnose_log` returns.
    """
    row = log_row(log, folder, json.loads(report_files(result)["diagnosis.json"]))
    if not all(isinstance(cell, str) for cell in cells(row)):
        raise ValueError
    return row


def check_report_files(output: Path, folders: Sequence[str], inputs: Sequence[Path | None]) -> None:
    """Check before any work that the reports of an earlier run can be replaced.

    Args:
        output: Where the folders of the logs are.
        folders: Their names.
        inputs: Files to be read.

    Raises:
        InputError: A folder is a link or a file, or a report cannot be written.
    """
    from slider_drilling.diagnosis.save import FILES, NEXT_PROGRAMME

    there = [make_subfolder(output, folder) for folder in folders if os.path.lexists(output / folder)]
    check_outputs([folder / name for folder in there for name in (*FILES, NEXT_PROGRAMME)], inputs)


def write_report_files(files: Mapping[str, str], output: Path, folder: str) -> None:
    """Writes the files of a log's report into a folder of their own; deletes the programme of an earlier answer.

    Args:
        files: Name and text of each.
        output: Where the folder is made.
        folder: Its name.

    Raises:
        InputError: A file cannot be written.
    """
    from slider_drilling.diagnosis.save import NEXT_PROGRAMME

    place = make_subfolder(output, folder)
    for name, text in files.items():
        write_atomically(place / name, text.encode("utf-8"))
    if NEXT_PROGRAMME not in files:
        delete_old(place / NEXT_PROGRAMME)


def log_row(log: Path, folder: str, diagnosis: Mapping[str, Any]) -> LogRow:
    """Returns the row of a log.

    Args:
        log: The log.
        folder: Name of the folder of its report.
        diagnosis: The tree of its diagnosis.json.
    """
    gap = diagnosis["gap"]
    worst_channel, worst_error = _worst_channel(gap)
    named = [entry for entry in diagnosis["ranking"] if entry["in_answer"]]
    interval = gap["closed_interval"]
    return LogRow(
        log=str(log),
        folder=folder,
        verdict=diagnosis["verdict"],
        effects=tuple(diagnosis["effects"]),
        indistinguishable=tuple(name for entry in named for name in entry["group"]),
        site=diagnosis["site"],
        closed=gap["closed"],
        closed_interval=None if interval is None else (interval[0], interval[1]),
        worst_channel=worst_channel,
        worst_error=worst_error,
    )


def _worst_channel(gap: Mapping[str, Any]) -> tuple[str, str]:
    """Returns the channel with the largest error, with the rig file as given, in units of its noise; and that error."""
    errors = {
        name: (error["nominal"] / gap["noise_floor"][name]["value"], error)
        for name, error in gap["rms"].items()
        if error["nominal"] is not None and gap["noise_floor"].get(name, {}).get("value")
    }
    if not errors:
        return "", ""
    name = max(errors, key=lambda channel: errors[channel][0])
    floors, error = errors[name]
    return name, f"{error['nominal']:.3g} {error['unit']}, {floors:.1f} times its noise"


def as_json(rows: Sequence[LogRow], code: str) -> dict[str, Any]:
    """Returns the tree of diagnoses.json."""
    return {"schema": SCHEMA, "code": code, "logs": [_row_json(row) for row in rows]}


def _row_json(row: LogRow) -> dict[str, Any]:
    return {
        "log": row.log,
        "folder": row.folder,
        "verdict": row.verdict,
        "effects": list(row.effects),
        "indistinguishable": list(row.indistinguishable),
        "site": row.site,
        "closed": row.closed,
        "closed_interval": None if row.closed_interval is None else list(row.closed_interval),
        "worst_channel": row.worst_channel,
        "worst_error": row.worst_error,
        "failure": row.failure,
    }


def cells(row: LogRow) -> tuple[str, ...]:
    """Returns one row of the table: a cell for each of `HEADS`."""
    share = "-" if row.closed is None else f"{row.closed:.2f}"
    if row.closed_interval is not None and row.closed is not None:
        share += f" [{row.closed_interval[0]:.2f}, {row.closed_interval[1]:.2f}]"
    return (row.log, row.verdict, " + ".join(row.effects), ", ".join(row.indistinguishable), row.site or "", share,
            row.worst_channel, row.worst_error, row.failure)  # fmt: skip


def logs_page(rows: Sequence[LogRow]) -> Page:
    """Returns the page over all logs."""
    from slider_drilling.diagnosis.page import VERDICT_TONES

    body = []
    for row in rows:
        first = row.log if row.failure else Link(row.log, f"{row.folder}/report.html")
        body.append((first, Tag(row.verdict, VERDICT_TONES.get(row.verdict, "bad")), *cells(row)[2:]))
    counts = Counter(row.verdict for row in rows)
    return Page(
        kind="Diagnoses",
        title=f"{len(rows)} logs",
        facts=tuple((verdict, str(count)) for verdict, count in counts.items()),
        sections=(Section("Every log", (Table(HEADS, tuple(body)),)),),
        notes=("Each log is diagnosed by itself. Several logs of one rig reveal more if they are fitted together.",),
    )
