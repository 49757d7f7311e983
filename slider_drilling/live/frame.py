"""What goes to a browser ten times a second: numbers in the units that a page shows, as plain JSON."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.live.state import LiveState, StripSample
from slider_drilling.rig import Rig
from slider_drilling.wellbore.well_path import WellPath

MAX_SAMPLES_PER_FRAME = 400
_STATIONS = 161  # along the hole
_FRICTION_FACTOR = 0.235  # believed where the controller has not said what it believes


def samples_json(rows: Sequence[StripSample]) -> list[list[float | None]]:
    """(s, kN m, bar, rad) of each row; of many rows each stretch's extremes of torque are kept."""
    if len(rows) > MAX_SAMPLES_PER_FRAME:
        rows = _thinned(rows, MAX_SAMPLES_PER_FRAME)
    return [
        [
            round(one.time, 3),
            _shown(one.surface_torque / 1e3, 3),
            _shown(one.differential_pressure / 1e5, 2),
            _shown(one.top_drive_angle, 3),
        ]
        for one in rows
    ]


def _thinned(rows: Sequence[StripSample], most: int) -> list[StripSample]:
    edges = [round(k * len(rows) / (most // 2)) for k in range(most // 2 + 1)]
    kept: list[StripSample] = []
    for first, last in itertools.pairwise(edges):
        stretch = rows[first:last]
        low = min(stretch, key=lambda one: one.surface_torque)
        high = max(stretch, key=lambda one: one.surface_torque)
        kept += sorted({low, high}, key=lambda one: one.time)
    return kept


def dial_json(state: LiveState) -> dict[str, Any]:
    """Toolfaces in deg: target, estimate with its spread, measured ones with their age in s, truth."""
    newest = state.latest_sample()
    now = newest.time if newest is not None else 0.0
    return {
        "target": _degrees(state.target),
        "estimate": _wrapped(state.status_value("tool_face", "estimate_deg")),
        "spread": state.status_value("tool_face", "one_sigma_deg"),
        "measured": [
            [round(max(now - dot.measured_at, 0.0), 1), _degrees(dot.tool_face)] for dot in state.tool_faces()
        ],
        "truth": None if state.truth is None else _degrees(state.truth),
    }


def rocking_json(state: LiveState) -> dict[str, Any]:
    """Where rocking goes: centre, amplitude and present angle, rad; period, s."""
    newest = state.latest_sample()
    return {
        "centre": state.status_value("tool_face", "centre_rad"),
        "amplitude": state.status_value("reach", "amplitude_rad"),
        "period": state.status_value("reach", "period_s"),
        "angle": None if newest is None else _shown(newest.top_drive_angle, 3),
    }


class StringView:
    """The string along its hole: where it lies, and how it turns by the controller's own belief."""

    def __init__(self, rig: Rig) -> None:
        self._depth = np.linspace(0.0, rig.string.length, _STATIONS)
        _, position = WellPath.from_survey(rig.well.survey).interpolate(self._depth)
        sideways = np.hypot(np.diff(position[:, 0]), np.diff(position[:, 1]))
        self._away = np.concatenate([[0.0], np.cumsum(sideways)])
        self._down = position[:, 2]
        self._belief = TorqueAndDrag(rig, _FRICTION_FACTOR, 0.0)
        self._turning: tuple[Any, dict[str, Any]] = (None, {})

    def well_path_json(self) -> dict[str, Any]:
        """Measured depth, horizontal departure and vertical depth of the stations, m."""
        return {"depth": _list(self._depth, 1), "away": _list(self._away, 1), "down": _list(self._down, 1)}

    def rotation_json(self, state: LiveState) -> dict[str, Any]:
        """The three zones, m, and rad at each station: half-amplitude left, and lag by the reactive torque."""
        known = tuple(state.status_value(what, key) for what, key in (
            ("reach", "rocking_m"), ("reach", "reactive_from_m"), ("reach", "amplitude_rad"),
            ("tool_face", "reactive_torque_n_m"), ("reach", "friction_over_assumed")))  # fmt: skip
        if known == self._turning[0]:
            return self._turning[1]
        rocked_to, reactive_from, amplitude, torque, scale = known
        shown: dict[str, Any] = {"rocked_to": rocked_to, "reactive_from": reactive_from}
        if amplitude is not None:
            swing, behind = self._belief.rotation_along(self._depth, amplitude, torque or 0.0, scale or 1.0)
            shown |= {"swing": _list(swing, 3), "behind": _list(behind, 3)}
        self._turning = (known, shown)
        return shown


def _list(values: np.ndarray, digits: int) -> list[float]:
    return [round(float(value), digits) for value in values]


def _shown(value: float, digits: int) -> float | None:
    return round(value, digits) if math.isfinite(value) else None


def _degrees(angle: float) -> float | None:
    return _wrapped(math.degrees(angle)) if math.isfinite(angle) else None


def _wrapped(degrees: float | None) -> float | None:
    return None if degrees is None or not math.isfinite(degrees) else round(math.remainder(degrees, 360.0), 1)
