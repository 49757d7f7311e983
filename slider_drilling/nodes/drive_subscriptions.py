"""Subscriptions to the drives' readings: a topic for each, or one topic that holds the joints of all three."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from rclpy.node import Node

from slider_drilling.messages.topics import JOINT_STATE, TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.joint_names import named
from slider_drilling.nodes.parameters import NodeParameter

DRIVES = ("mud_pump", "draw_works", "top_drive")  # keys of TOPICS; the top drive's reading completes a sample
COMMON_TOPIC = NodeParameter(
    "joint_states", "", "topic whose messages hold all three drives, joints named as below; empty: a topic for each"
)


def drive_subscriptions(
    node: Node, values: Mapping[str, Any], receiver: Callable[[str], Callable[..., None]]
) -> list[raw_topics.SensorSubscription]:
    """The drives' subscriptions, the top drive's last; or the one to the topic that holds them all.

    Args:
        node: Subscribes.
        values: Of its parameters COMMON_TOPIC and JOINT_NAMES.
        receiver: Key of a drive -> what is called with stamp, ns, position, velocity and effort of its readings.
    """
    common = values[COMMON_TOPIC.name]
    topics = [named(TOPICS[key], values) for key in DRIVES]
    if common:
        topics = [replace(topic, name=common) for topic in topics]
    receivers = [raw_topics.decoding(node, topic, receiver(key)) for key, topic in zip(DRIVES, topics, strict=True)]
    if not common:
        pairs = zip(topics, receivers, strict=True)
        return [raw_topics.SensorSubscription(node, topic, receive) for topic, receive in pairs]

    def receive_all(data: bytes) -> None:
        for receive in receivers:
            receive(data)

    return [raw_topics.SensorSubscription(node, Topic(common, JOINT_STATE), receive_all)]
