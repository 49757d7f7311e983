"""Publishes a controller's commands: a topic for each drive, or one for all of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher

from slider_drilling.control.interface import RigCommand
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import DRIVES_COMMAND, TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.joint_names import JOINT_NAMES, named

# The top drive's last: a simulator that waits for it then knows the others.
_TOPICS = (raw_topics.PUMP_COMMAND, TOPICS["draw_works_command"], TOPICS["top_drive_command"])


class CommandPublishers:
    """The publishers, made on demand: a simulator in lockstep starts when it sees them.

    Args:
        node: Makes them.
        values: Values of the parameters `atomic_command` and of those that name the joints.
    """

    def __init__(self, node: Node, values: Mapping[str, Any]) -> None:
        self._node, self._values = node, values
        self._publishers: list[Publisher] = []

    @property
    def are_made(self) -> bool:
        """Whether the commands are announced."""
        return bool(self._publishers)

    def make(self) -> None:
        """Announce the commands."""
        if not self._publishers:
            topics = (DRIVES_COMMAND,) if self._values["atomic_command"] else _TOPICS
            self._publishers = [raw_topics.publisher(self._node, topic) for topic in topics]

    def publish(self, stamp_ns: int, command: RigCommand) -> None:
        """Publish a command that answers the sample of this stamp, ns."""
        self.make()
        angle = float(command.top_drive_angle)
        if self._values["atomic_command"]:
            positions = (angle, math.nan, math.nan)
            speeds = (float(command.top_drive_speed), float(command.block_speed), float(command.pump_speed))
            names = tuple(self._values[parameter.name] for parameter in JOINT_NAMES)
            self._publishers[0].publish(cdr.encode_joint_states(stamp_ns, names, positions, speeds))
            return
        numbers = ((None, command.pump_speed), (None, command.block_speed), (angle, command.top_drive_speed))
        for topic, publisher, (position, velocity) in zip(_TOPICS, self._publishers, numbers, strict=True):
            joint = named(topic, self._values).joint
            publisher.publish(cdr.encode_joint_state(stamp_ns, joint, position, float(velocity)))
