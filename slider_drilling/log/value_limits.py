"""Values that no rig can show, far beyond any unit's mistake, taken out of a log so that arithmetic stays finite."""

from __future__ import annotations

import dataclasses

import numpy as np

from slider_drilling.log.series import JointSeries, RigLog, ScalarSeries

# Far above what a rig can do in any unit that logs come in: a stuck bit of a float, not a large reading, is beyond.
MOST = {
    "top_drive": {"position": 1e8, "velocity": 1e5, "effort": 1e9},
    "top_drive_command": {"position": 1e8, "velocity": 1e5, "effort": 1e9},
    "draw_works": {"position": 1e7, "velocity": 1e5, "effort": 1e11},
    "draw_works_command": {"position": 1e7, "velocity": 1e5, "effort": 1e11},
    "standpipe_pressure": {"value": 1e11, "variance": 1e22},
    "mud_pump": {"position": 1e10, "velocity": 1e6, "effort": 1e11},
    "mwd_tool_face": {"position": 1e6},
    "tool_face_target": {"position": 1e6},
}
"""Magnitude per channel and array, SI."""


def mask_impossible_values(log: RigLog) -> RigLog:
    """The log with impossible values as not given (NaN), each channel's count and first one among the notes."""
    changes: dict[str, JointSeries | ScalarSeries] = {}
    notes = []
    for key, limits in MOST.items():
        series = getattr(log, key)
        if series is None:
            continue
        for name, most in limits.items():
            values = getattr(series, name)
            beyond = np.flatnonzero(np.abs(values) > most)  # false for NaN
            if beyond.size:
                first = int(beyond[0])
                notes.append(
                    f"{key}.{name}: {beyond.size} of {values.size} values no rig has left out, the first "
                    f"{values[first]:g} at {series.time[first]:.1f} s"
                )
                series = dataclasses.replace(series, **{name: np.where(np.abs(values) > most, np.nan, values)})
                changes[key] = series
    return dataclasses.replace(log, notes=(*log.notes, *notes), **changes) if changes else log  # type: ignore[arg-type]
