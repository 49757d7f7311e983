"""The log player: positions, loops, skipped topics, and driving a simulated rig."""

import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from turning import turn

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, read_log
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import DRIVES_COMMAND, JOINT_STATE, TOPICS, Topic
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.friction_simulator import FrictionSimulator
from slider_drilling.nodes.log_player import LogPlayer
from slider_drilling.nodes.played_log import load
from slider_drilling.nodes.session import SessionOptions, run_session

FIXED = "slider_drilling.control:FixedRocking"


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Two seconds of a top drive and a block, 0.1 s apart, from 100 s on."""
    path = tmp_path / "played.mcap"
    with LogWriter(path) as writer:
        for k in range(21):
            writer.joint_state("top_drive/joint_states", 100.0 + 0.1 * k, "top_drive", float(k), 0.0, 0.0)
            writer.joint_state("draw_works/joint_states", 100.0 + 0.1 * k, "block", float(k), 0.0, 0.0)
    return path


class Heard:
    """What comes on the player's topics: (stamp s, position) of the joints, s of the clock."""

    def __init__(self) -> None:
        self.node = Node("heard")
        self.joints: dict[str, list[tuple[float, float]]] = {"top_drive": [], "draw_works": []}
        self.clock: list[float] = []
        for name, found in self.joints.items():
            raw_topics.subscription(self.node, TOPICS[name], self._keep(TOPICS[name], found))
        raw_topics.subscription(
            self.node, raw_topics.CLOCK, lambda data: self.clock.append(cdr.decode_clock(data) / 1e9)
        )

    def _keep(self, topic: Topic, found: list[tuple[float, float]]) -> Callable[[bytes], None]:
        def keep(data: bytes) -> None:
            stamp, position, _, _ = cdr.decode_joint_state(data, topic.joint)
            found.append((round(stamp / 1e9, 3), position))

        return keep

    @property
    def positions(self) -> list[float]:
        return [position for _, position in self.joints["top_drive"]]


@pytest.fixture
def heard(make: object) -> Iterator[Heard]:
    listener = Heard()
    yield listener
    listener.node.destroy_node()


def play(
    make: Callable[..., Node], heard: Heard, log: Path, *until: Callable[[], bool], **parameters: object
) -> LogPlayer:
    """Play to the end, and turn until things have happened."""
    player: LogPlayer = make(LogPlayer, **{"log": str(log), "rate": 50.0, "delay": 0.3, **parameters})
    turn([player, heard.node], lambda: player.shutdown_request.requested, *until)
    return player


def test_plays_chosen_topics_from_position_without_clock(make, heard, log):
    play(
        make,
        heard,
        log,
        lambda: len(heard.positions) == 6,
        topics=["top_drive/joint_states"],
        position=1.5,
        publish_clock=False,
    )
    assert heard.positions == [15.0, 16.0, 17.0, 18.0, 19.0, 20.0]
    assert heard.joints["draw_works"] == [] and heard.clock == []


def test_paused_player_steps_and_seeks(make, heard, log):
    player = make(LogPlayer, log=str(log), rate=50.0, delay=0.0, paused=True)
    turn([player, heard.node], lambda: player.count_subscribers("top_drive/joint_states") == 1)
    assert player.step() == "at 0.000 s" and player.step() == "at 0.100 s"
    (result,) = player.set_parameters([Parameter("position", value=1.8)])
    assert result.successful
    assert player.step() == "at 1.800 s"
    (refused,) = player.set_parameters([Parameter("position", value=50.0)])
    assert not refused.successful and "the log is 2 s long" in refused.reason
    turn([player, heard.node], lambda: heard.positions == [0.0, 1.0, 18.0])
    assert player.set_paused(False).startswith("playing")
    with pytest.raises(InputError, match="not paused"):
        player.step()
    turn([player, heard.node], lambda: heard.positions == [0.0, 1.0, 18.0, 19.0, 20.0])


def test_looping_player_continues_clock_and_stamps(make, heard, log):
    player = make(LogPlayer, log=str(log), rate=100.0, delay=0.3, loop=True)
    turn(
        [player, heard.node],
        lambda: player.turns >= 2,
        lambda: player.set_parameters([Parameter("loop", value=False)])[0].successful,
        lambda: player.shutdown_request.requested,
        lambda: len(heard.positions) == 21 * (player.turns + 1),
    )
    stamps = [stamp for stamp, _ in heard.joints["top_drive"]]
    assert stamps == pytest.approx([100.0 + 0.1 * k for k in range(len(stamps))])
    assert heard.positions[:21] == heard.positions[21:42]
    assert heard.clock == sorted(heard.clock) and heard.clock[-1] == pytest.approx(stamps[-1])


