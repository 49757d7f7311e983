"""The twin: samples in, once a second a report out."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from slider_drilling.control.interface import Measurements
from slider_drilling.drillstring import InitialState
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.twin.ask import Ask
from slider_drilling.twin.channels import CHANNELS, COMPARED, declared_noise
from slider_drilling.twin.follower import Followed, Follower
from slider_drilling.twin.gap import WINDOWS_S, RunningGap
from slider_drilling.twin.history import History
from slider_drilling.twin.motion import DriveMotion, add_speed_integral, new_buffers
from slider_drilling.twin.report import ChannelState, Detection, TwinReport
from slider_drilling.twin.samples import Array
from slider_drilling.twin.settings import TwinSettings
from slider_drilling.twin.tracked import rig_at, tracked_parameters

_REPORT_S = 1.0
_HISTORY_S = 400.0


class Twin:
    """Simulates alongside a rig. For one thread; `add` and `advance` take milliseconds and never wait.

    Args:
        rig: The rig file.
        settings: How it follows the rig.
        ask: Asked in a process of its own after a detection; None for no diagnosis.
    """

    def __init__(self, rig: Rig, settings: TwinSettings = TwinSettings(), ask: Ask | None = None) -> None:
        self.rig, self.settings = rig, settings
        self._ask = ask
        self._buffers = new_buffers(settings.kept)
        self._motion = DriveMotion(rig, self._buffers, settings.patience)
        self._parameters = tracked_parameters(rig)
        self._follower: Follower | None = None
        self._history = History(_HISTORY_S)
        self._gaps = {name: RunningGap(declared_noise(rig, name)) for name in COMPARED}
        self._next = math.nan  # s, the first grid time that is not simulated yet
        self._samples = round(_REPORT_S / settings.interval)
        self.report: TwinReport | None = None
        self.detections: tuple[Detection, ...] = ()

    def add(self, channel: str, times: ArrayLike, values: ArrayLike) -> None:
        """Take samples of one channel: any number, in any order.

        Args:
            channel: One of `channels.CHANNELS`.
            times: s, when they were measured, one or (n,).
            values: SI, as many; NaN is a missing value.

        Raises:
            InputError: The channel is unknown.
        """
        if channel not in self._buffers:
            raise InputError(f"twin: {channel}: no such channel; use {', '.join(CHANNELS)}")
        time, value = np.atleast_1d(np.asarray(times, float)), np.atleast_1d(np.asarray(values, float))
        self._buffers[channel].add(time, value)

    def add_measurements(self, measurements: Measurements) -> None:
        """Take one sample of all channels at surface, and the toolfaces that came with it."""
        for name in CHANNELS:
            if name != "tool_face":
                self.add(name, measurements.time, getattr(measurements, name))
        for sample in measurements.mwd:
            self.add("tool_face", sample.measured_at, sample.tool_face)

    def advance(self) -> list[TwinReport]:
        """Simulate every second whose samples have arrived; returns a report for each."""
        return self._advance(self._motion.known_until())

    def finish(self) -> list[TwinReport]:
        """Simulate what is left when no more samples come; returns the reports."""
        return self._advance(self._motion.newest)

    def calibrated_rig(self) -> Rig:
        """The rig file with the numbers as they are now."""
        values = (
            {p.name: p.nominal for p in self._parameters}
            if self._follower is None
            else self._follower.values(self._follower.centre)
        )
        return rig_at(self.rig, values)

    def _advance(self, until: float) -> list[TwinReport]:
        reports: list[TwinReport] = []
        if math.isnan(self._next):
            start = self._motion.started
            if not math.isfinite(start):
                return reports
            self._next = start
        interval = self.settings.interval
        while self._next + (self._samples - 1) * interval <= until + 1e-9:
            grid: Array = self._next + interval * np.arange(self._samples, dtype=float)
            self._next = float(grid[-1] + interval)
            reports.append(self._step(grid))
        return reports

    def _step(self, grid: Array) -> TwinReport:
        for position, speed in (("top_drive_angle", "top_drive_speed"), ("block_position", "block_speed")):
            if not len(self._buffers[position]):
                add_speed_integral(self._buffers, position, speed)
        commands = self._motion.commands(grid)
        if self._follower is None:
            s = self.settings
            self._follower = Follower(
                self.rig, self._parameters, s.elements, s.interval, s.observer_gain, InitialState()
            )
        followed = self._follower.advance(commands, self._measured("surface_torque", grid))
        self._history.add(followed, commands)
        self.report = self._report(grid, followed)
        return self.report

    def _measured(self, channel: str, grid: Array) -> Array:
        """A channel on the grid, NaN where it was not measured."""
        buffer = self._buffers[channel]
        time, value = buffer.time, buffer.value
        if not time.size:
            return np.full(grid.shape, np.nan)
        near = np.abs(time[np.clip(np.searchsorted(time, grid), 0, time.size - 1)] - grid)
        before = np.abs(time[np.clip(np.searchsorted(time, grid) - 1, 0, time.size - 1)] - grid)
        measured = np.interp(grid, time, value)
        return np.where(np.minimum(near, before) <= 2.0 * self.settings.interval, measured, np.nan)

    def _report(self, grid: Array, followed: Followed) -> TwinReport:
        names: Sequence[str] = list(COMPARED)
        centre = followed.at(followed.centre)
        expected = {name: centre[:, row] for row, name in enumerate(names)}
        states = {}
        for name in names:
            if len(self._buffers[name]):
                states[name] = self._channel_state(name, grid, expected[name])
        return TwinReport(float(grid[-1]), "learning", "", grid, expected, states, detections=self.detections)

    def _channel_state(self, name: str, grid: Array, expected: Array) -> ChannelState:
        gap, end = self._gaps[name], float(grid[-1])
        if name != "tool_face":
            gap.add(end, self._measured(name, grid) - expected)
        e10, e60, e300 = (gap.over(window, end) for window in WINDOWS_S)
        measured = float(self._buffers[name].value[-1])
        return ChannelState(
            name, COMPARED[name].unit, measured, float(expected[-1]), e10, e60, e300, math.nan, gap.noise
        )
