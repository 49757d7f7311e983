"""Logs written and read back, and how a log that is not finished ends."""

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

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, Status, read_log

RIG_TEXT = "schema: slider_drilling/rig/1\n# Pa, N m, µ\n"


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


def test_log_needs_no_ros(repository: Path) -> None:
    probe = "import sys, slider_drilling.log\nprint('rclpy' in sys.modules, 'sensor_msgs' in sys.modules)"
    answer = subprocess.run(
        [sys.executable, "-c", probe], cwd=repository, capture_output=True, text=True, env=dict(os.environ), timeout=120
    )
    assert answer.stdout.split() == ["False", "False"]
