"""Logs written and read back, logs of other makers, and the recordings that come with the project."""

import io
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mcap.writer import CompressionType, Writer
from mcap_ros2.writer import Writer as Ros2Writer

from slider_drilling.errors import InputError
from slider_drilling.log import TOPICS, LogWriter, Status, read_log
from slider_drilling.log.schemas import SCHEMAS
from slider_drilling.log.topics import JOINT_STATE, canonical_type, namespace_of

RIG_TEXT = "schema: slider_drilling/rig/1\n# Pa, N m, µ\n"


def joint(stamp_s: float, name: str = "top_drive", *values: float) -> dict[str, object]:
    sec, nanosec = divmod(round(stamp_s * 1e9), 10**9)
    position, velocity, effort = [[value] for value in values] or [[1.0], [2.0], [3.0]]
    header = {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": ""}
    return {"header": header, "name": [name], "position": position, "velocity": velocity, "effort": effort}


def write_example(path: Path, seconds: int = 30) -> None:
    with LogWriter(path, rig_text=RIG_TEXT, recorded_by="test", notes="none") as writer:
        for step in range(seconds * 10):
            time = 1000.0 + step * 0.1
            writer.joint_state("top_drive/joint_states", time, "top_drive", 0.1 * step, 0.2, 5000.0 + step)
            writer.joint_state("/top_drive/command", time, "top_drive", 0.1 * step, 0.2)
            writer.fluid_pressure("standpipe_pressure", time, 18e6, 1.6e9)
            writer.wrench("truth/weight_on_bit", time, (3e4, 0.0, 0.0))
            if step % 100 == 99:
                writer.joint_state("mwd/tool_face", time - 6.0, "tool_face", 0.5, log_time_s=time)
                writer.diagnostics("diagnostics", time, [Status(1, "pump", "slow", "rig", (("speed", "1"),))])


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    write_example(path)
    log = read_log(path)
    assert log.start == 1000.0
    assert log.notes == ()
    assert log.rig_text == RIG_TEXT
    assert {"version", "start_time"} <= set(log.metadata)
    assert (log.metadata["recorded_by"], log.metadata["notes"]) == ("test", "none")
    assert log.top_drive is not None and log.top_drive_command is not None
    assert log.standpipe_pressure is not None and log.truth_weight_on_bit is not None
    np.testing.assert_allclose(log.top_drive.time, 0.1 * np.arange(300), atol=1e-9)
    np.testing.assert_array_equal(log.top_drive.effort, 5000.0 + np.arange(300))
    assert np.isnan(log.top_drive_command.effort).all()
    assert (log.standpipe_pressure.value == 18e6).all() and (log.standpipe_pressure.variance == 1.6e9).all()
    assert (log.truth_weight_on_bit.value == 3e4).all()
    assert log.mwd_tool_face is not None
    np.testing.assert_allclose(log.mwd_tool_face.arrival - log.mwd_tool_face.time, 6.0)
    assert log.draw_works is None and log.mud_pump is None
    assert [file.name for file in tmp_path.iterdir()] == ["run.mcap"]


def test_other_programs_open_what_is_written(tmp_path: Path) -> None:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory
    from rosbags.highlevel import AnyReader

    path = tmp_path / "run.mcap"
    write_example(path)
    with AnyReader([path]) as reader:
        efforts = [
            reader.deserialize(raw, connection.msgtype).effort[0]  # type: ignore[attr-defined]
            for connection, _, raw in reader.messages()
            if connection.topic == "/top_drive/joint_states"
        ]
        assert {connection.topic for connection in reader.connections} >= {"/standpipe_pressure", "/diagnostics"}
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
    assert efforts == [5000.0 + step for step in range(300)]
    with path.open("rb") as file:
        indexed = make_reader(file, decoder_factories=[DecoderFactory()])
        summary = indexed.get_summary()
        assert indexed.get_header().profile == "ros2"
        assert summary is not None and summary.chunk_indexes[0].compression == "zstd"
        assert [(each.name, each.media_type) for each in indexed.iter_attachments()] == [
            ("rig.yaml", "application/yaml")
        ]
        pressures = [
            message.fluid_pressure for *_, message in indexed.iter_decoded_messages(topics=["/standpipe_pressure"])
        ]
    assert pressures == [18e6] * 300


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


@settings(max_examples=30)
@given(
    start=st.integers(0, 2_000_000_000),
    gaps=hnp.arrays(np.int64, st.integers(1, 40), elements=st.integers(1, 10**10)),
    data=st.data(),
)
def test_round_trip_of_any_numbers(
    tmp_path_factory: pytest.TempPathFactory, start: int, gaps: np.ndarray, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("round") / "run.mcap"
    # Whole microseconds: an epoch in s as a float has no more.
    time = start + np.cumsum(gaps // 1000 + 1) * 1e-6
    values = data.draw(hnp.arrays(np.float64, (len(gaps), 3), elements=finite))
    with LogWriter(path) as writer:
        for stamp, row in zip(time, values, strict=True):
            writer.joint_state("top_drive/joint_states", stamp, "top_drive", *row)
    log = read_log(path)
    assert log.top_drive is not None and log.rig_text is None
    np.testing.assert_allclose(log.top_drive.time, time - time[0], atol=1e-6)
    read = np.column_stack([log.top_drive.position, log.top_drive.velocity, log.top_drive.effort])
    np.testing.assert_array_equal(read, values)


def test_rig_file_beside_the_log_comes_first(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    write_example(path, seconds=1)
    beside = tmp_path / "other.yaml"
    beside.write_text("schema: other\n")
    log = read_log(path, beside)
    assert (log.rig_text, log.rig_source) == ("schema: other\n", str(beside))
    with pytest.raises(InputError, match=r"missing\.yaml: no such rig file"):
        read_log(path, tmp_path / "missing.yaml")


def test_log_without_rig_says_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path) as writer:
        writer.joint_state("top_drive/joint_states", 0.0, "top_drive", 0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="give the rig file beside it"):
        read_log(path).rig()


def test_error_inside_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), LogWriter(tmp_path / "run.mcap"):
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


def test_interrupt_inside_leaves_a_whole_log(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with pytest.raises(KeyboardInterrupt), LogWriter(path) as writer:
        writer.joint_state("top_drive/joint_states", 1.0, "top_drive", 0.0, 0.0, 0.0)
        raise KeyboardInterrupt
    log = read_log(path)
    assert log.notes == () and log.top_drive is not None
    assert [file.name for file in tmp_path.iterdir()] == ["run.mcap"]


def test_unreachable_folder_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no-such/run\.mcap: cannot write this log: No such file or directory"):
        LogWriter(tmp_path / "no-such" / "run.mcap")


def test_folder_as_a_log_and_times_before_zero_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="it is a folder"):
        LogWriter(tmp_path)
    with pytest.raises(InputError, match="/tool_face/target: logged at -1 s"), LogWriter(tmp_path / "a.mcap") as writer:
        writer.joint_state("tool_face/target", -1.0, "tool_face", 0.0)
    assert list(tmp_path.iterdir()) == []


def test_full_disk_leaves_nothing(tmp_path: Path) -> None:
    # A limit on the size of files stands in for the disk: writing past it fails just as it does there.
    program = (
        "import resource, signal, sys\nfrom slider_drilling.errors import InputError\n"
        "from slider_drilling.log import LogWriter\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))\n"
        "import random\nrandom.seed(1)\n"
        "try:\n"
        "    with LogWriter(sys.argv[1]) as writer:\n"
        "        for step in range(20_000):\n"
        "            writer.joint_state('top_drive/joint_states', step * 0.1, 'top_drive', *[random.random()] * 3)\n"
        "except InputError as error:\n"
        "    print(error)\n"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "run.mcap")]
    answer = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True, timeout=120)
    assert answer.stderr == ""
    assert answer.stdout == f"{tmp_path / 'run.mcap'}: cannot write this log: File too large\n"
    assert list(tmp_path.iterdir()) == []


