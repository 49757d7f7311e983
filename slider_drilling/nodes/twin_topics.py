"""Publishes what a twin reports: expected channels, gap, trends, forecast and the diagnosis."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String

from slider_drilling.messages import cdr
from slider_drilling.messages.topics import (
    GAP_DIAGNOSIS,
    GAP_THRESHOLD,
    GAP_TOPICS,
    TOPICS,
    TREND_TOPICS,
    TWIN_SERIES,
)
from slider_drilling.nodes import raw_topics
from slider_drilling.twin import COMPARED, Forecast, TwinReport
from slider_drilling.twin.gap_diagnosis import gap_diagnosis

NOTE_PERIOD = 10.0  # s of the rig's time between messages in which only the note is another one


class TwinPublishers:
    """A twin's topics. Times of a report are s since the twin's start; stamps are ns of the rig's clock.

    Args:
        node: Makes the publishers.
        pressure_variance: Of the expected standpipe pressure: that of the sensor, Pa2.
    """

    def __init__(self, node: Node, pressure_variance: float) -> None:
        self._variance = pressure_variance
        self._channels = {key: raw_topics.publisher(node, topic) for key, topic in TWIN_SERIES.items()}
        self._gaps = {seconds: raw_topics.publisher(node, topic) for seconds, topic in GAP_TOPICS.items()}
        self._threshold = raw_topics.publisher(node, GAP_THRESHOLD)
        self._trends = {bound: raw_topics.publisher(node, topic) for bound, topic in TREND_TOPICS.items()}
        self._diagnosis = node.create_publisher(String, GAP_DIAGNOSIS.name, raw_topics.LATCHED_WORDS)
        self._last_diagnosis: tuple[object, ...] = ()
        self._last_note = (-math.inf, "")  # s and text
        self._forecast_until = -math.inf  # s

    def restart(self) -> None:
        """The twin starts anew: its times do, too."""
        self._forecast_until = -math.inf
        self._last_diagnosis = ()
        self._last_note = (-math.inf, "")

    def publish(self, report: TwinReport, start_ns: int) -> None:
        """Publish one report.

        Args:
            report: The twin's.
            start_ns: Stamp of the twin's time 0.
        """
        self._publish_expected(report, start_ns)
        stamp = start_ns + round(report.time * 1e9)
        # Always all channels in the same order: viewers find them by their place.
        for seconds, publisher in self._gaps.items():
            _publish_numbers(publisher, stamp, _of_channels(report, f"gap_{seconds}"))
        _publish_numbers(self._threshold, stamp, _of_channels(report, "threshold"))
        trends = report.trends
        for bound, publisher in self._trends.items():
            end = {"value": "value", "lower": "low", "upper": "high"}[bound]
            _publish_numbers(publisher, stamp, {name: getattr(trend, end) for name, trend in trends.items()})
        if report.forecast is not None:
            self._publish_forecast(report.forecast, start_ns)

    def _publish_expected(self, report: TwinReport, start_ns: int) -> None:
        """The expected channels at every sample, the torque last, as a rig publishes its own."""
        expected = report.expected
        for k, time in enumerate(report.samples.tolist()):
            stamp = start_ns + round(time * 1e9)
            if "standpipe_pressure" in expected:
                pressure = float(expected["standpipe_pressure"][k])
                data = cdr.encode_fluid_pressure(stamp, pressure, self._variance)
                self._channels["expected_standpipe_pressure"].publish(data)
            if "hook_load" in expected:
                self._publish_joint("expected_draw_works", stamp, effort=float(expected["hook_load"][k]))
            if "tool_face" in expected:
                self._publish_tool_face("expected_mwd_tool_face", stamp, float(expected["tool_face"][k]))
            if "surface_torque" in expected:
                self._publish_joint("expected_top_drive", stamp, effort=float(expected["surface_torque"][k]))

    def _publish_forecast(self, forecast: Forecast, start_ns: int) -> None:
        """The part of a forecast that reaches further than those before: each time has one, and stamps rise."""
        ahead = [k for k, time in enumerate(forecast.time.tolist()) if time > self._forecast_until]
        for k in ahead:
            stamp = start_ns + round(float(forecast.time[k]) * 1e9)
            self._publish_joint("forecast_top_drive", stamp, effort=float(forecast.surface_torque[k]))
            self._publish_tool_face("forecast_mwd_tool_face", stamp, float(forecast.tool_face[k]))
        if ahead:
            self._forecast_until = float(forecast.time[-1])

    def _publish_joint(self, key: str, stamp_ns: int, effort: float) -> None:
        self._channels[key].publish(cdr.encode_joint_state(stamp_ns, TOPICS[key].joint, effort=effort))

    def _publish_tool_face(self, key: str, stamp_ns: int, angle: float) -> None:
        wrapped = math.remainder(angle, 2.0 * math.pi) if math.isfinite(angle) else math.nan
        self._channels[key].publish(cdr.encode_joint_state(stamp_ns, TOPICS[key].joint, wrapped))

    def publish_diagnosis(
        self, report: TwinReport, start: float, answer: Mapping[str, Any] | None, answered: float | None
    ) -> None:
        """Publish `gap/diagnosis` if it has changed; another note alone waits NOTE_PERIOD.

        Args:
            report: The latest.
            start: The twin's time 0, s of the rig's clock.
            answer: Of the last diagnosis, as diagnosis.json has it.
            answered: Time of the answer, s since the twin's start.
        """
        key = (report.state, report.detections, answered)
        noted_at, note = self._last_note
        if key == self._last_diagnosis and (note == report.note or report.time - noted_at < NOTE_PERIOD):
            return
        self._last_diagnosis, self._last_note = key, (report.time, report.note)
        tree = gap_diagnosis(report, start, answer, answered)
        self._diagnosis.publish(String(data=json.dumps(tree, allow_nan=False)))


def _of_channels(report: TwinReport, attribute: str) -> dict[str, float]:
    """A number of every channel; NaN for one that the rig does not have."""
    return {name: getattr(report.channels.get(name), attribute, math.nan) for name in COMPARED}


def _publish_numbers(publisher: Publisher, stamp_ns: int, numbers: Mapping[str, float]) -> None:
    """A JointState that holds a number for each name; nothing without a name."""
    if numbers:
        positions = [float(number) for number in numbers.values()]
        publisher.publish(cdr.encode_joint_states(stamp_ns, tuple(numbers), positions, ()))
