"""Managed nodes (https://design.ros2.org/articles/node_lifecycle.html) that start themselves unless told not to."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

from slider_drilling.errors import InputError
from slider_drilling.nodes.parameters import NodeParameter

AUTOSTART = NodeParameter("autostart", True, "configure and activate at once; false: a lifecycle manager does it")


class Transitions:
    """Runs what a node does in a transition, and keeps what went wrong: rclpy would swallow it."""

    def __init__(self, node: LifecycleNode) -> None:
        self._node = node
        self._error: Exception | None = None
        self._starts_itself = False

    def run(self, *work: Callable[[], None]) -> TransitionCallbackReturn:
        """Do the work of a transition; it fails, leaving the state as it was, where that raises."""
        try:
            for one in work:
                one()
        except Exception as error:
            self._error = error
            if not self._starts_itself:
                kind = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
                self._node.get_logger().error(f"{kind}{error}")
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def start(self) -> None:
        """Configure and activate. Raises what a transition raised, InputError for what a user can mend."""
        self._starts_itself = True
        for trigger in (self._node.trigger_configure, self._node.trigger_activate):
            trigger()
            if self._error is not None:
                raise self._error
        self._starts_itself = False