def test_invalid_topics_and_types_are_skipped_without_import(make, heard, tmp_path, monkeypatch, capfd):
    (tmp_path / "evil").mkdir()
    (tmp_path / "evil" / "__init__.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "odd.mcap"
    from mcap.writer import Writer

    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        for topic, kind in (
            ("/my notes", "std_msgs/msg/String"),
            ("/evil", "evil/msg/Thing"),
            ("/os", "os/msg/path"),
            ("/top_drive/joint_states", "sensor_msgs/msg/JointState"),
        ):
            schema = writer.register_schema(kind, "ros2msg", b"")
            channel = writer.register_channel(topic, "cdr", schema)
            data = cdr.encode_joint_state(5_000_000_000, "top_drive", 7.0)
            writer.add_message(channel, 5_000_000_000, data, 5_000_000_000)
        writer.finish()
    play(make, heard, path, lambda: heard.positions == [7.0])
    said = capfd.readouterr().err
    assert "'my notes': not played: not a valid ROS 2 topic name" in said
    assert "evil is not an installed message package" in said and "os is not an installed message package" in said


def test_missing_topics_are_named(make, log):
    with pytest.raises(InputError, match="has no no/such to play"):
        make(LogPlayer, log=str(log), topics=["no/such"])


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten seconds in lockstep."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
        patch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
        outcome = run_session(
            SessionOptions(duration=10.0, record=tmp_path_factory.mktemp("log"), controller=FIXED, elements=20)
        )
    assert outcome.log is not None
    return outcome.log


def test_logged_commands_reproduce_the_run(make, heard, recording):
    simulator = make(FrictionSimulator, elements=20, rig=str(recording), minimum_subscribers=2)
    beside: list[float] = []
    raw_topics.subscription(
        heard.node,
        Topic("recorded/top_drive/joint_states", TOPICS["top_drive"].type),
        lambda data: beside.append(cdr.decode_joint_state(data, "top_drive")[3]),
    )
    efforts: list[float] = []
    raw_topics.subscription(
        heard.node, TOPICS["top_drive"], lambda data: efforts.append(cdr.decode_joint_state(data, "top_drive")[3])
    )
    player = make(LogPlayer, log=str(recording), commands_only=True, beside="recorded")
    turn([simulator, player, heard.node], lambda: player.shutdown_request.requested, lambda: len(beside) == 101)
    expected = read_log(recording).top_drive.effort.tolist()
    assert efforts[:101] == expected
    assert beside == expected
    with pytest.raises(InputError, match="pause the simulator"):
        player.set_paused(True)


def test_missing_block_and_pump_commands_are_reported(make, tmp_path, capfd):
    path = tmp_path / "top_drive_only.mcap"
    with LogWriter(path) as writer:
        writer.joint_state("top_drive/command", 0.0, "top_drive", 1.0, 0.0)
    player = make(LogPlayer, log=str(path), commands_only=True)
    assert player._status().message == (
        "no mud_pump/command in the log: the pump keeps its initial speed; "
        "no draw_works/command in the log: the block stands still"
    )
    assert "the block stands still" in capfd.readouterr().err


def two_joints(path: Path, topic: str) -> Path:
    from mcap.writer import Writer

    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", b"")
        channel = writer.register_channel(topic, "cdr", schema)
        data = cdr.encode_joint_states(5_000_000_000, ("left", "right"), (1.0, 2.0), (0.0, 0.0))
        writer.add_message(channel, 5_000_000_000, data, 5_000_000_000)
        writer.finish()
    return path


def test_two_joints_in_a_command_are_refused_in_one_line(make, tmp_path):
    path = two_joints(tmp_path / "two.mcap", "/top_drive/command")
    with pytest.raises(InputError, match=r"two\.mcap: top_drive/command: joints left, right, none named top_drive"):
        make(LogPlayer, log=str(path), commands_only=True)


def test_atomic_commands_of_a_log_are_played(make, tmp_path):
    path = tmp_path / "atomic.mcap"
    with LogWriter(path) as writer:
        writer.joint_state("top_drive/joint_states", 0.0, "quill", 0.0, 0.0, 0.0)
        data = cdr.encode_joint_states(0, ("quill", "block", "mud_pump"), (1.5, math.nan, math.nan), (0.5, 0.01, 12.0))
        writer.message(DRIVES_COMMAND.name, JOINT_STATE, data, 0, 0)
    player = make(LogPlayer, log=str(path), commands_only=True, top_drive_joint="quill")
    assert player._commands.topics == ["mud_pump/command", "draw_works/command", "top_drive/command"]
    assert player._commands.at("top_drive/command", 0.5) == (1.75, 0.5)
    assert player._commands.at("draw_works/command", 0.0)[1] == 0.01


def test_two_joints_in_a_sample_are_one_warning(make, recording, capfd):
    player = make(LogPlayer, log=str(recording), commands_only=True)
    sender = raw_topics.publisher(player, TOPICS["top_drive"])
    sender.publish(cdr.encode_joint_states(0, ("left", "right"), (1.0, 2.0), (0.0, 0.0)))
    sender.publish(cdr.encode_joint_state(0, "top_drive", 0.0, 0.0, 0.0))
    turn([player], lambda: player._rig_start_ns is not None)
    said = [line for line in capfd.readouterr().err.splitlines() if "joints left, right" in line]
    assert len(said) == 1 and "top_drive/joint_states: " in said[0]


def test_log_without_commands_is_refused(make, log):
    with pytest.raises(InputError, match="no commands to drive a rig with"):
        make(LogPlayer, log=str(log), commands_only=True)


def test_words_of_a_twin_are_played_or_left_out(tmp_path):
    path = tmp_path / "run.mcap"
    with LogWriter(path) as writer:
        for key in ("top_drive", "expected_top_drive"):
            writer.sample(TOPICS[key], 0.0, [0.0, 0.0, 1.0])
    names = {TOPICS["top_drive"].name, TOPICS["expected_top_drive"].name}
    assert set(load(path, []).types) == names
    assert set(load(path, [], twin_topics=False).types) == {TOPICS["top_drive"].name}
