"""Topics of a node as bytes: relative names, one quality of service, the encoding of the logs."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from slider_drilling.messages.topics import JOINT_STATE, Topic

# The one topic beside those of a log: a controller's pump speed has to reach the rig.
PUMP_COMMAND = Topic("mud_pump/command", JOINT_STATE, "mud_pump")
CLOCK = Topic("/clock", "rosgraph_msgs/msg/Clock")
RIG_DESCRIPTION = Topic("rig_description", "std_msgs/msg/String")

# Nothing may be lost: a lost sample is a lost step in lockstep, a gap in a log.
DEPTH = 1000
RELIABLE = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


def flush(node: Node, timeout: float = 2.0) -> None:
    """Wait, `timeout` s at most, until every subscriber has what the node sent: its end takes the rest away."""
    deadline = time.monotonic() + timeout
    for one in node.publishers:
        one.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))


def message_class(kind: str) -> Any:
    """The class of `package/msg/Name`. Raises ImportError where the package is not installed."""
    package, _, name = kind.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def publisher(node: Node, topic: Topic, qos: QoSProfile = RELIABLE) -> Publisher:
    """A publisher, to be given the bytes of `slider_drilling.messages.cdr`."""
    return node.create_publisher(message_class(topic.type), topic.name, qos)


def subscription(
    node: Node, topic: Topic, receive: Callable[[bytes], None], qos: QoSProfile = RELIABLE
) -> Subscription:
    """A subscription whose callback takes bytes as they came."""
    return node.create_subscription(message_class(topic.type), topic.name, receive, qos, raw=True)
