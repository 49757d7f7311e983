"""A test's own node: receives what programs publish, publishes to them, calls their services."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from node_process import NodeProcess
from rcl_interfaces.srv import GetParameterTypes, SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS, Topic
from slider_drilling.nodes import raw_topics

DEADLINE = 120.0  # s, for anything that has to happen
ANSWER_LOST = 1.0  # s, after which a service that has not answered is asked again
MAX_STATUSES = 100_000  # queued ones: in lockstep a rig sends hundreds a second
KEPT = ("top_drive", "draw_works", "mud_pump", "top_drive_command", "tool_face_target")


class Listener:
    """Keeps a rig's joint states as (stamp s, position, velocity, effort), and the latest statuses.

    programs: their output is printed if `until` times out.
    """

    def __init__(self, namespace: str, programs: Sequence[NodeProcess] = ()) -> None:
        self._programs = programs
        self._context = Context()
        rclpy.init(args=[], context=self._context)
        self.node = Node("listener", namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.heard: dict[str, list[tuple[float, ...]]] = {name: [] for name in KEPT}
        self.statuses: dict[str, DiagnosticStatus] = {}
        self._clients: dict[str, Any] = {}
        for name in KEPT:
            raw_topics.subscription(self.node, TOPICS[name], self._keeper(name))
        self.node.create_subscription(DiagnosticArray, "diagnostics", self._on_diagnostics, MAX_STATUSES)

    def _keeper(self, name: str) -> Callable[[bytes], None]:
        def keep(data: bytes) -> None:
            stamp_ns, *values = cdr.decode_joint_state(data, TOPICS[name].joint)
            self.heard[name].append((stamp_ns / 1e9, *values))

        return keep

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.statuses[status.name.rpartition("/")[2]] = status

    def until(self, has_happened: Callable[[], bool], why: str = "") -> None:
        """Spin until something has happened."""
        end = time.monotonic() + DEADLINE
        while not has_happened():
            if time.monotonic() > end:
                last = [
                    *((name, found[-1:]) for name, found in self.heard.items()),
                    *((name, one.message) for name, one in self.statuses.items()),
                    *(one.last_output() for one in self._programs),
                ]
                raise AssertionError("\n".join([f"waited {DEADLINE:g} s: {why}", *map(str, last)]))
            self._executor.spin_once(timeout_sec=0.02)

    def until_status(self, name: str, level: int, text: str) -> None:
        """Spin until a status of this name ("node: subject") has this level and text."""
        self.until(
            lambda: (
                name in self.statuses
                and self.statuses[name].level == bytes([level])
                and text in self.statuses[name].message
            ),
            f"{name}: {text}",
        )

    def latest(self, name: str) -> tuple[float, ...]:
        """The last sample of a topic; waits for the first, since each topic is discovered by itself."""
        self.until(lambda: bool(self.heard[name]), f"a sample of {name}")
        return self.heard[name][-1]

    def until_time(self, seconds: float) -> None:
        """Spin until the rig's samples have reached a time, s."""
        self.until(lambda: self.time >= seconds, f"samples of {seconds:g} s")

    def listen(self, seconds: float) -> None:
        """Spin for a time, s."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.02)

    @property
    def time(self) -> float:
        """The stamp of the last sample, s."""
        return self.latest("top_drive")[0]

    def publisher(self, topic: Topic, qos: Any = raw_topics.RELIABLE) -> Any:
        """A publisher with a subscriber other than this node."""
        publisher = raw_topics.publisher(self.node, topic, qos)
        own = sum(one.topic_name == publisher.topic_name for one in self.node.subscriptions)
        self.until(lambda: publisher.get_subscription_count() > own, f"a listener to {topic.name}")
        return publisher

    def call(self, kind: Any, name: str, **request: Any) -> Any:
        """The answer of a service."""
        if name not in self._clients:
            self._clients[name] = self._connected_client(kind, name)
        client = self._clients[name]
        self.until(client.service_is_ready, name)
        future = client.call_async(kind.Request(**request))
        self.until(future.done, name)
        return future.result()

    def _connected_client(self, kind: Any, name: str) -> Any:
        """A client that the service's node knows.

        A server may be found before it has found the client's reader, and its answer is lost then. A node learns of
        another's readers in the order in which they were made: once it answers a client made later, it knows this one.
        That client's request changes nothing, and can be repeated.
        """
        client = self.node.create_client(kind, name)
        later = self.node.create_client(GetParameterTypes, f"{name.rpartition('/')[0]}/get_parameter_types")
        self.until(lambda: client.service_is_ready() and later.service_is_ready(), name)
        futures: list[Any] = []

        def answered() -> bool:
            if time.monotonic() > asked + ANSWER_LOST * len(futures):
                futures.append(later.call_async(GetParameterTypes.Request()))
            return any(future.done() for future in futures)

        asked = time.monotonic()
        self.until(answered, f"{name}: its node answers")
        self.node.destroy_client(later)
        return client

    def lower_at(self, speed: float) -> None:
        """Let a rig in lockstep go on until its block is lowered, and then at `speed` times real time."""
        self.until(lambda: any(block[2] > 0.001 for block in self.heard["draw_works"]), "lowered")
        wanted = [Parameter("speed", value=speed).to_parameter_msg()]
        (result,) = self.call(SetParameters, "friction_simulator/set_parameters", parameters=wanted).results
        assert result.successful, result.reason

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)
