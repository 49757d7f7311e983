"""Diagnose logs after removing something from them: ``python -m slider_drilling.benchmarks.log_defects WHAT LOG...``.

WHAT: ``samples=N``: one of N samples of every series is kept, but of the rare MWD toolface; ``renewals=N``: the same
values, each logged N times; ``start=SHARE``: the first part is not there, the string is at work when the log begins;
``drawworks``, ``pump``, ``toolface``, ``pressure``: the series is not there; ``speed``: the drive's is zero
throughout; ``nothing``: the log as it is. One row of markdown a log.
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


def main(what: str, logs: list[Path]) -> None:
    """Print the rows as they come."""
    print(f"| log, lacking {what} | said | E as given | re-tuned | with it |\n|---|---|---|---|---|")
    for path in logs:
        log = lacking(what, read_log(path))
        tree = to_json(diagnose([log], log.rig()))
        said = " and ".join([*tree["effects"], *(["unknown"] if "unknown" in tree["verdict"] else [])])
        sizes = [tree["gap"][name] for name in ("nominal", "tuned", "with_effect")]
        cells = ["" if size is None else f"{size:.2f}" for size in sizes]
        print(f"| `{path.stem}` | {said or tree['verdict']} | {' | '.join(cells)} |", flush=True)


def lacking(what: str, log: RigLog) -> RigLog:
    """The log without what is named; see above."""
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
    raise SystemExit(f"{what}: not among what a log may lack here, see {__file__}")


def _rows(log: RigLog, lack: LogDefect, but: tuple[str, ...] = ()) -> RigLog:
    """The log with the samples that a recorder which lacks this has; but: columns that stay."""
    found: dict[str, Any] = {}
    for name in _SERIES:
        series = getattr(log, name)
        if series is not None:
            _, kept = lack.sample_rows(series.time.size)
            columns = [field.name for field in fields(series) if field.name not in but]
            found[name] = replace(series, **{column: getattr(series, column)[kept] for column in columns})
    return _changed(log, found)


def _changed(log: RigLog, series: dict[str, Any]) -> RigLog:
    return replace(log, **series)


if __name__ == "__main__":
    main(sys.argv[1], [Path(argument) for argument in sys.argv[2:]])
