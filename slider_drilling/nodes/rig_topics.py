"""Publishes the virtual rig's channels, one sample at a time."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher

from slider_drilling.control.interface import Measurements
from slider_drilling.drillstring.virtual_rig import GroundTruth
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.joint_names import named

MWD = TOPICS["mwd_tool_face"]
_FIELDS = {source: {field.name for field in dataclasses.fields(source)} for source in (GroundTruth, Measurements)}


def _published_topics() -> list[Topic]:
    """The topics whose quantities a sample has: ground truth first, the top drive last."""

    def has_quantity(topic: Topic) -> bool:
        fields = _FIELDS[GroundTruth if topic.is_simulated_only else Measurements]
        return any(quantity.column in fields for quantity in topic.quantities)

    topics = [topic for topic in reversed(TOPICS.values()) if has_quantity(topic)]
    return sorted(topics, key=lambda topic: not topic.is_simulated_only)


class RigPublishers:
    """Publishes /clock and the rig's channels, the top drive's last because controllers act on it.

    The last sample is kept, for a controller that joined too late to receive it.

    Args:
        node: Makes the publishers.
        pressure_variance: Of the standpipe pressure sensor, Pa2.
        joints: Values of the parameters that name the joints.
    """

    def __init__(self, node: Node, pressure_variance: float, joints: Mapping[str, Any]) -> None:
        self._variance = pressure_variance
        self._clock = raw_topics.publisher(node, raw_topics.CLOCK)
        self._mwd = raw_topics.publisher(node, MWD)
        topics = [named(topic, joints) for topic in _published_topics()]
        self._channels = [(topic, raw_topics.publisher(node, topic)) for topic in topics]
        self._sample: list[tuple[Publisher, bytes]] = []

    @property
    def subscription_count(self) -> int:
        """Subscriptions to the top drive's readings."""
        return int(self._channels[-1][1].get_subscription_count())

    def publish(
        self,
        start_ns: int,
        stamp_ns: int,
        measurements: Measurements,
        truth: GroundTruth,
        before_top_drive: Callable[[], None],
    ) -> None:
        """Publish one sample.

        Args:
            start_ns: Stamp of the rig's time 0.
            stamp_ns: Stamp of the sample.
            measurements: Surface channels and the toolfaces that arrived.
            truth: The rig's true state.
            before_top_drive: Called before the top drive's reading is published.
        """
        self._sample = [(self._clock, cdr.encode_clock(stamp_ns))]
        for mwd in measurements.mwd:
            measured_ns = start_ns + round(mwd.measured_at * 1e9)
            self._sample.append((self._mwd, cdr.encode_joint_state(measured_ns, MWD.joint, mwd.tool_face)))
        for topic, publisher in self._channels:
            source = truth if topic.is_simulated_only else measurements
            self._sample.append((publisher, cdr.encode_numbers(topic, stamp_ns, self._numbers(topic, source))))
        for publisher, data in self._sample[:-1]:
            publisher.publish(data)
        before_top_drive()
        publisher, data = self._sample[-1]
        publisher.publish(data)

    def resend(self) -> None:
        """Publish the last sample again."""
        for publisher, data in self._sample:
            publisher.publish(data)

    def _numbers(self, topic: Topic, source: GroundTruth | Measurements) -> list[float]:
        """A message's numbers; NaN for those that a sample does not have."""
        numbers = [float(getattr(source, quantity.column, math.nan)) for quantity in topic.quantities]
        return [*numbers, self._variance] if topic is TOPICS["standpipe_pressure"] else numbers
