"""What `slider-drilling diagnose` does with several logs, or a folder of them: each by itself, one table over all."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slider_drilling.commands.options import write_and_print

if TYPE_CHECKING:
    from slider_drilling.campaign.logs import Options, Row
    from slider_drilling.campaign.run import Where
    from slider_drilling.units import Units

PAGE, FILE, RESULTS = "diagnoses.html", "diagnoses.json", "results"


def diagnose_each(
    logs: Sequence[Path], options: Options, where: Where, output: Path, as_json_text: bool, units: Units
) -> int:
    """Diagnose each log into a folder of its own; the exit code."""
    from slider_drilling.campaign.code import code_version
    from slider_drilling.campaign.logs import as_json, folder_names, log_job, page_of, row_of, unfold
    from slider_drilling.campaign.shown import run_shown
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.pages import write_page

    make_folder(output)
    check_outputs([output / PAGE, output / FILE], (*logs, options.rig))
    names = folder_names(logs)
    jobs = [log_job(log, options) for log in logs]
    ran = run_shown("diagnosing", jobs, output / RESULTS, where)
    rows = []
    for log, name, key in zip(logs, names, ran.keys, strict=True):
        if (result := ran.result(key)) is not None:
            rows.append(row_of(log, name, json.loads(result.tree["files"]["diagnosis.json"])))
        elif (why := ran.results.error(key)) is not None:
            rows.append(_failed(log, name, why))
    tree = as_json(rows, code_version())

    def write() -> list[Path]:
        for name, key in zip(names, ran.keys, strict=True):
            if (result := ran.result(key)) is not None:
                unfold(result, output / name)
        write_atomically(output / FILE, (json.dumps(tree, indent=1, allow_nan=False) + "\n").encode("utf-8"))
        write_page(output / PAGE, page_of(rows), units)
        return [output / FILE, output / PAGE]

    write_and_print(tree if as_json_text else None, lambda: _print(rows), write)
    return ran.code


def _failed(log: Path, name: str, why: str) -> Row:
    from slider_drilling.campaign.logs import Row

    return Row(str(log), name, "failed", (), (), None, None, None, "", "", why)


def _print(rows: Sequence[Row]) -> None:
    from rich.table import Table

    from slider_drilling.campaign.logs import HEADS, cells
    from slider_drilling.console.streams import stdout

    table = Table(*HEADS)
    for row in rows:
        table.add_row(*cells(row))
    stdout().print(table)
