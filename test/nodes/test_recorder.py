"""The recorder: a rosbag2 bag of any topics, split and paused, with losses counted."""


import pytest
import yaml
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from mcap.reader import make_reader
from rcl_interfaces.srv import GetParameters
from recorder_bench import BEST_EFFORT, LATCHED
from rosbags.highlevel import AnyReader
from std_msgs.msg import Float64, String

from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import TOPICS
from slider_drilling.nodes import raw_topics
from slider_drilling.nodes.recorder import PAUSES, RECORDED

DRIVE = TOPICS["top_drive"]


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
