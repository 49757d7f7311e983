"""A recorder and a node beside it, turned by hand."""

import time
from collections.abc import Callable
from typing import Any

from node_process import DEADLINE
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from slider_drilling.messages import cdr
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.spin import make_executor

BEST_EFFORT = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Bench:
    """A recorder and a node beside it that publishes, turned by hand."""

    def __init__(self, **parameters: object) -> None:
        self.shutdown_request = ShutdownRequest()
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        self.recorder = Recorder(self.shutdown_request, parameter_overrides=overrides)
        self.node = Node("rig")
        self.executor = make_executor()
        self.executor.add_node(self.recorder)
        self.executor.add_node(self.node)

    def turn(self, until: Callable[[], bool]) -> None:
        end = time.monotonic() + DEADLINE
        while not until():
            assert time.monotonic() < end
            self.executor.spin_once(timeout_sec=0.02)

    def send(self, publisher: object, values: range, topic: str = "/top_drive/joint_states") -> None:
        """Publish a joint state for each value, and wait until all are in the bag."""
        self.turn(lambda: self.recorder.publisher_count(topic) > 0)
        wanted = self.recorder.messages + len(values)
        for value in values:
            publisher.publish(cdr.encode_joint_state(value * 10**8, "top_drive", float(value), 0.0, 0.0))  # type: ignore[attr-defined]
        self.turn(lambda: self.recorder.messages >= wanted)

    def call(self, service: str, kind: type = Trigger, **request: object) -> Any:
        client = self.node.create_client(kind, f"/recorder/{service}")
        assert client.wait_for_service(DEADLINE)
        future = client.call_async(kind.Request(**request))
        self.turn(future.done)
        return future.result()

    def end(self) -> None:
        self.recorder.close()
        self.executor.shutdown()
        self.recorder.destroy_node()
        self.node.destroy_node()
