"""A log of a short well, rocked and lowered, with sensors that are read right; and the means to spoil it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.drillstring import Commands, simulate
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log.series import JointSeries, ScalarSeries
from slider_drilling.log_checks import LogChecks, check_log
from slider_drilling.rig import Rig


def rocking(duration=80.0, amplitude=5.0, lowering=0.004) -> Commands:
    time = np.arange(0.0, duration, 0.1)
    omega = 2.0 * np.pi / 8.0
    angle, speed = amplitude * (1.0 - np.cos(omega * time)), amplitude * omega * np.sin(omega * time)
    return Commands(time, angle, speed, lowering * time, lowering + 0.0 * time, 12.3 + 0.0 * time)


def recorded(rig: Rig, run: Commands) -> RigLog:
    response = simulate(rig, run, 40)
    noise = np.random.default_rng(5)
    time, size = run.time, run.time.size

    def noisy(values, sigma):
        return values + sigma * noise.normal(size=size)

    mwd = np.arange(12.0, time[-1], 12.0)
    face = np.angle(np.exp(1j * np.interp(mwd, time, response.tool_face)))
    missing, none = np.full(size, np.nan), np.full(mwd.size, np.nan)
    return RigLog(
        "run.mcap", 0,
        top_drive=JointSeries(time, time, run.top_drive_angle, run.top_drive_speed,
                              noisy(response.surface_torque, 150.0)),
        draw_works=JointSeries(time, time, run.block_position, run.block_speed, noisy(response.hook_load, 4000.0)),
        standpipe_pressure=ScalarSeries(time, time, noisy(response.standpipe_pressure, 4e4), missing),
        mud_pump=JointSeries(time, time, missing, run.pump_speed, missing),
        mwd_tool_face=JointSeries(mwd, mwd + 6.0, face, none, none),
    )  # fmt: skip


def changed(log: RigLog, series: str, **columns) -> RigLog:
    """A log with columns of one series put through functions."""
    own = getattr(log, series)
    return replace(log, **{series: replace(own, **{k: f(getattr(own, k).copy()) for k, f in columns.items()})})


def error_of(log: RigLog, rig: Rig) -> str:
    with pytest.raises(InputError) as caught:
        check_log(log, rig).raise_if_unusable()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def rows_of(checked: LogChecks) -> dict[str, tuple[str, str]]:
    return {row.check: (row.result, str(row.text)) for row in checked.rows()}
