"""`slider-drilling diagnose` with several logs: one by one, with a table over all."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.commands.options import write_and_print

if TYPE_CHECKING:
    from slider_drilling.campaign.diagnose_logs import DiagnoseOptions, LogRow
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.units import Units

PAGE, FILE, RESULTS = "diagnoses.html", "diagnoses.json", "results"


def diagnose_each(
    logs: Sequence[Path],
    options: DiagnoseOptions,
    where: WorkerSettings,
    output: Path,
    as_json_text: bool,
    units: Units,
) -> int:
    """Diagnose each log into its own folder; returns the exit code."""
    from slider_drilling.campaign.code_version import code_version
    from slider_drilling.campaign.diagnose_logs import (
        as_json,
        check_effect_names,
        check_report_files,
        folder_names,
        log_job,
        logs_page,
        report_files,
        row_of_result,
        write_report_files,
    )
    from slider_drilling.campaign.progress import run_with_progress
    from slider_drilling.files.output_files import check_outputs, make_folder, make_subfolder, write_atomically
    from slider_drilling.pages import write_page

    check_effect_names(options)
    make_folder(output)
    check_outputs([output / PAGE, output / FILE], (*logs, options.rig))
    names = folder_names(logs)
    check_report_files(output, names, (*logs, options.rig))
    jobs = [log_job(log, options) for log in logs]
    ran = run_with_progress("diagnosing", jobs, make_subfolder(output, RESULTS), where)
    rows = []
    for log, name, key in zip(logs, names, ran.keys, strict=True):
        if (row := ran.parse(key, partial(row_of_result, log, name))) is not None:
            rows.append(row)
        elif (why := ran.results.error(key)) is not None:
            rows.append(_failed(log, name, why))
    tree = as_json(rows, code_version())

    def write() -> list[Path]:
        for name, key in zip(names, ran.keys, strict=True):
            if (files := ran.parse(key, report_files)) is not None:
                write_report_files(files, output, name)
        write_atomically(output / FILE, (json.dumps(tree, indent=1, allow_nan=False) + "\n").encode("utf-8"))
        write_page(output / PAGE, logs_page(rows), units)
        return [output / FILE, output / PAGE]

    write_and_print(tree if as_json_text else None, lambda: _print(rows), write)
    return ran.exit_code


def _failed(log: Path, name: str, why: str) -> LogRow:
    from slider_drilling.campaign.diagnose_logs import LogRow

    return LogRow(str(log), name, "failed", (), (), None, None, None, "", "", why)


def _print(rows: Sequence[LogRow]) -> None:
    from rich.table import Table

    from slider_drilling.campaign.diagnose_logs import HEADS, cells
    from slider_drilling.console.streams import stdout

    table = Table(*HEADS)
    for row in rows:
        table.add_row(*cells(row))
    stdout().print(table)
