"""Turns nodes of this process until something has happened."""

import time
from collections.abc import Callable, Sequence

from node_process import DEADLINE
from rclpy.node import Node

from slider_drilling.nodes.spin import make_executor


def turn(nodes: Sequence[Node], *until: Callable[[], object], seconds: float = DEADLINE) -> None:
    """Turn the nodes until things have happened, one after the other."""
    executor = make_executor()
    for node in nodes:
        executor.add_node(node)
    end = time.monotonic() + seconds
    for has_happened in until:
        while not has_happened():
            assert time.monotonic() < end, f"waited {seconds:g} s"
            executor.spin_once(timeout_sec=0.02)
    executor.shutdown()
