"""A node of the test's own: hears what programs say on topics, says things to them, calls their services."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from program import Program
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS, Topic
from slider_drilling.nodes import raw_topics

DEADLINE = 120.0  # s, for anything that has to happen
STATUSES = 100_000  # that wait where this process gets no turn: in lockstep a rig sends hundreds a second
KEPT = ("top_drive", "draw_works", "mud_pump", "top_drive_command", "tool_face_target")


class Ear:
    """Keeps the joint states of a rig's topics as (stamp s, position, velocity, effort), and the latest statuses.

    programs: those that it listens to; what they said is told where something never happens.
    """

    def __init__(self, namespace: str, programs: Sequence[Program] = ()) -> None:
        self._programs = programs
        self._context = Context()
        rclpy.init(args=[], context=self._context)
        self.node = Node("ear", namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.heard: dict[str, list[tuple[float, ...]]] = {name: [] for name in KEPT}
        self.statuses: dict[str, DiagnosticStatus] = {}
        for name in KEPT:
            raw_topics.subscription(self.node, TOPICS[name], self._keeper(name))
        self.node.create_subscription(DiagnosticArray, "diagnostics", self._on_diagnostics, STATUSES)

    def _keeper(self, name: str) -> Callable[[bytes], None]:
        def keep(data: bytes) -> None:
            stamp_ns, *values = cdr.decode_joint_state(data, TOPICS[name].joint)
            self.heard[name].append((stamp_ns / 1e9, *values))

        return keep

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.statuses[status.name.rpartition("/")[2]] = status

    def until(self, has_happened: Callable[[], bool], why: str = "") -> None:
        """Turn until it has."""
        end = time.monotonic() + DEADLINE
        while not has_happened():
            if time.monotonic() > end:
                last = [
                    *((name, found[-1:]) for name, found in self.heard.items()),
                    *((name, one.message) for name, one in self.statuses.items()),
                    *(one.last_words() for one in self._programs),
                ]
                raise AssertionError("\n".join([f"waited {DEADLINE:g} s: {why}", *map(str, last)]))
            self._executor.spin_once(timeout_sec=0.02)

    def until_status(self, name: str, level: int, text: str) -> None:
        """Turn until a status of this name ("node: part") has this level and text."""
        self.until(
            lambda: (
                name in self.statuses
                and self.statuses[name].level == bytes([level])
                and text in self.statuses[name].message
            ),
            f"{name}: {text}",
        )

    def until_time(self, seconds: float) -> None:
        """Turn until the rig's samples have come to this time."""
        self.until(lambda: bool(self.heard["top_drive"]) and self.heard["top_drive"][-1][0] >= seconds)

    def listen(self, seconds: float) -> None:
        """Turn for so long, s."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)

    @property
    def time(self) -> float:
        """The stamp of the last sample, s."""
        return self.heard["top_drive"][-1][0]

    def sayer(self, topic: Topic, qos: Any = raw_topics.RELIABLE) -> Any:
        """A publisher that somebody besides this ear listens to."""
        publisher = raw_topics.publisher(self.node, topic, qos)
        own = sum(one.topic_name == publisher.topic_name for one in self.node.subscriptions)
        self.until(lambda: publisher.get_subscription_count() > own, f"a listener to {topic.name}")
        return publisher

    def call(self, kind: Any, name: str, **request: Any) -> Any:
        """The answer of a service."""
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready, name)
        future = client.call_async(kind.Request(**request))
        self.until(future.done, name)
        return future.result()

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)
