"""Logs as other recorders write them, and the recordings that come with the project."""

import io
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.writer import Writer as Ros2Writer

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, read_log
from slider_drilling.messages import cdr
from slider_drilling.messages.message_types import MESSAGE_TYPES
from slider_drilling.messages.topics import JOINT_STATE, canonical_type, namespace_of


def joint(stamp_s: float, name: str = "top_drive", *values: float) -> dict[str, object]:
    sec, nanosec = divmod(round(stamp_s * 1e9), 10**9)
    position, velocity, effort = [[value] for value in values] or [[1.0], [2.0], [3.0]]
    header = {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": ""}
    return {"header": header, "name": [name], "position": position, "velocity": velocity, "effort": effort}


def write_own(path: Path) -> None:
    """Two seconds of the top drive, as this package writes them."""
    with LogWriter(path) as writer:
        for step in range(20):
            writer.joint_state("top_drive/joint_states", 1000.0 + 0.1 * step, "top_drive", 0.1 * step, 1.0, step)


def test_atomic_command_is_read_as_its_drives(tmp_path: Path) -> None:
    path = tmp_path / "atomic.mcap"
    with LogWriter(path) as writer:
        writer.joint_state("top_drive/joint_states", 0.0, "top_drive", 0.0, 0.0, 0.0)
        names, speeds = ("top_drive", "block", "mud_pump"), (0.5, 0.01, 12.0)
        data = cdr.encode_joint_states(0, names, (1.5, float("nan"), float("nan")), speeds)
        writer.message("drives/command", JOINT_STATE, data, 0, 0)
    log = read_log(path)
    assert (log.top_drive_command.position[0], log.top_drive_command.velocity[0]) == (1.5, 0.5)
    assert log.draw_works_command.velocity[0] == 0.01


class TestOtherMakers:
    """Logs as other recorders write them."""

    def ros2(self, path: Path, rows: list[tuple[str, dict[str, object], int]], kind: str = JOINT_STATE) -> Path:
        with path.open("wb") as file:
            writer = Ros2Writer(file)
            schema = writer.register_msgdef(kind, MESSAGE_TYPES[kind].definition)
            for topic, message, log_time in rows:
                writer.write_message(topic, schema, message, log_time)
            writer.finish()
        return path

    @pytest.mark.parametrize(
        ("encoding", "text", "name"),
        [
            ("ros2idl", b"=====\nIDL: sensor_msgs/msg/JointState\nmodule sensor_msgs {};", JOINT_STATE),
            ("ros2msg", b"", "sensor_msgs/JointState"),
            ("ros2idl", b"", "sensor_msgs::msg::dds_::JointState_"),
        ],
    )
    @pytest.mark.parametrize("compression", list(CompressionType))
    def test_schema_encodings_and_compressions(
        self, tmp_path: Path, encoding: str, text: bytes, name: str, compression: CompressionType
    ) -> None:
        stream = io.BytesIO()
        donor = Ros2Writer(stream)
        schema = donor.register_msgdef(JOINT_STATE, MESSAGE_TYPES[JOINT_STATE].definition)
        donor.write_message("/a", schema, joint(5.0, "top_drive", 1.0, 2.0, 3.0), 5 * 10**9)
        donor.finish()
        ((_, _, message),) = make_reader(io.BytesIO(stream.getvalue())).iter_messages()
        path = tmp_path / "run.mcap"
        with path.open("wb") as file:
            writer = Writer(file, compression=compression)
            writer.start("ros2")
            schema_id = writer.register_schema(name, encoding, text)
            channel = writer.register_channel("/north/rig7/top_drive/joint_states", "cdr", schema_id)
            writer.add_message(channel, message.log_time, message.data, message.publish_time)
            writer.finish()
        log = read_log(path)
        assert log.top_drive is not None
        assert (log.top_drive.position[0], log.top_drive.velocity[0], log.top_drive.effort[0]) == (1.0, 2.0, 3.0)

    def test_no_chunks(self, tmp_path: Path) -> None:
        whole = tmp_path / "run.mcap"
        write_own(whole)
        path = tmp_path / "flat.mcap"
        with path.open("wb") as file, whole.open("rb") as source:
            writer = Writer(file, use_chunking=False)
            writer.start("ros2")
            channels: dict[str, int] = {}
            for schema, channel, message in make_reader(source).iter_messages():
                assert schema is not None
                if channel.topic not in channels:
                    schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.topic] = writer.register_channel(channel.topic, "cdr", schema_id)
                writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
            writer.finish()
        assert (read_log(path).top_drive.effort == read_log(whole).top_drive.effort).all()  # type: ignore[union-attr]

    def test_messages_as_dds_pads_them(self, tmp_path: Path) -> None:
        # Fast DDS aligns before an empty float64[]: four bytes more than other encoders write, and not zero.
        data = bytes.fromhex(
            "0001000000f153650000000001000000000000000100000009000000"
            "6d75645f70756d70000000000000000001000000ab010000d9899dd8899d2840000000005d547d0c"
        )
        path = tmp_path / "run.mcap"
        with path.open("wb") as file:
            writer = Writer(file)
            writer.start("ros2")
            schema_id = writer.register_schema(JOINT_STATE, "ros2msg", MESSAGE_TYPES[JOINT_STATE].definition.encode())
            channel = writer.register_channel("/mud_pump/joint_states", "cdr", schema_id)
            writer.add_message(channel, 0, data, 0)
            writer.finish()
        pump = read_log(path).mud_pump
        assert pump is not None
        assert pump.velocity[0] == pytest.approx(0.032 / 0.0026)
        assert np.isnan(pump.position[0]) and np.isnan(pump.effort[0])

    def test_joint_is_found_by_name(self, tmp_path: Path) -> None:
        message = joint(1.0)
        message |= {"name": ["kelly", "top_drive"], "position": [7.0, 8.0], "velocity": [], "effort": [1.0]}
        topic = "/top_drive/joint_states"
        log = read_log(self.ros2(tmp_path / "run.mcap", [(topic, message, 10**9)]))
        assert log.top_drive is not None
        assert log.top_drive.position[0] == 8.0
        assert np.isnan(log.top_drive.velocity[0]) and np.isnan(log.top_drive.effort[0])

    def test_joint_that_is_not_there_is_said(self, tmp_path: Path) -> None:
        rows = [("/top_drive/joint_states", joint(1.0), 10**9)]
        message = joint(1.0) | {"name": ["a", "b"]}
        path = self.ros2(tmp_path / "run.mcap", [*rows, ("/draw_works/joint_states", message, 10**9)])
        log = read_log(path)
        assert log.draw_works is None
        assert any("none named block" in note for note in log.notes)

    def test_two_rigs_need_a_namespace(self, tmp_path: Path) -> None:
        rows = [
            (f"/{rig}/top_drive/joint_states", joint(1.0, "top_drive", k, 0, 0), 10**9) for k, rig in enumerate("ab")
        ]
        path = self.ros2(tmp_path / "run.mcap", rows)
        with pytest.raises(InputError, match="choose one with --namespace"):
            read_log(path)
        chosen = read_log(path, namespace="b").top_drive
        assert chosen is not None and chosen.position[0] == 1.0
        with pytest.raises(InputError, match="in namespace 'c'"):
            read_log(path, namespace="c")

    def test_type_that_does_not_fit_is_said(self, tmp_path: Path) -> None:
        rows = [("/top_drive/joint_states", joint(1.0), 10**9), ("/standpipe_pressure", joint(1.0), 10**9)]
        log = read_log(self.ros2(tmp_path / "run.mcap", rows))
        assert log.standpipe_pressure is None
        assert any("not sensor_msgs/msg/FluidPressure" in note for note in log.notes)

    def test_order_repeats_and_gaps(self, tmp_path: Path) -> None:
        stamps = [1.0, 1.2, 1.1, 1.2, 9.0]
        rows = [
            ("/top_drive/joint_states", joint(stamp, "top_drive", k, 0, 0), k + 10**9) for k, stamp in enumerate(stamps)
        ]
        log = read_log(self.ros2(tmp_path / "run.mcap", rows))
        assert log.top_drive is not None
        np.testing.assert_allclose(log.top_drive.time, [0.0, 0.1, 0.2, 8.0], atol=1e-9)
        np.testing.assert_array_equal(log.top_drive.position, [0, 2, 3, 4])
        assert any("1 repeated stamps" in note for note in log.notes)

    def test_two_runs_in_one_log_are_refused(self, tmp_path: Path) -> None:
        stamps = [0.1, 0.2, 50.0, 0.1, 0.2]
        rows = [("/top_drive/joint_states", joint(stamp), k + 10**9) for k, stamp in enumerate(stamps)]
        with pytest.raises(InputError, match=r"step back by 49\.9 s after 49\.9 s: two runs in one log"):
            read_log(self.ros2(tmp_path / "run.mcap", rows))

    def test_wall_clock_log_of_a_simulation(self, tmp_path: Path) -> None:
        # Recorded without use_sim_time at twice real time: log times are wall-clock, stamps simulated.
        wall = 1_700_000_000.0
        rows = [("/top_drive/joint_states", joint(k * 0.1), round((wall + k * 0.05) * 1e9)) for k in range(500)]
        rows.append(("/mwd/tool_face", joint(12.0, "tool_face", 0.5, 0, 0), round((wall + 9.0) * 1e9)))
        log = read_log(self.ros2(tmp_path / "run.mcap", rows))
        assert log.mwd_tool_face is not None
        assert log.mwd_tool_face.time[0] == pytest.approx(12.0)
        assert log.mwd_tool_face.arrival[0] == pytest.approx(18.0, abs=1e-3)
        assert any("off the stamps" in note for note in log.notes)

    def test_headers_without_stamps(self, tmp_path: Path) -> None:
        rows = [("/top_drive/joint_states", joint(0.0), 10**9 * k) for k in range(5, 9)]
        log = read_log(self.ros2(tmp_path / "run.mcap", rows))
        assert log.top_drive is not None
        np.testing.assert_allclose(log.top_drive.time, [0.0, 1.0, 2.0, 3.0])
        assert any("no stamps" in note for note in log.notes)

    def test_bag_of_another_library(self, tmp_path: Path) -> None:
        from rosbags.rosbag2 import StoragePlugin
        from rosbags.rosbag2 import Writer as BagWriter
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS2_JAZZY)
        types = store.types
        with BagWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            topic = bag.add_connection("/rig/standpipe_pressure", "sensor_msgs/msg/FluidPressure", typestore=store)
            for k in range(5):
                stamp = types["builtin_interfaces/msg/Time"](sec=k, nanosec=500_000_000)
                header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="standpipe")
                message = types["sensor_msgs/msg/FluidPressure"](header, 1e7 + k, 0.0)
                bag.write(topic, k * 10**9 + 600_000_000, store.serialize_cdr(message, "sensor_msgs/msg/FluidPressure"))
        log = read_log(tmp_path / "bag")
        assert log.standpipe_pressure is not None and log.top_drive is None and log.notes == ()
        assert log.start == 0.5
        np.testing.assert_allclose(log.standpipe_pressure.time, np.arange(5.0))
        np.testing.assert_allclose(log.standpipe_pressure.arrival, np.arange(5.0) + 0.1)
        np.testing.assert_array_equal(log.standpipe_pressure.value, 1e7 + np.arange(5.0))
        assert np.isnan(log.standpipe_pressure.variance).all()

    def test_folder_of_a_bag(self, tmp_path: Path) -> None:
        for k in (0, 1):
            rows = [("/top_drive/joint_states", joint(10.0 * k + s), round((10.0 * k + s) * 1e9)) for s in range(1, 10)]
            self.ros2(tmp_path / f"bag_{k}.mcap", rows)
        log = read_log(tmp_path)
        assert log.top_drive is not None and len(log.top_drive.time) == 18
        write_own(tmp_path / "other_run.mcap")
        write_own(tmp_path / "third_run.mcap")
        with pytest.raises(InputError, match=r"other_run\.mcap and third_run\.mcap overlap in time"):
            read_log(tmp_path)
        (tmp_path / "empty").mkdir()
        with pytest.raises(InputError, match=r"holds no logs"):
            read_log(tmp_path / "empty")


