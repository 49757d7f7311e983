"""The samples that a twin keeps, as a log that can be diagnosed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log.series import JointSeries, ScalarSeries
from slider_drilling.rig import Rig, dump_rig
from slider_drilling.twin.samples import Array, SampleBuffer


def recorded_log(buffers: Mapping[str, SampleBuffer], rig: Rig, begin: float, end: float) -> RigLog:
    """A log of the samples from `begin` to `end`, s; its t = 0 is the first sample of the top drive in it.

    Args:
        buffers: By channel.
        rig: The rig file.
    """
    windows = {name: buffer.window(begin, end) for name, buffer in buffers.items()}
    drives = [windows[name][0] for name in ("top_drive_angle", "top_drive_speed", "surface_torque")]
    start = float(min((time[0] for time in drives if time.size), default=begin))

    def joint(position: str, velocity: str, effort: str) -> JointSeries | None:
        time = _union([windows[name][0] for name in (position, velocity, effort) if name])
        if not time.size:
            return None
        arrays = (_at(time, windows.get(name)) for name in (position, velocity, effort))
        return JointSeries(time - start, time - start, *arrays)

    pressure_time, pressure = windows["standpipe_pressure"]
    standpipe = None
    if pressure_time.size:
        unknown = np.full(pressure.shape, np.nan)
        standpipe = ScalarSeries(pressure_time - start, pressure_time - start, pressure, unknown)
    return RigLog(
        source=f"samples from {begin:.0f} to {end:.0f} s", start_ns=round(start * 1e9), rig_text=dump_rig(rig),
        rig_source="the twin's rig file",
        top_drive=joint("top_drive_angle", "top_drive_speed", "surface_torque"),
        draw_works=joint("block_position", "block_speed", "hook_load"), standpipe_pressure=standpipe,
        mud_pump=joint("", "pump_speed", ""), mwd_tool_face=joint("tool_face", "", ""),
    )  # fmt: skip


def _union(times: list[Array]) -> Array:
    first = times[0]
    if all(time.size == first.size and np.array_equal(time, first) for time in times[1:]):
        return first
    return np.unique(np.concatenate(times))


def _at(time: Array, samples: tuple[Array, Array] | None) -> Array:
    """Values at these times, NaN where there is no sample of exactly that time."""
    values = np.full(time.shape, np.nan)
    if samples is not None:
        values[np.searchsorted(time, samples[0])] = samples[1]
    return values
