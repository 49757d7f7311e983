"""Callbacks that raise must not end the executor or the other nodes in it."""

import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from node_process import DEADLINE
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String
from std_srvs.srv import Trigger

from slider_drilling.nodes.guarded import GuardedNode
from slider_drilling.nodes.lifecycle_node import ManagedNode
from slider_drilling.nodes.run_node import NODES
from slider_drilling.nodes.spin import make_executor, steady_timer


@pytest.fixture(autouse=True)
def ros(alone: None) -> Iterator[None]:
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    yield
    rclpy.try_shutdown()


def turn(executor: Executor, done: Callable[[], object]) -> None:
    end = time.monotonic() + DEADLINE
    while not done():
        assert time.monotonic() < end, "did not come"
        executor.spin_once(timeout_sec=0.02)


@pytest.mark.parametrize("kind", [SingleThreadedExecutor, make_executor])
def test_callback_that_raises_ends_nothing(kind: type) -> None:
    node = GuardedNode("faulty")
    calls: list[str] = []

    def fail(what: str, *arguments: object) -> None:
        calls.append(what)
        raise ValueError(what)

    node.create_subscription(String, "text", lambda message: fail("message"), QoSProfile(depth=5))
    node.create_service(Trigger, "act", lambda request, response: fail("service"))
    steady_timer(node, 0.01, lambda: fail("timer"))
    publisher, client = node.create_publisher(String, "text", 5), node.create_client(Trigger, "act")
    executor = kind()
    executor.add_node(node)
    turn(executor, client.service_is_ready)
    publisher.publish(String(data="x"))
    answer = client.call_async(Trigger.Request())
    turn(executor, lambda: answer.done() and {"message", "service", "timer"} <= set(calls))
    assert not answer.result().success
    calls.clear()
    turn(executor, lambda: calls.count("timer") > 3)
    executor.shutdown()
    node.destroy_node()


@pytest.mark.parametrize("name", NODES)
def test_every_node_is_guarded(name: str) -> None:
    module, kind = NODES[name]
    assert issubclass(getattr(__import__(module, fromlist=[kind]), kind), GuardedNode)
    assert issubclass(ManagedNode, GuardedNode)
