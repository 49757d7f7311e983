"""Turns nodes until they are done: the executor and the loop that looks at signals."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from slider_drilling.nodes.shutdown import ShutdownRequest

IDLE = 0.1  # s after which a loop without messages looks at the signals
DRAIN = 2.0  # s at most for what is still on its way when a program ends


def make_executor() -> Executor:
    """The events executor where this rclpy has it: it hands over a message in 15 us, the other one in 160 us."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()


def spin(nodes: Sequence[Node], halt: ShutdownRequest, meanwhile: Callable[[], None] = lambda: None) -> Executor:
    """Turn the nodes until halt is requested, calling `meanwhile` about ten times a second; returns the executor."""
    executor = make_executor()
    # A busy events executor does not come back for its timeout, but it does serve timers.
    timer = nodes[0].create_timer(IDLE, meanwhile, clock=Clock(clock_type=ClockType.STEADY_TIME))
    for node in nodes:
        executor.add_node(node)
    ended = Future()
    halt.on_stop = lambda: ended.set_result(None)
    while not halt.requested:
        executor.spin_until_future_complete(ended, timeout_sec=IDLE)
    nodes[0].destroy_timer(timer)
    return executor


def drain(executor: Executor, received: Callable[[], int]) -> None:
    """Take what has been sent but not handed over yet: until nothing has come for IDLE s, DRAIN s at most."""
    deadline = time.monotonic() + DRAIN
    quiet_since, before = time.monotonic(), received()
    while time.monotonic() < min(deadline, quiet_since + IDLE):
        executor.spin_once(timeout_sec=IDLE / 5.0)
        if received() != before:
            quiet_since, before = time.monotonic(), received()
