"""Node parameters: described, changed while the node runs, refused with a reason."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from rclpy.node import Node
from rclpy.parameter import Parameter
from turning import turn

from slider_drilling.control.settings import limits_of
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter
from slider_drilling.nodes.dashboard import Dashboard
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.log_player import LogPlayer
from slider_drilling.nodes.recorder import Recorder
from slider_drilling.nodes.rocking_controller import RockingController
from slider_drilling.nodes.twin import TwinNode

FIXED = "slider_drilling.control:FixedRocking"
Make = Callable[..., Node]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "played.mcap"
    with LogWriter(path) as writer:
        for k in range(20):
            writer.joint_state("top_drive/joint_states", 0.1 * k, "top_drive", float(k), 0.0, 0.0)
    return path


def given(kind: type, log: Path, tmp_path: Path) -> dict[str, object]:
    """What a node of the kind cannot do without."""
    own: dict[type, dict[str, object]] = {
        FrictionSimulator: {"elements": 20},
        Recorder: {"directory": str(tmp_path)},
        LogPlayer: {"log": str(log)},
        RockingController: {"controller": FIXED},
    }
    return own.get(kind, {})


@pytest.mark.parametrize("kind", [FrictionSimulator, RockingController, Recorder, LogPlayer, TwinNode])
def test_every_parameter_is_described_and_in_example(kind, make, log, tmp_path, repository):
    example = yaml.safe_load((repository / "config" / "nodes.yaml").read_text())
    controller = example["/**/rocking_controller"]["ros__parameters"]["controller"]
    node = make(kind, **given(kind, log, tmp_path) | ({"controller": controller} if kind is RockingController else {}))
    listed = example[f"/**/{node.get_name()}"]["ros__parameters"]
    own = [
        name
        for name in node._parameters
        if name not in ("use_sim_time", "start_type_description_service") and not name.startswith("qos_overrides.")
    ]
    assert sorted(own) == sorted(set(listed) - {"use_sim_time"})
    for name in own:
        described = node.describe_parameter(name)
        assert described.description, name
        value = node.get_parameter(name).value
        assert type(value) is type(listed[name]), name
        if isinstance(value, float):
            (limits,) = described.floating_point_range
            assert limits.from_value <= listed[name] <= limits.to_value, name


@pytest.mark.parametrize("kind", [FrictionSimulator, RockingController, Recorder, LogPlayer, TwinNode, Dashboard])
def test_example_has_every_default(kind, repository):
    example = yaml.safe_load((repository / "config" / "nodes.yaml").read_text())
    listed = example[f"/**/{kind.NAME}"]["ros__parameters"]
    defaults = {parameter.name: parameter.default for parameter in kind.PARAMETERS}
    settings = set(limits_of(SlideSettings())) if kind is RockingController else set()
    assert {name: value for name, value in listed.items() if name not in settings} == defaults


@pytest.mark.parametrize("kind", [FrictionSimulator, RockingController, Recorder, LogPlayer])
def test_misspelt_parameter_is_warned_of_with_nearest_name(kind, make, log, tmp_path, capfd):
    (name, *_) = (parameter.name for parameter in kind.PARAMETERS)
    make(kind, **given(kind, log, tmp_path), **{f"{name}x": 1.0})
    assert f"parameter {name}x is not known and changes nothing; did you mean {name}?" in capfd.readouterr().err


def test_example_has_default_settings_of_controller(make, repository):
    example = yaml.safe_load((repository / "config" / "nodes.yaml").read_text())["/**/rocking_controller"]
    node = make(RockingController)
    listed = example["ros__parameters"]
    assert listed["controller"] == node.get_parameter("controller").value
    assert {name: listed[name] for name in limits_of(node.settings)} == {
        name: getattr(node.settings, name) for name in limits_of(node._controller.settings)
    }


def test_changed_settings_reach_the_controller(make):
    node = make(RockingController, controller=FIXED)
    (result,) = node.set_parameters([Parameter("amplitude", value=12.5)])
    assert result.successful
    assert node.settings.amplitude == 12.5
    (result,) = node.set_parameters([Parameter("tool_face_target", value=0.5)])
    assert result.successful and node._controller.tool_face_target == 0.5


@pytest.mark.parametrize(
    ("kind", "name", "value", "reason"),
    [
        (RockingController, "amplitude", 1e6, "out of range"),
        (RockingController, "amplitude", float("nan"), "out of range"),
        (RockingController, "rounding", 0.06, "the top drive has 20 rad/s2; make rounding at least"),
        (RockingController, "amplitude", "wide", "Wrong parameter type"),
        (RockingController, "controller", "other:One", "read-only"),
        (FrictionSimulator, "speed", -1.0, "out of range"),
        (FrictionSimulator, "seed", 5, "read-only"),
        (LogPlayer, "rate", 0.0, "out of range"),
    ],
)
def test_bad_parameter_value_is_refused_with_reason(kind, name, value, reason, make, log, tmp_path):
    node = make(kind, **given(kind, log, tmp_path))
    before = node.get_parameter(name).value
    (result,) = node.set_parameters([Parameter(name, value=value)])
    assert not result.successful
    assert reason in result.reason
    assert node.get_parameter(name).value == before


def test_speed_changes_between_lockstep_and_real_time(make):
    simulator = make(FrictionSimulator, elements=20, speed=0.0)
    controller = make(RockingController, use_sim_time=True)
    moments = [simulator.simulated]

    def set_speed(speed: float) -> bool:
        (result,) = simulator.set_parameters([Parameter("speed", value=speed)])
        moments.append(simulator.simulated)
        return result.successful and (simulator._pace is None) == (speed == 0.0)

    turn(
        [simulator, controller],
        lambda: simulator.simulated > 1.0,
        lambda: set_speed(20.0),
        lambda: simulator.simulated > moments[-1] + 1.0,
        lambda: set_speed(0.0),
        lambda: simulator.simulated > moments[-1] + 5.0,
    )
    assert len(moments) == 3


def test_two_controllers_in_lockstep_are_refused(make):
    nodes = [make(FrictionSimulator, elements=20, speed=0.0), make(RockingController), make(RockingController)]
    turn(nodes, lambda: nodes[0].shutdown_request.requested)
    with pytest.raises(InputError, match=r"several nodes publish .*top_drive/command.*; stop all but one"):
        nodes[0].shutdown_request.raise_error()


def test_looping_player_starts_again(make, log):
    player = make(LogPlayer, log=str(log), rate=100.0, loop=True, delay=0.0)
    turn([player], lambda: player.turns >= 2)
    assert not player.shutdown_request.requested
    player.set_parameters([Parameter("loop", value=False)])
    turn([player], lambda: player.shutdown_request.requested)


@pytest.mark.parametrize(
    ("sent", "held"), [(0.5, 0.5), (-3.1415928, -math.pi), (math.radians(900.0), None), (math.inf, None)]
)
def test_target_topic_sets_or_refuses_the_target(make, sent, held):
    """A target beyond half a turn is refused, not wrapped."""
    from slider_drilling.messages import cdr
    from slider_drilling.messages.topics import TOPICS
    from slider_drilling.nodes import raw_topics

    controller = make(RockingController)
    warned: list[str] = []
    controller.get_logger().warning = warned.append
    sender = raw_topics.publisher(controller, TOPICS["tool_face_target"])
    sender.publish(cdr.encode_joint_state(7, "tool_face", sent))
    turn([controller], lambda: controller._controller.tool_face_target != 0.0 or warned)
    assert controller.get_parameter("tool_face_target").value == pytest.approx(held or 0.0)
    assert (held is None) == any("tool_face/target: refused" in line for line in warned)


def test_silent_rig_stops_the_block(make):
    from slider_drilling.messages import cdr
    from slider_drilling.messages.topics import TOPICS
    from slider_drilling.nodes import raw_topics

    controller = make(RockingController, stale_after=0.2, controller=FIXED)
    rig = {
        name: raw_topics.publisher(controller, TOPICS[name])
        for name in ("mud_pump", "draw_works", "standpipe_pressure", "top_drive")
    }
    speeds: list[float] = []
    raw_topics.subscription(
        controller, TOPICS["draw_works_command"], lambda data: speeds.append(cdr.decode_joint_state(data, "block")[2])
    )
    rig["mud_pump"].publish(cdr.encode_joint_state(0, "mud_pump", None, 12.0))
    rig["draw_works"].publish(cdr.encode_joint_state(0, "block", 0.0, 0.0, 4e5))
    rig["standpipe_pressure"].publish(cdr.encode_fluid_pressure(0, 1.8e7, 0.0))
    rig["top_drive"].publish(cdr.encode_joint_state(0, "top_drive", 0.0, 0.0, 0.0))
    turn([controller], lambda: len(speeds) >= 3)
    assert speeds[0] == 0.0025 and set(speeds[1:]) == {0.0}
