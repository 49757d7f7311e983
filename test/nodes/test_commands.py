"""Commands and joints in the ways in which other programs send them, and what the simulator says about them."""

from collections.abc import Callable

import pytest
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from turning import turn

from slider_drilling.messages import cdr
from slider_drilling.messages.health import Level
from slider_drilling.messages.topics import DRIVES_COMMAND, JOINT_STATE, TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.rocking_controller import RockingController


def run_lockstep(make: Callable[..., Node], **parameters: object) -> tuple[float, ...]:
    """Where the rig is after three seconds in lockstep."""
    simulator = make(FrictionSimulator, elements=20, duration=3.0)
    controller = make(RockingController, use_sim_time=True, **parameters)
    turn([simulator, controller], lambda: simulator.shutdown_request.requested)
    measured = simulator._virtual.measurements
    return measured.time, measured.top_drive_angle, measured.block_position, measured.surface_torque


NAMES = {"top_drive_joint": "quill", "block_joint": "travelling_block", "pump_joint": "pump_1"}


@pytest.mark.parametrize("atomic", [True, False])
def test_nodes_of_a_rig_share_its_joint_names(atomic, make):
    simulator = make(FrictionSimulator, elements=20, duration=1.0, **NAMES)
    heard: dict[str, set[str]] = {}
    for topic in ("top_drive/command" if not atomic else "drives/command", "draw_works/joint_states"):
        raw_topics.subscription(
            simulator,
            Topic(topic, JOINT_STATE),
            lambda data, topic=topic: heard.setdefault(topic, set()).update(deserialize_message(data, JointState).name),
        )
    controller = make(RockingController, use_sim_time=True, atomic_command=atomic, **NAMES)
    turn([simulator, controller], lambda: simulator.shutdown_request.requested)
    assert heard["draw_works/joint_states"] == {"travelling_block"}
    assert heard.get("drives/command", heard.get("top_drive/command")) == (set(NAMES.values()) if atomic else {"quill"})


def test_other_drives_joint_is_refused(make):
    simulator = make(FrictionSimulator, elements=20, speed=5.0, **NAMES)
    sender = raw_topics.publisher(simulator, TOPICS["top_drive_command"])
    sender.publish(cdr.encode_joint_state(0, "block", 1.0, 0.0))
    turn([simulator], lambda: bool(simulator._commands._refusals))
    assert "joint block, not quill" in simulator._commands.status().message


def test_dashboard_reads_the_named_joints(make):
    pytest.importorskip("nicegui", reason="no NiceGUI: pip install '.[live]'")
    from slider_drilling.nodes.dashboard import Dashboard

    dashboard = make(Dashboard, port=0, **NAMES)
    sender = raw_topics.publisher(dashboard, TOPICS["top_drive"])
    sender.publish(cdr.encode_joint_states(10**9, ("other", "quill"), (9.0, 1.5), (9.0, 0.5)))
    turn([dashboard], lambda: dashboard.state._samples)
    assert dashboard.state._samples[-1].top_drive_angle == 1.5


def test_atomic_command_drives_the_same_run(make):
    assert run_lockstep(make, atomic_command=True) == run_lockstep(make)


def test_command_without_all_drives_is_refused_with_a_status(make):
    simulator = make(FrictionSimulator, elements=20, speed=5.0)
    sender = raw_topics.publisher(simulator, DRIVES_COMMAND)
    sender.publish(cdr.encode_joint_states(0, ("top_drive", "block"), (1.0, 0.0), (0.0, 0.0)))
    turn([simulator], lambda: bool(simulator._commands._refusals))
    status = simulator._commands.status()
    assert status.level is Level.ERROR and "drives/command: refused: " in status.message
    assert "a command holds top_drive, block, mud_pump" in status.message


def test_fast_block_is_refused_with_a_status(make):
    simulator = make(FrictionSimulator, elements=20, speed=5.0)
    sender = raw_topics.publisher(simulator, TOPICS["draw_works_command"])
    sender.publish(cdr.encode_joint_state(0, "block", None, 50.0))
    turn([simulator], lambda: bool(simulator._commands._refusals))
    assert "50 m/s is beyond 2 m/s" in simulator._commands.status().message
    assert simulator._virtual.measurements.block_speed == 0.0


def test_refused_nan_is_in_the_status(make):
    simulator = make(FrictionSimulator, elements=20, speed=5.0)
    sender = raw_topics.publisher(simulator, raw_topics.PUMP_COMMAND)
    sender.publish(cdr.encode_joint_state(0, "mud_pump", None, float("nan")))
    turn([simulator], lambda: bool(simulator._commands._refusals))
    status = simulator._commands.status()
    assert status.level is not Level.OK
    assert "mud_pump/command: refused: " in status.message and "not finite" in status.message


@pytest.mark.parametrize(
    ("speed", "says"), [(12.6, "the top drive brakes, at 12.6 rad/s"), (0.0, "the top drive stands")]
)
def test_top_drive_stands_only_when_it_does(speed, says, make):
    simulator = make(FrictionSimulator, elements=20, speed=5.0, autostart=True)
    commands = simulator._commands
    commands._top_drive_speed = lambda: speed
    assert says in commands._timeout_message(["top_drive/command"])
    assert "top drive" not in commands._timeout_message(["draw_works/command"]).replace("top_drive", "")


def test_all_joints_may_come_in_one_message(make):
    controller = make(
        RockingController,
        use_sim_time=False,
        joint_states="joint_states",
        top_drive_joint="quill",
        block_joint="travelling_block",
        pump_joint="pump_1",
        controller="slider_drilling.control:FixedRocking",
    )
    seen = []
    step = controller._controller.step
    controller._controller.step = lambda measurements: (seen.append(measurements), step(measurements))[1]
    joints = raw_topics.publisher(controller, Topic("joint_states", JOINT_STATE))
    pressure = raw_topics.publisher(controller, TOPICS["standpipe_pressure"])
    mwd = raw_topics.publisher(controller, TOPICS["mwd_tool_face"])
    turn([controller], lambda: controller._commands.are_made)
    pressure.publish(cdr.encode_fluid_pressure(0, 1.8e7, 0.0))
    names = ("pump_1", "quill", "other", "travelling_block")
    joints.publish(cdr.encode_joint_states(0, names, (0.0, 1.5, 9.0, 2.5), (12.0, 0.5, 9.0, 0.01)))
    turn([controller], lambda: len(seen) > 0)
    assert (seen[0].top_drive_angle, seen[0].top_drive_speed) == (1.5, 0.5)
    assert (seen[0].block_position, seen[0].block_speed, seen[0].pump_speed) == (2.5, 0.01, 12.0)
    assert mwd.get_subscription_count() == 1
