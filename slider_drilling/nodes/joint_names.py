"""The parameters that name the joints of the three drives, the same in every node."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from slider_drilling.messages.topics import Topic
from slider_drilling.nodes.parameters import NodeParameter
from slider_drilling.plain_names import plain_name

# The joint's name in the registry of topics -> its parameter.
_PARAMETERS = {"top_drive": "top_drive_joint", "block": "block_joint", "mud_pump": "pump_joint"}
JOINT_NAMES = tuple(
    NodeParameter(parameter, joint, f"name of the {plain_name(joint)}'s joint in messages")
    for joint, parameter in _PARAMETERS.items()
)


def named(topic: Topic, values: Mapping[str, Any]) -> Topic:
    """The topic with its drive's joint named as the node's parameters say; another topic as it is."""
    parameter = _PARAMETERS.get(topic.joint)
    return topic if parameter is None else replace(topic, joint=values[parameter])
