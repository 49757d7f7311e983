"""Callbacks whose exceptions end in a log line instead of ending the executor.

The events executor of rclpy is experimental: an exception in a callback of a future crashes the process (SIGSEGV).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node


def guarded(
    node: Node, what: str, callback: Callable[..., Any], on_fault: Callable[[], object] = lambda: None
) -> Callable[..., None]:
    """The callback, with its exceptions logged.

    Args:
        node: Logs them, at most once in five seconds from here.
        what: What the callback works on, for the message.
        callback: Its result is dropped.
        on_fault: Called after an exception.
    """

    def call(*arguments: Any) -> None:
        try:
            callback(*arguments)
        except Exception as error:
            node.get_logger().warning(
                f"{what}: cannot be used: {type(error).__name__}: {error}", throttle_duration_sec=5.0
            )
            on_fault()

    return call
