"""Publishes a node's health on `diagnostics`."""

from __future__ import annotations

from collections.abc import Iterable

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level, Status
from slider_drilling.messages.topics import DIAGNOSTICS, Topic
from slider_drilling.nodes import raw_topics

PERIOD_NS = 1_000_000_000
AGGREGATED = Topic("/diagnostics", DIAGNOSTICS.type)  # where diagnostic_aggregator and rqt look


def read_statuses(message: DiagnosticArray) -> list[Status]:
    """The statuses of a message; one that is stale counts as an error."""
    statuses = []
    for status in message.status:
        level = int.from_bytes(status.level, "little") if isinstance(status.level, bytes) else int(status.level)
        values = tuple((pair.key, pair.value) for pair in status.values)
        statuses.append(Status(Level(min(level, Level.ERROR)), status.name, status.message, values))
    return statuses


class DiagnosticsPublisher:
    """Publishes a node's statuses at most once a second of the rig's clock, each under the node's name.

    They go to the rig's own topic `diagnostics`, and to /diagnostics if that is another one.

    Args:
        node: Whose statuses they are.
        rig: Name of the rig file; with the namespace it is the hardware_id.
    """

    def __init__(self, node: Node, rig: str = "") -> None:
        namespace = node.get_namespace().strip("/")
        topics = [DIAGNOSTICS, AGGREGATED] if namespace else [DIAGNOSTICS]
        self._publishers = [raw_topics.publisher(node, topic) for topic in topics]
        self._name = f"{namespace}/{node.get_name()}" if namespace else node.get_name()
        self._hardware_id = " ".join(filter(None, [namespace, rig])) or "slider_drilling"
        self._next_ns = 0

    def is_due(self, stamp_ns: int) -> bool:
        """Whether a second has passed since the last statuses, or the clock was set back."""
        return stamp_ns >= self._next_ns or stamp_ns < self._next_ns - PERIOD_NS

    def publish(self, stamp_ns: int, statuses: Iterable[Status]) -> None:
        """Publish statuses; stamp_ns: ns of the rig's clock."""
        self._next_ns = stamp_ns - stamp_ns % PERIOD_NS + PERIOD_NS
        rows = [
            (int(status.level), f"{self._name}: {status.name}", status.message, self._hardware_id, status.values)
            for status in statuses
        ]
        data = cdr.encode_diagnostic_array(stamp_ns, rows)
        for publisher in self._publishers:
            publisher.publish(data)

