"""What a node publishes in `diagnostics`."""

from __future__ import annotations

from collections.abc import Iterable

from rclpy.node import Node

from slider_drilling.control.protocol import Level, Status
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import DIAGNOSTICS
from slider_drilling.nodes import link

PERIOD_NS = 1_000_000_000


class Health:
    """Publishes a node's statuses, every one under the node's name, at most once a second of the rig's clock."""

    def __init__(self, node: Node) -> None:
        self._publisher = link.publisher(node, DIAGNOSTICS)
        self._name = node.get_name()
        self._next_ns = 0

    def is_due(self, stamp_ns: int) -> bool:
        """Whether a second has passed since the last ones, or the clock was set back."""
        return stamp_ns >= self._next_ns or stamp_ns < self._next_ns - PERIOD_NS

    def publish(self, stamp_ns: int, statuses: Iterable[Status]) -> None:
        """stamp_ns: ns of the rig's clock."""
        self._next_ns = stamp_ns - stamp_ns % PERIOD_NS + PERIOD_NS
        rows = [(int(one.level), f"{self._name}: {one.name}", one.message, "", one.values) for one in statuses]
        self._publisher.publish(cdr.diagnostic_array(stamp_ns, rows))


__all__ = ["PERIOD_NS", "Health", "Level", "Status"]
