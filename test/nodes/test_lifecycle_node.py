"""The base of the lifecycle nodes: construction, executors, transitions."""

import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from slider_drilling.errors import InputError
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.log_player import LogPlayer
from slider_drilling.nodes.raw_topics import entities
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.spin import make_executor, steady_timer


def overrides(**values: object) -> list[Parameter]:
    return [Parameter(name, value=value) for name, value in values.items()]


@pytest.fixture(autouse=True)
def ros(alone: None) -> Iterator[None]:
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    yield
    rclpy.try_shutdown()


@pytest.mark.parametrize("kind", [SingleThreadedExecutor, MultiThreadedExecutor])
def test_nodes_run_in_any_executor(kind: type) -> None:
    simulator = FrictionSimulator(parameter_overrides=overrides(elements=20, duration=5.0))
    controller = RockingController(parameter_overrides=overrides(use_sim_time=True))
    executor = kind()
    for node in (simulator, controller):
        executor.add_node(node)
    end = time.monotonic() + 60.0
    while not simulator.shutdown_request.requested:
        assert time.monotonic() < end
        executor.spin_once(timeout_sec=0.05)
    assert simulator.simulated == pytest.approx(5.0)
    executor.shutdown()
    for node in (simulator, controller):
        node.destroy_node()


def test_cleanup_destroys_only_own_entities() -> None:
    simulator = FrictionSimulator(parameter_overrides=overrides(elements=20, autostart=False))
    before = entities(simulator)
    simulator.trigger_configure()
    assert simulator.is_configured and len(entities(simulator)) > len(before)
    foreign = steady_timer(simulator, 1.0, lambda: None)
    simulator.trigger_activate()
    assert simulator.is_active
    simulator.trigger_deactivate()
    simulator.trigger_cleanup()
    assert not simulator.is_active and not simulator.is_configured
    assert entities(simulator) == before | {foreign}
    simulator.destroy_node()


def test_failed_configuration_leaves_no_entities() -> None:
    player = LogPlayer(parameter_overrides=overrides(log="missing.mcap", autostart=False))
    before = entities(player)
    player.trigger_configure()
    assert not player.is_configured and entities(player) == before
    player.destroy_node()
    with pytest.raises(InputError, match=r"missing\.mcap"):
        LogPlayer(parameter_overrides=overrides(log="missing.mcap"))


def test_refused_change_keeps_the_values() -> None:
    controller = RockingController(parameter_overrides=overrides(controller="slider_drilling.control:FixedRocking"))
    (result,) = controller.set_parameters(overrides(stale_after=1000.0))
    assert not result.successful and controller.values["stale_after"] == 1.0
    (result,) = controller.set_parameters(overrides(stale_after=2.0))
    assert result.successful and controller.values["stale_after"] == 2.0
    controller.destroy_node()


@pytest.mark.parametrize("kind", [SingleThreadedExecutor, make_executor])
def test_invalid_transition_is_refused(kind: Callable[[], Executor]) -> None:
    controller = RockingController()
    client = controller.create_client(ChangeState, f"{controller.get_name()}/change_state")
    executor = kind()
    executor.add_node(controller)
    # Active already; an id and a label that no transition has; one that another state has.
    for wanted in (Transition(id=Transition.TRANSITION_ACTIVATE), Transition(id=250), Transition(label="explode"),
                   Transition(label="configure"), Transition(id=Transition.TRANSITION_CONFIGURE)):  # fmt: skip
        future = client.call_async(ChangeState.Request(transition=wanted))
        executor.spin_until_future_complete(future, timeout_sec=30.0)
        assert future.result().success is False
    future = client.call_async(ChangeState.Request(transition=Transition(id=Transition.TRANSITION_DEACTIVATE)))
    executor.spin_until_future_complete(future, timeout_sec=30.0)
    assert future.result().success is True and not controller.is_active
    executor.shutdown()
    controller.destroy_node()
