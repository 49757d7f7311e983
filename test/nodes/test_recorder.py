"""The recorder: a rosbag2 bag of any topics, split and paused, with losses counted."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
import yaml
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from mcap.reader import make_reader
from node_process import DEADLINE
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rosbags.highlevel import AnyReader
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.log.info import log_info
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.message_sequence import SequenceCounter
from slider_drilling.nodes.recorder import PAUSES, RECORDED, Recorder
from slider_drilling.nodes.shutdown import ShutdownRequest
from slider_drilling.nodes.spin import drain, make_executor

DRIVE = TOPICS["top_drive"]
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


@pytest.fixture
def bench(alone: None) -> Iterator[Callable[..., Bench]]:
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    yield Bench
    rclpy.try_shutdown()


def test_every_registered_topic_is_recorded():
    assert set(TOPICS.values()) <= set(RECORDED)


def test_folder_is_a_bag(bench, tmp_path):
    one = bench(directory=str(tmp_path))
    drive, clock = raw_topics.publisher(one.node, DRIVE), raw_topics.publisher(one.node, raw_topics.CLOCK)
    rig = one.node.create_publisher(String, "rig_description", LATCHED)
    rig.publish(String(data="schema: µ"))
    one.turn(lambda: one.recorder.publisher_count("/clock") > 0)
    clock.publish(cdr.encode_clock(7 * 10**9))
    one.turn(lambda: one.recorder._has_rig)
    one.send(drive, range(5))
    one.end()
    information = yaml.safe_load((tmp_path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["version"] == 9 and information["storage_identifier"] == "mcap"
    assert information["relative_file_paths"] == [one.recorder.path.name]
    listed = {row["topic_metadata"]["name"]: row for row in information["topics_with_message_count"]}
    assert listed["/top_drive/joint_states"]["message_count"] == 5
    metadata = listed["/top_drive/joint_states"]["topic_metadata"]
    assert metadata["type_description_hash"].startswith("RIHS01_")
    assert metadata["offered_qos_profiles"][0]["reliability"] == "reliable"
    assert listed["/rig_description"]["topic_metadata"]["offered_qos_profiles"][0]["durability"] == "transient_local"
    with AnyReader([tmp_path]) as bag:
        assert bag.message_count == information["message_count"]
        found = [(connection.topic, bag.deserialize(raw, connection.msgtype)) for connection, _, raw in bag.messages()]
    assert [value.position[0] for topic, value in found if topic == "/top_drive/joint_states"] == [0, 1, 2, 3, 4]
    assert [value.clock.sec for topic, value in found if topic == "/clock"] == [7]
    assert [value.data for topic, value in found if topic == "/rig_description"] == ["schema: µ"]
    log = read_log(tmp_path)
    assert log.rig_text == "schema: µ" and len(log.top_drive.time) == 5


def test_type_hashes_match_the_types(bench, tmp_path):
    from rosbags.typesys import Stores, get_typestore

    one = bench(directory=str(tmp_path))
    one.send(raw_topics.publisher(one.node, DRIVE), range(1))
    one.end()
    information = yaml.safe_load((tmp_path / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    (metadata,) = [
        row["topic_metadata"]
        for row in information["topics_with_message_count"]
        if row["topic_metadata"]["name"] == "/top_drive/joint_states"
    ]
    store = get_typestore(Stores.ROS2_JAZZY)
    assert metadata["type_description_hash"] == store.hash_rihs01("sensor_msgs/msg/JointState")


def test_second_recording_keeps_the_first(bench, tmp_path):
    first, second, named = (
        bench(directory=str(tmp_path)),
        bench(directory=str(tmp_path)),
        bench(directory=str(tmp_path), file="named.mcap"),
    )
    drive = raw_topics.publisher(first.node, DRIVE)
    for one in (first, second, named):
        one.turn(lambda one=one: one.recorder.publisher_count("/top_drive/joint_states") > 0)
    drive.publish(cdr.encode_joint_state(0, "top_drive", 1.0, 0.0, 0.0))
    for one in (first, second, named):
        one.turn(lambda one=one: one.recorder.messages > 0)
        one.end()
    assert first.recorder.path.parent == named.recorder.path.parent == tmp_path
    assert second.recorder.path.parent.parent == tmp_path
    for path in (first.recorder.path, second.recorder.path, named.recorder.path):
        assert len(read_log(path).top_drive.time) == 1
    for folder in (tmp_path, second.recorder.path.parent):
        with AnyReader([folder]) as bag:
            assert {connection.topic for connection in bag.connections} >= {"/top_drive/joint_states"}


def test_any_topic_can_be_recorded(bench, tmp_path):
    one = bench(directory=str(tmp_path), topics=["depth"], regex="/gas/.*", exclude=".*/(secret|command)")
    sent = {name: one.node.create_publisher(Float64, name, 10) for name in ("depth", "gas/c1", "gas/secret", "other")}
    command = raw_topics.publisher(one.node, TOPICS["top_drive_command"])
    one.turn(lambda: one.recorder.publisher_count("/gas/c1") > 0)
    one.turn(lambda: one.recorder.publisher_count("/depth") > 0)
    for name, publisher in sent.items():
        publisher.publish(Float64(data=float(len(name))))
    command.publish(cdr.encode_joint_state(0, "top_drive", 0.0, 0.0))
    one.turn(lambda: one.recorder.messages >= 2)
    one.end()
    with AnyReader([tmp_path]) as bag:
        found = {
            connection.topic: bag.deserialize(raw, connection.msgtype).data for connection, _, raw in bag.messages()
        }
    assert found == {"/depth": 5.0, "/gas/c1": 6.0}


def test_all_topics_are_recorded_with_definitions(bench, tmp_path):
    from mcap_ros2.reader import read_ros2_messages
    from nav_msgs.msg import Odometry

    one = bench(directory=str(tmp_path), all=True)
    publisher = one.node.create_publisher(Odometry, "sled", BEST_EFFORT)
    one.turn(lambda: one.recorder.publisher_count("/sled") > 0)
    message = Odometry(child_frame_id="sled")
    message.pose.covariance[35] = 4.5
    publisher.publish(message)
    one.turn(lambda: one.recorder.received("/sled") > 0)  # /rosout is recorded, too
    one.end()
    (found,) = [each.ros_msg for each in read_ros2_messages(one.recorder.path) if each.channel.topic == "/sled"]
    assert found.child_frame_id == "sled" and found.pose.covariance[35] == 4.5


def test_best_effort_publisher_is_recorded(bench, tmp_path):
    one = bench(directory=str(tmp_path))
    publisher = raw_topics.publisher(one.node, DRIVE, BEST_EFFORT)
    one.send(publisher, range(10))
    one.end()
    assert len(read_log(tmp_path).top_drive.time) == 10


def test_log_splits_by_size_time_and_service(bench, tmp_path):
    one = bench(directory=str(tmp_path / "size"), file="run.mcap", split_size=20_000)
    one.send(raw_topics.publisher(one.node, DRIVE), range(900))
    one.end()
    names = sorted(path.name for path in (tmp_path / "size").glob("*.mcap"))
    assert len(names) > 3 and names[:2] == ["run.mcap", "run_1.mcap"]
    assert all(path.stat().st_size < 30_000 for path in (tmp_path / "size").glob("*.mcap"))
    two = bench(directory=str(tmp_path / "hand"), file="run.mcap", rig="")
    drive = raw_topics.publisher(two.node, DRIVE)
    two.send(drive, range(3))
    answer = two.call("split")
    assert answer.success and answer.message.endswith("run_1.mcap")
    two.send(drive, range(3, 5))
    two.end()
    for name, count in (("size", 900), ("hand", 5)):
        assert len(read_log(tmp_path / name).top_drive.time) == count
        with AnyReader([tmp_path / name]) as bag:
            topics = [connection.topic for connection, _, _ in bag.messages()]
        assert topics.count("/top_drive/joint_states") == count
    three = bench(directory=str(tmp_path / "time"), file="run.mcap", split_duration=0.2, use_sim_time=True)
    drive, clock = raw_topics.publisher(three.node, DRIVE), raw_topics.publisher(three.node, raw_topics.CLOCK)
    three.turn(lambda: three.recorder.publisher_count("/clock") > 0)
    for seconds, values in ((1.0, range(2)), (1.15, range(2, 4)), (1.25, range(4, 6))):
        now_ns = round(seconds * 1e9)
        clock.publish(cdr.encode_clock(now_ns))
        three.turn(lambda now_ns=now_ns: three.recorder._simulated_ns == now_ns)
        three.send(drive, values)
    three.end()
    counts = {path.name: len(read_log(path).top_drive.time) for path in (tmp_path / "time").glob("*.mcap")}
    assert counts == {"run.mcap": 4, "run_1.mcap": 2}


def test_recorder_pauses_and_resumes(bench, tmp_path):
    one = bench(directory=str(tmp_path))
    drive = raw_topics.publisher(one.node, DRIVE)
    one.send(drive, range(3))
    assert one.call("pause").success and not one.call("pause").success
    for value in range(3, 6):
        drive.publish(cdr.encode_joint_state(value * 10**8, "top_drive", float(value), 0.0, 0.0))
    assert one.call("resume").success
    one.send(drive, range(6, 8))
    one.end()
    assert read_log(tmp_path).top_drive.position.tolist() == [0, 1, 2, 6, 7]
    assert one.recorder.lost == 0


def test_managed_recorder_records_only_while_active(bench, tmp_path):
    one = bench(directory=str(tmp_path), autostart=False)
    drive = raw_topics.publisher(one.node, DRIVE)
    assert list(tmp_path.iterdir()) == []

    def change(transition: int) -> None:
        assert one.call("change_state", ChangeState, transition=Transition(id=transition)).success

    def pass_by(value: int) -> None:
        """A message that is heard and not recorded."""
        topic = "/top_drive/joint_states"
        wanted = one.recorder.received(topic) + 1
        drive.publish(cdr.encode_joint_state(value * 10**8, "top_drive", float(value), 0.0, 0.0))
        one.turn(lambda: one.recorder.received(topic) >= wanted)

    change(Transition.TRANSITION_CONFIGURE)
    one.turn(lambda: one.recorder.publisher_count("/top_drive/joint_states") > 0)
    pass_by(0)
    change(Transition.TRANSITION_ACTIVATE)
    one.send(drive, range(1, 3))
    change(Transition.TRANSITION_DEACTIVATE)
    assert one.call("pause").success and one.call("resume").message == "records once it is active"
    pass_by(3)
    change(Transition.TRANSITION_ACTIVATE)
    one.send(drive, range(4, 6))
    change(Transition.TRANSITION_DEACTIVATE)
    change(Transition.TRANSITION_CLEANUP)
    first = one.recorder.path
    log = read_log(first)
    assert log.top_drive.position.tolist() == [1, 2, 4, 5]
    with first.open("rb") as stream:
        noted = [record.metadata for record in make_reader(stream).iter_metadata() if record.name == PAUSES]
    assert len(noted) == 1 and int(noted[0]["from_ns"]) < int(noted[0]["to_ns"])
    change(Transition.TRANSITION_CONFIGURE)
    assert one.recorder.path != first
    one.end()
    assert read_log(first).top_drive.position.tolist() == [1, 2, 4, 5]


def test_parameters_can_be_read(bench, tmp_path):
    one = bench(directory=str(tmp_path), notes="a slide")
    assert one.call("get_parameters", GetParameters, names=["notes"]).values[0].string_value == "a slide"
    one.end()


def test_lost_messages_are_counted(bench, tmp_path):
    one = bench(directory=str(tmp_path))
    publisher = raw_topics.publisher(one.node, DRIVE, QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT))
    one.send(publisher, range(1))
    sent = 1
    while one.recorder.lost == 0 and sent < 60_000:
        for value in range(sent, sent + 3000):
            publisher.publish(cdr.encode_joint_state(value * 10**6, "top_drive", float(value), 0.0, 0.0))
        sent += 3000
        drain(one.executor, lambda: one.recorder.messages)
    one.send(publisher, range(sent, sent + 1))
    sent += 1
    one.end()
    position = read_log(tmp_path).top_drive.position
    assert position[-1] == sent - 1
    assert one.recorder.lost == sent - len(position) > 0


def test_clock_topic_is_recorded_under_wall_time(bench, tmp_path):
    one = bench(directory=str(tmp_path))
    clock = raw_topics.publisher(one.node, raw_topics.CLOCK)
    drive = raw_topics.publisher(one.node, DRIVE)
    one.turn(lambda: one.recorder.publisher_count("/clock") > 0)
    for seconds in range(3):
        clock.publish(cdr.encode_clock(seconds * 10**9))
        one.send(drive, range(seconds, seconds + 1))
    one.end()
    info = log_info(tmp_path)
    assert {"/clock": 3, "/top_drive/joint_states": 3}.items() <= {t.topic: t.messages for t in info.topics}.items()
    assert info.seconds < 1000.0 and info.start_ns > 10**18


@pytest.mark.parametrize("begins", [5000, None], ids=["a clock comes", "none does"])
def test_early_messages_get_the_first_time(begins, bench, tmp_path):
    one = bench(directory=str(tmp_path), use_sim_time=True)
    clock = raw_topics.publisher(one.node, raw_topics.CLOCK)
    described = one.node.create_publisher(String, "rig_description", LATCHED)
    described.publish(String(data="schema: x"))
    one.turn(lambda: one.recorder._has_rig and one.recorder.publisher_count("/clock") > 0)
    if begins is not None:
        clock.publish(cdr.encode_clock(begins * 10**9))
        one.turn(lambda: one.recorder._simulated_ns is not None)
    one.end()
    info = log_info(tmp_path)
    assert {t.topic: t.messages for t in info.topics}.get("/rig_description") == 1
    assert (info.start_ns, info.seconds) == ((begins or 0) * 10**9, 0.0)


@pytest.mark.parametrize(
    ("numbers", "publishers", "lost"),
    [
        ([5, 6, 7], 1, 0),
        ([5, 7, 8, 12], 1, 4),
        ([100, 1, 101, 2, 102, 5, 103], 2, 2),
        ([9, 10, 1, 2, 3], 2, 0),
        ([5, 6, 52, 7, 53, 54, 8], 2, 0),
        ([5, 6, 52, 55, 7], 2, 2),
        ([500, 1001, 501, 7, 1002, 8], 3, 0),
        ([3, 4, 10], 0, 5),  # not in the graph any more
    ],
)
def test_sequence_counter_follows_each_publisher(numbers, publishers, lost):
    watch = SequenceCounter(lambda: {bytes([number]) for number in range(publishers)})
    assert sum(watch.count_missing(number) for number in numbers) == watch.lost == lost


@pytest.mark.parametrize("heads", [(46, 121), (121, 46), (300, 301)])
def test_recorder_started_late_counts_no_losses(heads, bench, tmp_path):
    """Several publishers of one topic, each of which has sent before the recorder came."""
    rig = Node("late_rig")
    publishers = [raw_topics.publisher(rig, DRIVE) for _ in heads]
    value = 0
    for publisher, count in zip(publishers, heads, strict=True):
        for _ in range(count):
            publisher.publish(cdr.encode_joint_state(value * 10**8, "top_drive", float(value), 0.0, 0.0))
            value += 1
    one = bench(directory=str(tmp_path))
    one.turn(lambda: one.recorder.publisher_count("/top_drive/joint_states") == len(heads))
    for _ in range(3):
        for publisher in publishers:
            one.send(publisher, range(value, value + 1))
            value += 1
    assert one.recorder.lost == 0
    one.end()
    rig.destroy_node()
    assert len(read_log(tmp_path).top_drive.position) == 3 * len(heads)


@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ({"regex": "("}, r"parameter regex = '\(': not a regular expression"),
        ({"topics": "/a"}, "parameter topics: must be a list of texts"),
        ({"file": "a/b.mcap"}, "must be a name ending in .mcap"),
    ],
)
def test_bad_recorder_parameter_is_refused(bench, tmp_path, parameters, expected):
    with pytest.raises(InputError, match=expected):
        bench(directory=str(tmp_path), **parameters)
    assert list(tmp_path.iterdir()) == []


def test_unknown_parameter_is_reported(bench, tmp_path, capfd):
    one = bench(directory=str(tmp_path), topcis=["/a"])
    one.end()
    assert "parameter topcis is not known and changes nothing; did you mean topics?" in capfd.readouterr().err


def test_full_disk_keeps_recording_and_ends_process(namespace, tmp_path):
    code = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000));"
        "from slider_drilling.nodes.programs import recorder; recorder()"
    )
    process = subprocess.Popen(
        [
            sys.executable,
            "-c",
            code,
            "--ros-args",
            "-r",
            f"__ns:={namespace}",
            "-p",
            f"directory:={tmp_path}",
            "-p",
            "file:=run.mcap",
        ],
        env=os.environ | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])},
        stderr=subprocess.PIPE,
        text=True,
    )
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = Node("rig", namespace=namespace)
        publisher = raw_topics.publisher(node, DRIVE)
        value, end = 0, time.monotonic() + DEADLINE
        while process.poll() is None and time.monotonic() < end:
            if publisher.get_subscription_count():
                publisher.publish(cdr.encode_joint_state(value * 10**8, "top_drive", float(value), float(value), 0.0))
                value += 1
            time.sleep(0.001)
    finally:
        rclpy.try_shutdown()
        process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30.0)
    assert process.returncode == 2, said
    found = re.search(r"run\.mcap: cannot write this log: File too large; (\d+) messages over [\d.]+ s are safe", said)
    assert found and "Traceback" not in said, said
    log = read_log(tmp_path / "run.mcap")
    assert not any("break" in note for note in log.notes)
    assert 300 < len(log.top_drive.time) <= int(found[1])