@pytest.mark.parametrize(
    ("topic", "relative", "namespace"),
    [
        ("/top_drive/command", "top_drive/command", ""),
        ("top_drive/command", "top_drive/command", ""),
        ("/a/b/top_drive/command", "top_drive/command", "/a/b"),
        ("/not_top_drive/command", "top_drive/command", None),
        ("/top_drive/command/more", "top_drive/command", None),
    ],
)
def test_namespace(topic: str, relative: str, namespace: str | None) -> None:
    assert namespace_of(topic, relative) == namespace


def test_canonical_type() -> None:
    for name in ("sensor_msgs/JointState", "sensor_msgs/msg/JointState", "sensor_msgs::msg::dds_::JointState_"):
        assert canonical_type(name) == JOINT_STATE


def test_recordings_of_the_reference_rig(shared_data: Path) -> None:
    log = read_log(shared_data / "logs" / "nominal_base.mcap")
    assert log.notes == ()
    assert log.rig().string.length == 4000.0
    assert {key: len(series.time) for key, series in log.series().items()} == {
        "top_drive": 3000,
        "top_drive_command": 3000,
        "draw_works": 3000,
        "standpipe_pressure": 3000,
        "mud_pump": 3000,
        "mwd_tool_face": 24,
        "tool_face_target": 1,
    }
    assert log.mwd_tool_face is not None and log.mud_pump is not None
    np.testing.assert_allclose(log.mwd_tool_face.time, 12.0 * np.arange(1, 25), atol=1e-6)
    np.testing.assert_allclose(log.mwd_tool_face.arrival - log.mwd_tool_face.time, 6.0, atol=1e-6)
    assert log.mud_pump.velocity[-1] == pytest.approx(0.032 / 0.0026)


def test_field_recording_equals_its_table(shared_data: Path) -> None:
    log = read_log(shared_data / "field" / "well_b_1733m.mcap")
    table = np.genfromtxt(shared_data / "field" / "well_b_1733m.csv", delimiter=",", names=True)
    assert log.top_drive is not None
    np.testing.assert_allclose(log.top_drive.time, table["time_s"], atol=1e-6)
    np.testing.assert_allclose(log.top_drive.velocity, table["top_drive_speed_rad_s"])
    np.testing.assert_allclose(log.top_drive.effort, table["surface_torque_N_m"])