def test_killed_run_leaves_a_readable_file(tmp_path: Path) -> None:
    program = (
        "import os, signal, sys\nfrom slider_drilling.log import LogWriter\n"
        "writer = LogWriter(sys.argv[1], rig_text='schema: x')\n"
        "for step in range(3000):\n"
        "    writer.joint_state('top_drive/joint_states', step * 0.1, 'top_drive', step, 0.0, 0.0)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "run.mcap")]
    answer = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, timeout=120)
    assert answer.returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".run.mcap.") and left.suffix == ".part"
    log = read_log(left)
    assert log.rig_text == "schema: x"
    assert log.top_drive is not None
    assert 2000 < len(log.top_drive.time) <= 3000
    np.testing.assert_array_equal(log.top_drive.position, np.arange(len(log.top_drive.time)))
    assert any("breaks off" in note for note in log.notes)


class TestOtherMakers:
    """Logs as other recorders write them."""

    def ros2(self, path: Path, rows: list[tuple[str, dict[str, object], int]], kind: str = JOINT_STATE) -> Path:
        with path.open("wb") as file:
            writer = Ros2Writer(file)
            schema = writer.register_msgdef(kind, SCHEMAS[kind])
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
        schema = donor.register_msgdef(JOINT_STATE, SCHEMAS[JOINT_STATE])
        donor.write_message("/a", schema, joint(5.0, "top_drive", 1.0, 2.0, 3.0), 5 * 10**9)
        donor.finish()
        from mcap.reader import make_reader

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
        write_example(whole, seconds=2)
        from mcap.reader import make_reader

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
            schema_id = writer.register_schema(JOINT_STATE, "ros2msg", SCHEMAS[JOINT_STATE].encode())
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
        with pytest.raises(InputError, match="say with --namespace which"):
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
        write_example(tmp_path / "other_run.mcap", seconds=1)
        write_example(tmp_path / "third_run.mcap", seconds=1)
        with pytest.raises(InputError, match=r"other_run\.mcap and third_run\.mcap overlap in time"):
            read_log(tmp_path)
        (tmp_path / "empty").mkdir()
        with pytest.raises(InputError, match=r"a folder without \.mcap files"):
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
    lengths = {key: 0 if getattr(log, key) is None else len(getattr(log, key).time) for key in TOPICS}
    assert lengths == {
        "top_drive": 3000,
        "top_drive_command": 3000,
        "draw_works": 3000,
        "draw_works_command": 0,
        "standpipe_pressure": 3000,
        "mud_pump": 3000,
        "mwd_tool_face": 24,
        "tool_face_target": 1,
        "truth_bit": 0,
        "truth_weight_on_bit": 0,
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


def test_log_needs_no_ros(repository: Path) -> None:
    probe = "import sys, slider_drilling.log\nprint('rclpy' in sys.modules, 'sensor_msgs' in sys.modules)"
    answer = subprocess.run(
        [sys.executable, "-c", probe], cwd=repository, capture_output=True, text=True, env=dict(os.environ), timeout=120
    )
    assert answer.stdout.split() == ["False", "False"]
