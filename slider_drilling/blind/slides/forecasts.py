"""Errors of the twin's forecasts, beside those of simpler ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.diagnosis.replay import replay
from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.twin import Forecast, TwinReport

AHEAD_S = 60.0
"""How far ahead a forecast is scored."""
_WINDOW_S = 10.0  # s before that time, over which torque is compared


@dataclass(frozen=True)
class ForecastErrors:
    """RMS errors of forecasts `AHEAD_S` ahead; None where none could be compared.

    Attributes:
        count: Forecasts that were compared.
        torque: Of the twin, N m.
        torque_unchanged: Of "torque stays as it is".
        torque_uncalibrated: Of the model with the rig file as given, driven by the same log.
        tool_face: Of the twin, rad: of the change of the toolface from now on.
        tool_face_unchanged: Of "the toolface stays as it is".
        tool_face_uncalibrated: Of the model with the rig file as given.
    """

    count: int = 0
    torque: float | None = None
    torque_unchanged: float | None = None
    torque_uncalibrated: float | None = None
    tool_face: float | None = None
    tool_face_unchanged: float | None = None
    tool_face_uncalibrated: float | None = None


class ForecastLog:
    """Collects the forecasts of a run."""

    def __init__(self) -> None:
        self._made: dict[float, Forecast] = {}

    def add(self, report: TwinReport) -> None:
        """Keep the forecast of a report, if it has one and compares what it sees."""
        forecast = report.forecast
        if forecast is not None and report.state == "watching":
            self._made.setdefault(forecast.made_at, forecast)

    def errors(self, log: RigLog, rig: Rig) -> ForecastErrors:
        """Compare all forecasts with what came.

        Args:
            log: The whole log.
            rig: The rig file as given.
        """
        if log.top_drive is None or not self._made:
            return ForecastErrors()
        given = replay(log, rig).response
        torque: list[tuple[float, float, float]] = []
        face: list[tuple[float, float, float]] = []
        for made in self._made.values():
            torque += _torque_errors(made, log, given.time, given.surface_torque)
            face += _tool_face_errors(made, log, given.time, given.tool_face)
        return ForecastErrors(len(self._made), *_columns(torque), *_columns(face))


def _torque_errors(made: Forecast, log: RigLog, time: Array, given: Array) -> list[tuple[float, float, float]]:
    """(twin, unchanged, as given) of each sample of the window."""
    drive = log.top_drive
    assert drive is not None
    end = made.made_at + AHEAD_S
    inside = (drive.time > end - _WINDOW_S) & (drive.time <= end) & np.isfinite(drive.effort)
    known = np.flatnonzero((drive.time <= made.made_at) & np.isfinite(drive.effort))
    if made.time[-1] < end - 1.0 or not inside.any() or not known.size:
        return []
    at, measured = drive.time[inside], drive.effort[inside]
    rows = (
        np.interp(at, made.time, made.surface_torque),
        np.full(at.shape, drive.effort[known[-1]]),
        np.interp(at, time, given),
    )
    return [(a - m, b - m, c - m) for a, b, c, m in zip(*rows, measured, strict=True)]


def _tool_face_errors(made: Forecast, log: RigLog, time: Array, given: Array) -> list[tuple[float, float, float]]:
    """(twin, unchanged, as given) of the change between the last toolface known and the one about `AHEAD_S` later."""
    mwd = log.mwd_tool_face
    if mwd is None:
        return []
    before = np.flatnonzero(mwd.arrival <= made.made_at)
    later = np.flatnonzero((mwd.time > made.made_at) & (mwd.time <= made.made_at + AHEAD_S))
    if not before.size or not later.size:
        return []
    first, last = before[-1], later[-1]
    begin, end = float(mwd.time[first]), float(mwd.time[last])
    if end > made.time[-1]:
        return []
    change = math.remainder(float(mwd.position[last] - mwd.position[first]), 2.0 * math.pi)
    forecast_change = float(np.interp(end, made.time, made.tool_face)) - float(mwd.position[first])
    as_given = float(np.interp(end, time, given) - np.interp(begin, time, given))
    return [tuple(math.remainder(x - change, 2.0 * math.pi) for x in (forecast_change, 0.0, as_given))]  # type: ignore[list-item]


def _columns(rows: list[tuple[float, float, float]]) -> list[float | None]:
    """RMS of each of the three columns; None without rows."""
    if not rows:
        return [None, None, None]
    return [float(value) for value in np.sqrt(np.mean(np.square(rows), axis=0))]
