"""Callbacks whose exceptions end in a log line instead of ending the executor.

The events executor of rclpy is experimental: an exception in a callback of a future crashes the process (SIGSEGV), and
in any executor an exception of one callback ends all the others.
"""

from __future__ import annotations

import functools
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node

from slider_drilling.nodes import environment

LOG_PERIOD = 5.0  # s between two lines of one callback


def guarded(
    node: Node, what: str, callback: Callable[..., Any], on_fault: Callable[[], object] = lambda: None
) -> Callable[..., Any]:
    """The callback, with its exceptions logged.

    Args:
        node: Logs them, each callback's at most once in five seconds.
        what: What the callback works on, for the message.
        callback: Its signature stays, for rclpy reads from it what to pass.
        on_fault: Called after an exception; its result is the callback's.
    """
    next_line = -LOG_PERIOD

    @functools.wraps(callback)
    def call(*arguments: Any) -> Any:
        nonlocal next_line
        try:
            return callback(*arguments)
        except Exception as error:
            if time.monotonic() >= next_line:
                next_line = time.monotonic() + LOG_PERIOD
                node.get_logger().error(f"{what}: cannot be used: {type(error).__name__}: {error}")
            return on_fault()

    return call


class GuardedNode(Node):
    """A node whose subscriptions, timers and services cannot end the executor that runs them.

    It finds its messages and warns where others can reach it, also in a program that has not prepared the environment.
    """

    def __init__(self, node_name: str, **node_options: Any) -> None:
        """`node_options`: passed to `rclpy.node.Node`."""
        environment.add_share_folders(os.environ, Path(rclpy.__file__))
        super().__init__(node_name, **node_options)
        reason = environment.open_to_others(os.environ)
        if reason:
            self.get_logger().warning(reason)

    def create_subscription(self, msg_type: Any, topic: str, callback: Any, *arguments: Any, **options: Any) -> Any:
        """A subscription; a message whose callback raises is dropped."""
        return super().create_subscription(msg_type, topic, guarded(self, topic, callback), *arguments, **options)

    def create_timer(self, timer_period_sec: float, callback: Any, *arguments: Any, **options: Any) -> Any:
        """A timer that goes on after an exception of its callback."""
        what = f"timer of {timer_period_sec:g} s"
        return super().create_timer(timer_period_sec, guarded(self, what, callback), *arguments, **options)

    def create_service(self, srv_type: Any, srv_name: str, callback: Any, *arguments: Any, **options: Any) -> Any:
        """A service that answers with the empty response where its callback raises."""

        def serve(request: Any, response: Any) -> Any:
            return guarded(self, srv_name, callback, lambda: response)(request, response)

        return super().create_service(srv_type, srv_name, serve, *arguments, **options)
