"""Logs written and read back, and how a log that is not finished ends."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from slider_drilling.errors import InputError
from slider_drilling.log import Level, LogWriter, Status, read_log

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
                writer.diagnostics("diagnostics", time, [Status(Level.WARN, "pump", "slow", (("speed", "1"),), "rig")])


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


finite = st.floats(-50.0, 50.0, allow_nan=False, width=64)  # what a rig may have; more: test_limits.py


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
    values[:, 1] *= 5e-4  # a speed that a rig can have
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
    with pytest.raises(InputError, match="give the rig file with --rig"):
        read_log(path).rig()


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
def test_what_was_recorded_is_kept_whatever_ends_it(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "run.mcap"
    with pytest.raises(error), LogWriter(path) as writer:
        writer.joint_state("top_drive/joint_states", 1.0, "top_drive", 0.0, 0.0, 0.0)
        raise error
    log = read_log(path)
    assert log.notes == () and log.top_drive is not None
    assert [file.name for file in tmp_path.iterdir()] == ["run.mcap"]


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
def test_whole_log_is_complete_or_absent(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "run.mcap"
    write_example(path, seconds=1)
    before = path.read_bytes()
    with pytest.raises(error), LogWriter(path, whole=True) as writer:
        writer.joint_state("top_drive/joint_states", 1.0, "top_drive", 0.0, 0.0, 0.0)
        assert path.read_bytes() == before
        raise error
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["run.mcap"]


def test_a_recording_takes_its_name_when_it_begins(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "run.mcap") as writer:
        writer.joint_state("top_drive/joint_states", 1.0, "top_drive", 7.0, 0.0, 0.0)
        assert (tmp_path / "run.mcap").stat().st_mode & 0o044
        with pytest.raises(InputError, match=r"run\.mcap: exists already; give another name"):
            LogWriter(tmp_path / "run.mcap")
    assert read_log(tmp_path / "run.mcap").top_drive.position == [7.0]  # type: ignore[union-attr]


def hidden_bytes(folder: Path) -> int:
    """Of the file that is to become a log."""
    try:
        return sum(part.stat().st_size for part in folder.glob(".run.mcap.*"))
    except FileNotFoundError:
        return 0


def test_interrupted_import_leaves_the_log_that_was_there(tmp_path: Path) -> None:
    """A real process, interrupted while it writes: the older log of that name stays as it was."""
    rows = "".join(f"{k * 0.01:.2f},{k},1\n" for k in range(40_000))
    (tmp_path / "table.csv").write_text("t,angle,torque\n" + rows)
    (tmp_path / "map.yaml").write_text(
        "schema: slider_drilling/csv/1\ntime: {column: t, unit: s}\nchannels:\n"
        "  top_drive_angle: {column: angle, unit: rad}\n  surface_torque: {column: torque, unit: N m}\n")
    output = tmp_path / "run.mcap"
    write_example(output, seconds=1)
    before = output.read_bytes()
    process = subprocess.Popen(
        [sys.executable, "-m", "slider_drilling", "import", "table.csv", "--mapping", "map.yaml", "-o", "run.mcap"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}, stderr=subprocess.PIPE)
    while process.poll() is None and hidden_bytes(tmp_path) < 10_000:
        time.sleep(0.005)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and said.splitlines()[-1] == b"interrupted"
    assert output.read_bytes() == before
    assert sorted(file.name for file in tmp_path.iterdir()) == ["map.yaml", "run.mcap", "table.csv"]


def test_unreachable_folder_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no-such/run\.mcap: cannot write this log: No such file or directory"):
        LogWriter(tmp_path / "no-such" / "run.mcap")


def test_folder_and_negative_log_times_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="it is a folder"):
        LogWriter(tmp_path)
    refused = pytest.raises(InputError, match="/tool_face/target: log time -1 s is out of range")
    with refused, LogWriter(tmp_path / "a.mcap") as writer:
        writer.joint_state("tool_face/target", -1.0, "tool_face", 0.0)


FULL_DISK = """
import random, resource, signal, sys
from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter
random.seed(1)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), -1))
try:
    with LogWriter(sys.argv[1], rig_text="schema: x", whole=sys.argv[3] == "whole") as writer:
        for step in range(20_000):
            if step == 18_000 and sys.argv[3] == "freed":
                resource.setrlimit(resource.RLIMIT_FSIZE, (-1, -1))
            writer.joint_state("top_drive/joint_states", step * 0.1, "top_drive", step, *[random.random()] * 2)
except InputError as error:
    print(error)
