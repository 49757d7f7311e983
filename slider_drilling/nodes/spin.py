"""Runs nodes until they are done: the executor, timers on wall time and the loop that checks for signals."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from rclpy.timer import Timer

from slider_drilling.nodes.shutdown import ShutdownRequest

IDLE = 0.1  # s after which a loop without messages checks for signals
MAX_DRAIN = 2.0  # s to receive what is still in flight when a program ends


def make_executor(supported: bool = False) -> Executor:
    """The events executor if this rclpy has it: it delivers a message in 15 us, the other one in 160 us.

    Args:
        supported: Take the other one: the events executor is experimental.
    """
    if supported:
        return SingleThreadedExecutor()
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()


def node_maker(shutdown_request: ShutdownRequest, ending: ExitStack) -> Callable[..., Any]:
    """Makes nodes of one process: called with a class and its parameters, of which None are left at their defaults.

    Args:
        shutdown_request: Given to each node.
        ending: Destroys each node when it is closed.
    """

    def make(kind: Callable[..., Any], **parameters: Any) -> Any:
        overrides = [Parameter(name, value=value) for name, value in parameters.items() if value is not None]
        node = kind(shutdown_request, parameter_overrides=overrides)
        ending.callback(node.destroy_node)
        return node

    return make


def steady_timer(node: Node, period: float, callback: Callable[[], None]) -> Timer:
    """A timer on wall time that clock changes do not affect; period: s."""
    return node.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def spin(
    nodes: Sequence[Node], shutdown_request: ShutdownRequest, meanwhile: Callable[[], None] = lambda: None,
    supported: bool = False,
) -> Executor:  # fmt: skip
    """Spin the nodes until shutdown is requested.

    Args:
        nodes: At least one; they join the executor.
        shutdown_request: Ends the loop.
        meanwhile: Called about ten times a second.
        supported: As of `make_executor`.

    Returns:
        The executor, not shut down, for `drain`.
    """
    executor = make_executor(supported)
    # A busy events executor does not return at its timeout, but it does serve timers.
    timer = steady_timer(nodes[0], IDLE, meanwhile)
    for node in nodes:
        executor.add_node(node)
    ended = Future()
    shutdown_request.on_stop = lambda: ended.set_result(None)
    while not shutdown_request.requested:
        executor.spin_until_future_complete(ended, timeout_sec=IDLE)
    nodes[0].destroy_timer(timer)
    return executor


def drain(executor: Executor, received: Callable[[], int]) -> None:
    """Receive what is in flight, until nothing has come for IDLE s; MAX_DRAIN s at most. received: message count."""
    deadline = time.monotonic() + MAX_DRAIN
    quiet_since, before = time.monotonic(), received()
    while time.monotonic() < min(deadline, quiet_since + IDLE):
        executor.spin_once(timeout_sec=IDLE / 5.0)
        if received() != before:
            quiet_since, before = time.monotonic(), received()
