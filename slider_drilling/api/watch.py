"""`watch`: a twin beside a log, from its first second to its last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.api.replay import as_log
from slider_drilling.api.simulate import Run
from slider_drilling.columns import Columns, TableExport
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.schema.option_types import check_argument
from slider_drilling.twin import COMPARED, Detection, Twin, TwinReport, TwinSettings, diagnose_after
from slider_drilling.twin.feed import LogFeed
from slider_drilling.twin.watch import watch as follow


@dataclass(frozen=True, repr=False)
class WatchResult(TableExport):
    """What a twin said of a log.

    Attributes:
        reports: One for each second.
        rig: The rig file, calibrated as far as the twin got.
        not_compared: Why no change could show, and what the twin needs; empty if one could.
        remarks: Of the twin: what stands for missing channels, and which samples are too few or of no such rig.
    """

    reports: tuple[TwinReport, ...]
    rig: Rig
    not_compared: str = ""
    remarks: tuple[str, ...] = ()

    @property
    def detections(self) -> tuple[Detection, ...]:
        """Changes of the rig, oldest first."""
        return self.reports[-1].detections if self.reports else ()

    def __repr__(self) -> str:
        found = "nothing compared" if self.not_compared else f"{len(self.detections)} changes"
        return f"WatchResult({len(self.reports)} s, {found})"

    def columns(self) -> Columns:
        """Time s, and for each channel the gap over 60 s and its threshold in noise levels; NaN where unknown."""
        columns = {"time": np.array([report.time for report in self.reports], dtype=float)}
        for name in COMPARED:
            for field in ("gap_60", "threshold"):
                values = [getattr(r.channels[name], field) if name in r.channels else np.nan for r in self.reports]
                columns[f"{name}_{field}"] = np.array(values, dtype=float)
        return Columns(columns)


def watch(
    log: str | RigLog | Run, rig: Rig | None = None, *, diagnose: bool = False, settings: TwinSettings = TwinSettings()
) -> WatchResult:
    """Simulate alongside a log.

    Args:
        log: A path, a log or a run.
        rig: The rig file; the log's own if None.
        diagnose: Whether to ask after a detection what is different, in a process of its own.
        settings: Of the twin.

    Raises:
        InputError: The log cannot be used, or is too short.
    """
    record = as_log(log)
    check_argument(settings, TwinSettings, "watch: settings")
    twin = Twin(record.rig() if rig is None else rig, settings, diagnose_after if diagnose else None, replayed=True)
    reports: list[TwinReport] = []
    try:
        follow(twin, LogFeed(record), reports.append, source=record.source)
    finally:
        twin.close()
    return WatchResult(tuple(reports), twin.calibrated_rig(), twin.not_compared, twin.remarks)
