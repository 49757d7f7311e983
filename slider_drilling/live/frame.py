"""One frame for the browser, sent ten times a second: numbers in the page's units, as plain JSON."""

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
_STATIONS = 161  # along the well
_FRICTION_FACTOR = 0.235  # assumed until the controller publishes its own


def samples_json(samples: Sequence[StripSample]) -> list[list[float | None]]:
    """Time s, torque kN m, pressure bar and angle rad of each sample; of many, the extremes of torque are kept."""
    if len(samples) > MAX_SAMPLES_PER_FRAME:
        samples = _thinned(samples, MAX_SAMPLES_PER_FRAME)
    return [
        [
            round(sample.time, 3),
            _rounded(sample.surface_torque / 1e3, 3),
            _rounded(sample.differential_pressure / 1e5, 2),
            _rounded(sample.top_drive_angle, 3),
        ]
        for sample in samples
    ]


def _thinned(samples: Sequence[StripSample], max_samples: int) -> list[StripSample]:
    """The lowest and the highest torque of each of equal stretches."""
    count = max_samples // 2
    edges = [round(k * len(samples) / count) for k in range(count + 1)]
    kept: list[StripSample] = []
    for first, last in itertools.pairwise(edges):
        stretch = samples[first:last]
        low = min(stretch, key=lambda sample: sample.surface_torque)
        high = max(stretch, key=lambda sample: sample.surface_torque)
        kept += sorted({low, high}, key=lambda sample: sample.time)
    return kept


def dial_json(state: LiveState) -> dict[str, Any]:
    """Toolfaces, deg: target, estimate with its standard deviation, measured ones with their age in s, truth."""
    latest = state.latest_sample()
    now = latest.time if latest is not None else 0.0
    return {
        "target": _degrees(state.target),
        "estimate": _wrapped(state.status_value("tool_face", "estimate_deg")),
        "spread": state.status_value("tool_face", "one_sigma_deg"),
        "measured": [
            [round(max(now - point.measured_at, 0.0), 1), _degrees(point.tool_face)] for point in state.tool_faces()
        ],
        "truth": None if state.truth is None else _degrees(state.truth),
    }


def rocking_json(state: LiveState) -> dict[str, Any]:
    """Centre, amplitude and present angle of rocking, rad; its period, s."""
    latest = state.latest_sample()
    return {
        "centre": state.status_value("tool_face", "centre_rad"),
        "amplitude": state.status_value("reach", "amplitude_rad"),
        "period": state.status_value("reach", "period_s"),
        "angle": None if latest is None else _rounded(latest.top_drive_angle, 3),
    }


class StringView:
    """The string along its well: the path, and the rotation at each depth by the controller's torque and drag model."""

    def __init__(self, rig: Rig) -> None:
        self._depth = np.linspace(0.0, rig.string.length, _STATIONS)
        _, position = WellPath.from_survey(rig.well.survey).interpolate(self._depth)
        horizontal = np.hypot(np.diff(position[:, 0]), np.diff(position[:, 1]))
        self._departure = np.concatenate([[0.0], np.cumsum(horizontal)])
        self._vertical_depth = position[:, 2]
        self._model = TorqueAndDrag(rig, _FRICTION_FACTOR, 0.0)
        self._rotation: tuple[Any, dict[str, Any]] = (None, {})  # the statuses' values, and what follows from them

    def well_path_json(self) -> dict[str, Any]:
        """Measured depth, horizontal departure and vertical depth of the stations, m."""
        return {
            "depth": _list(self._depth, 1),
            "departure": _list(self._departure, 1),
            "verticalDepth": _list(self._vertical_depth, 1),
        }

    def rotation_json(self, state: LiveState) -> dict[str, Any]:
        """The limits of the zones, m; amplitude of rocking and lag by the reactive torque at each station, rad."""
        known = tuple(state.status_value(subject, key) for subject, key in (
            ("reach", "rocking_m"), ("reach", "reactive_from_m"), ("reach", "amplitude_rad"),
            ("tool_face", "reactive_torque_n_m"), ("reach", "friction_over_assumed")))  # fmt: skip
        if known == self._rotation[0]:
            return self._rotation[1]
        rocked_to, reactive_from, amplitude, torque, scale = known
        rotation: dict[str, Any] = {"rocked_to": rocked_to, "reactive_from": reactive_from}
        if amplitude is not None:
            remaining, lag = self._model.rotation_along(self._depth, amplitude, torque or 0.0, scale or 1.0)
            rotation |= {"amplitude": _list(remaining, 3), "lag": _list(lag, 3)}
        self._rotation = (known, rotation)
        return rotation


def _list(values: np.ndarray, digits: int) -> list[float]:
    return [round(float(value), digits) for value in values]


def _rounded(value: float, digits: int) -> float | None:
    return round(value, digits) if math.isfinite(value) else None


def _degrees(angle: float) -> float | None:
    return _wrapped(math.degrees(angle)) if math.isfinite(angle) else None


def _wrapped(degrees: float | None) -> float | None:
    return None if degrees is None or not math.isfinite(degrees) else round(math.remainder(degrees, 360.0), 1)