"""


def fill_disk(path: Path, size: int, how: str = "record") -> str:
    """Write a log past a limit on the size of files, which fails just as a full disk does; what is said of it."""
    command = [sys.executable, "-Bc", FULL_DISK, str(path), str(size), how]
    answer = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True, timeout=120)
    assert answer.stderr == ""
    return answer.stdout


@pytest.mark.parametrize("size", [150_000, 300_000, 300_001, 300_040, 333_333])
def test_full_disk_keeps_what_was_written(tmp_path: Path, size: int) -> None:
    path = tmp_path / "run.mcap"
    said = fill_disk(path, size)
    found = re.fullmatch(
        re.escape(f"{path}: cannot write this log: File too large; ")
        + r"(\d+) messages over ([\d.]+) s are safe in it, the (\d+) after them are lost\n", said)
    assert found, said
    log = read_log(path)
    assert log.rig_text == "schema: x" and log.top_drive is not None
    np.testing.assert_array_equal(log.top_drive.position, np.arange(int(found[1])))
    assert log.top_drive.time[-1] == pytest.approx(float(found[2]), abs=0.06)
    assert int(found[1]) > 1000 and 0 < int(found[3]) < 2000
    assert log.notes == ()


@pytest.mark.parametrize("room", [0, 1, 20, 49, 50])
def test_log_on_a_full_disk_has_an_end_however_little_room_is_left(tmp_path: Path, room: int) -> None:
    fill_disk(tmp_path / "first.mcap", 150_000)
    # Its end without a summary takes 50 bytes: the second disk has so little room, or none, after the same messages.
    written = (tmp_path / "first.mcap").stat().st_size - 50
    fill_disk(tmp_path / "run.mcap", written + room)
    first, log = read_log(tmp_path / "first.mcap"), read_log(tmp_path / "run.mcap")
    np.testing.assert_array_equal(log.top_drive.position, first.top_drive.position)
    assert log.notes == ()
    assert (tmp_path / "run.mcap").stat().st_size <= written + room


def test_full_disk_leaves_no_empty_log(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    assert fill_disk(path, 150_000, "whole") == f"{path}: cannot write this log: File too large\n"
    assert fill_disk(path, 100) == f"{path}: cannot write this log: File too large\n"
    assert list(tmp_path.iterdir()) == []


def test_killed_recording_loses_the_last_second_at_most(tmp_path: Path) -> None:
    program = (
        "import sys, time\nfrom slider_drilling.log import LogWriter\nstarted = time.monotonic()\n"
        "writer = LogWriter(sys.argv[1], rig_text='schema: x')\n"
        "while True:\n"
        "    now = time.monotonic() - started\n"
        "    writer.joint_state('top_drive/joint_states', now, 'top_drive', now, 0.0, 0.0)\n"
        "    print(now, flush=True)\n"
        "    time.sleep(0.02)\n"
    )
    path = tmp_path / "run.mcap"
    process = subprocess.Popen([sys.executable, "-c", program, str(path)], cwd=Path(__file__).parents[1],
                               stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    first = float(process.stdout.readline())
    time.sleep(1.7)
    process.kill()
    written = [first, *map(float, process.stdout.read().split())]
    process.wait()
    log = read_log(path)
    assert log.rig_text == "schema: x" and log.top_drive is not None
    np.testing.assert_array_equal(log.top_drive.position, written[: len(log.top_drive.position)])
    assert written[-1] - log.top_drive.position[-1] < 1.0
    assert any("breaks off" in note for note in log.notes)


def test_log_needs_no_ros(repository: Path) -> None:
    probe = "import sys, slider_drilling.log\nprint('rclpy' in sys.modules, 'sensor_msgs' in sys.modules)"
    answer = subprocess.run(
        [sys.executable, "-c", probe], cwd=repository, capture_output=True, text=True, env=dict(os.environ), timeout=120
    )
    assert answer.stdout.split() == ["False", "False"]


def test_a_log_that_is_being_recorded_is_called_so(tmp_path: Path) -> None:
    writer = LogWriter(tmp_path / "run.mcap")
    for step in range(100):
        writer.joint_state("top_drive/joint_states", 0.1 * step, "top_drive", 0.1 * step, 1.0, 5e3)
    writer.flush()
    # By another program: that of the reader may be the recorder's, too.
    program = "import sys; from slider_drilling.log import read_log; print(*read_log(sys.argv[1]).notes)"
    for notes in (
        " ".join(read_log(tmp_path / "run.mcap").notes),
        subprocess.run([sys.executable, "-c", program, tmp_path / "run.mcap"], capture_output=True, text=True,
                       check=True).stdout.strip(),
    ):  # fmt: skip
        assert notes == "run.mcap: is still being recorded; recovered up to the last complete chunk"
    writer.close()
    assert read_log(tmp_path / "run.mcap").notes == ()


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="the system does not tell who writes to a file")
def test_a_killed_recording_is_not_called_damaged(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "run.mcap") as writer:
        for step in range(100):
            writer.joint_state("top_drive/joint_states", 0.1 * step, "top_drive", 0.1 * step, 1.0, 5e3)
        writer.flush()
        (tmp_path / "cut.mcap").write_bytes((tmp_path / "run.mcap").read_bytes())
    (note,) = read_log(tmp_path / "cut.mcap").notes
    assert "breaks off at byte" in note and "damaged" not in note
