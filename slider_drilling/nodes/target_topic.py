"""The topic `tool_face/target` of a node that both reports its target there and takes others from it."""

from __future__ import annotations

import math
from collections.abc import Callable

from rclpy.node import Node

from slider_drilling.control.tool_face_target import target_refusal
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.own_echoes import OwnEchoes

TOPIC = TOPICS["tool_face_target"]
_ROUNDING = 1e-6  # rad by which half a turn may be exceeded, as by a message made in single precision


class TargetTopic:
    """Publishes the node's own target and passes on those of others, in rad.

    A target beyond half a turn is refused, not wrapped: 900 degrees are more likely a mistake than a wish for 180.

    Args:
        node: Whose topic it is.
        take: Called with another target.
    """

    def __init__(self, node: Node, take: Callable[[float], object]) -> None:
        self._node, self._take = node, take
        self._own = OwnEchoes()
        self._publisher = raw_topics.publisher(node, TOPIC)
        raw_topics.SensorSubscription(node, TOPIC, self._receive)

    def publish(self, stamp_ns: int, target: float) -> None:
        """Report the target that is held, rad."""
        data = cdr.encode_joint_state(stamp_ns, TOPIC.joint, target)
        self._own.add(data)
        self._publisher.publish(data)

    def _receive(self, data: bytes) -> None:
        if not self._own.is_own(data):
            raw_topics.decoding(self._node, TOPIC, lambda stamp_ns, target, *rest: self._accept(target))(data)

    def _accept(self, target: float) -> None:
        inside = min(max(target, -math.pi), math.pi) if abs(target) < math.pi + _ROUNDING else target
        if refusal := target_refusal(math.degrees(inside)):
            self._node.get_logger().warning(f"{TOPIC.name}: refused: {refusal}")
        else:
            self._take(inside)
