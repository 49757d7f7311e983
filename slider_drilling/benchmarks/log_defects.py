"""Diagnose logs with a defect: ``python -m slider_drilling.benchmarks.log_defects DEFECT LOG...``.

DEFECT is one of

* ``samples=N``: one of N samples is kept, except MWD toolfaces;
* ``renewals=N``: each value is repeated N times;
* ``start=SHARE``: the first part of the log is missing;
* ``drawworks``, ``pump``, ``toolface``, ``pressure``: the series is missing;
* ``speed``: the speed of the top drive is zero throughout;
* ``nothing``: the log as it is.

Prints one row of a markdown table per log.
"""

from __future__ import annotations

import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.blind.log_defects import LogDefect
from slider_drilling.diagnosis.diagnose import diagnose
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.log import RigLog, read_log
from slider_drilling.log.time_window import cut_time_window

_SERIES = ("top_drive", "draw_works", "mud_pump", "standpipe_pressure")
_MISSING = {
    "drawworks": "draw_works", "pump": "mud_pump", "toolface": "mwd_tool_face", "pressure": "standpipe_pressure",
}  # fmt: skip


def main(defect: str, logs: list[Path]) -> None:
    """Diagnose each log with the defect and print its row."""
    print(f"| log, defect {defect} | answer | E as given | calibrated | with effect |\n|---|---|---|---|---|")
    for path in logs:
        log = with_defect(defect, read_log(path))
        tree = to_json(diagnose([log], log.rig()))
        answer = " and ".join([*tree["effects"], *(["unknown"] if "unknown" in tree["verdict"] else [])])
        sizes = [tree["gap"][name] for name in ("nominal", "tuned", "with_effect")]
        cells = ["" if size is None else f"{size:.2f}" for size in sizes]
        print(f"| `{path.stem}` | {answer or tree['verdict']} | {' | '.join(cells)} |", flush=True)


def with_defect(what: str, log: RigLog) -> RigLog:
    """The log with a defect; the module's docstring lists them."""
    name, _, value = what.partition("=")
    if name in _MISSING:
        return _changed(log, {_MISSING[name]: None})
    if name == "samples":
        return _rows(log, LogDefect(keep_every=int(value)))
    if name == "renewals":
        return _rows(log, LogDefect(hold_samples=int(value)), ("time", "arrival"))
    if log.top_drive is not None and name == "start":
        return cut_time_window(log, float(value) * float(log.top_drive.time[-1]), np.inf)
    if log.top_drive is not None and name == "speed":
        still = np.zeros_like(log.top_drive.velocity)
        return replace(log, top_drive=replace(log.top_drive, velocity=still))
    if name == "nothing":
        return log
    raise SystemExit(f"{what}: no such defect; see python -m pydoc slider_drilling.benchmarks.log_defects")


def _rows(log: RigLog, lack: LogDefect, but: tuple[str, ...] = ()) -> RigLog:
    """The log with the samples that this defect leaves; columns named in ``but`` stay."""
    series_left: dict[str, Any] = {}
    for name in _SERIES:
        series = getattr(log, name)
        if series is not None:
            _, kept = lack.sample_rows(series.time.size)
            columns = [field.name for field in fields(series) if field.name not in but]
            series_left[name] = replace(series, **{column: getattr(series, column)[kept] for column in columns})
    return _changed(log, series_left)


def _changed(log: RigLog, series: dict[str, Any]) -> RigLog:
    return replace(log, **series)


if __name__ == "__main__":
    main(sys.argv[1], [Path(argument) for argument in sys.argv[2:]])
