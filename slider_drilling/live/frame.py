"""One frame for the browser, sent ten times a second: numbers in the page's units, as plain JSON."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np

from slider_drilling.angles import wrap_degrees
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.live.state import LiveState, StripSample
from slider_drilling.live.twin_state import ExpectedSample
from slider_drilling.rig import Rig
from slider_drilling.units import SI, Units, split_label
from slider_drilling.wellbore.well_path import WellPath

MAX_SAMPLES_PER_FRAME = 400
STRIPS = ("surface torque, kN m", "differential pressure, bar", "hook load, kN", "top drive, rad")
_WHOLE_UNITS = ("ft lbf", "psi")  # whose decimals nobody reads
_STATIONS = 161  # along the well
_FRICTION_FACTOR = 0.235  # assumed until the controller publishes its own


_Sample = TypeVar("_Sample", StripSample, ExpectedSample)


def samples_json(samples: Sequence[StripSample], units: Units = SI) -> list[list[float | None]]:
    """Time and the channels of `STRIPS` of each sample, in their units; of many samples, the extremes of torque."""
    return [
        [*_channels(sample, units), _rounded(units.convert(sample.top_drive_angle, "rad"), 3)]
        for sample in _few(samples)
    ]


def expected_json(samples: Sequence[ExpectedSample], units: Units = SI) -> list[list[float | None]]:
    """Time, torque, differential pressure, hook load and toolface (deg) that a twin expects, in units of the strips."""
    return [[*_channels(sample, units), _degrees(sample.tool_face)] for sample in _few(samples)]


def _few(samples: Sequence[_Sample]) -> Sequence[_Sample]:
    """The samples, thinned to as many as a frame holds."""
    return _thinned(samples, MAX_SAMPLES_PER_FRAME) if len(samples) > MAX_SAMPLES_PER_FRAME else samples


def _channels(sample: StripSample | ExpectedSample, units: Units) -> list[float | None]:
    """Time and the channels that are both measured and expected, in units of the strips."""
    return [
        round(sample.time, 3),
        _rounded(units.convert(sample.surface_torque / 1e3, "kN m"), 3),
        _rounded(units.convert(sample.differential_pressure / 1e5, "bar"), 2),
        _rounded(units.convert(sample.hook_load / 1e3, "kN"), 2),
    ]


def drilling_figures(state: LiveState, units: Units = SI) -> list[tuple[str, str]]:
    """What the figures beside the instruments are called, and their values in the page's units; "-" where unknown."""
    now, weight = state.drilling(), state.status_value("weight_on_bit", "by_hook_load_n")
    figures = (
        ("hook load", now.hook_load / 1e3, "kN"),
        ("weight on bit, by hook load", (math.nan if weight is None else weight) / 1e3, "kN"),
        ("rate of penetration", now.rate_of_penetration * 3600.0, "m/h"),
        ("bit depth", now.bit_depth, "m"),
        ("slide length", now.slide_length, "m"),
    )
    return [(name, units.format(value, unit, _figure_digits(value, unit, units))) for name, value, unit in figures]


def _figure_digits(value: float, unit: str, units: Units) -> int:
    """Significant digits that give a figure one decimal; a depth has two."""
    if not math.isfinite(value):
        return 3
    whole = abs(units.convert(value, unit))
    return max(len(f"{whole:.0f}") + (2 if unit == "m" else 1), 2)


def _thinned(samples: Sequence[_Sample], max_samples: int) -> list[_Sample]:
    """The lowest and the highest torque of each of equal stretches."""
    count = max_samples // 2
    edges = [round(k * len(samples) / count) for k in range(count + 1)]
    kept: list[_Sample] = []
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


def rocking_json(state: LiveState, units: Units = SI) -> dict[str, Any]:
    """Centre, amplitude and present angle of rocking in the unit for rad; its period, s."""
    latest = state.latest_sample()
    return {
        "centre": _converted(state.status_value("tool_face", "centre_rad"), "rad", units),
        "amplitude": _converted(state.status_value("reach", "amplitude_rad"), "rad", units),
        "period": state.status_value("reach", "period_s"),
        "angle": None if latest is None else _rounded(units.convert(latest.top_drive_angle, "rad"), 3),
    }


def labels_json(units: Units = SI) -> dict[str, Any]:
    """What the instruments write beside their numbers: titles and decimals of the strips, units of length and turn."""
    return {
        "strips": [units.convert_label(label) for label in STRIPS],
        "digits": [0 if units.display_unit(split_label(label)[1]) in _WHOLE_UNITS else 1 for label in STRIPS],
        "length": units.display_unit("m"),
        "turn": units.display_unit("rad"),
    }


class StringView:
    """The string along its well: the path, and the rotation at each depth by the controller's torque and drag model."""

    def __init__(self, rig: Rig, units: Units = SI) -> None:
        self._units = units
        self._depth = np.linspace(0.0, rig.string.length, _STATIONS)
        _, position = WellPath.from_survey(rig.well.survey).interpolate(self._depth)
        horizontal = np.hypot(np.diff(position[:, 0]), np.diff(position[:, 1]))
        self._departure = np.concatenate([[0.0], np.cumsum(horizontal)])
        self._vertical_depth = position[:, 2]
        self._model = TorqueAndDrag(rig, _FRICTION_FACTOR, 0.0)
        self._rotation: tuple[Any, dict[str, Any]] = (None, {})  # the statuses' values, and what follows from them

    def well_path_json(self) -> dict[str, Any]:
        """Measured depth, horizontal departure and vertical depth of the stations, in the unit of length."""
        return {
            "depth": _list(self._units.convert(self._depth, "m"), 1),
            "departure": _list(self._units.convert(self._departure, "m"), 1),
            "verticalDepth": _list(self._units.convert(self._vertical_depth, "m"), 1),
        }

    def rotation_json(self, state: LiveState) -> dict[str, Any]:
        """The limits of the zones; amplitude of rocking and lag by the reactive torque at each station."""
        known = tuple(state.status_value(subject, key) for subject, key in (
            ("reach", "rocking_m"), ("reach", "reactive_from_m"), ("reach", "amplitude_rad"),
            ("tool_face", "reactive_torque_n_m"), ("reach", "friction_over_assumed")))  # fmt: skip
        if known == self._rotation[0]:
            return self._rotation[1]
        rocked_to, reactive_from, amplitude, torque, scale = known
        rotation: dict[str, Any] = {"rocked_to": _converted(rocked_to, "m", self._units),
                                    "reactive_from": _converted(reactive_from, "m", self._units)}
        if amplitude is not None:
            remaining, lag = self._model.rotation_along(self._depth, amplitude, torque or 0.0, scale or 1.0)
            rotation |= {"amplitude": _list(self._units.convert(remaining, "rad"), 3),
                         "lag": _list(self._units.convert(lag, "rad"), 3)}
        self._rotation = (known, rotation)
        return rotation


def _converted(value: float | None, unit: str, units: Units) -> float | None:
    return None if value is None else units.convert(value, unit)


def _list(values: np.ndarray, digits: int) -> list[float]:
    return [round(float(value), digits) for value in values]


def _rounded(value: float, digits: int) -> float | None:
    return round(value, digits) if math.isfinite(value) else None


def _degrees(angle: float) -> float | None:
    return _wrapped(math.degrees(angle)) if math.isfinite(angle) else None


def _wrapped(degrees: float | None) -> float | None:
    return None if degrees is None or not math.isfinite(degrees) else round(wrap_degrees(degrees), 1)
