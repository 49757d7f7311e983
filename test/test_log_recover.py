"""`recover` and `info`: what a log still holds as a whole log, and what a log is good for."""

import json
from pathlib import Path

import numpy as np
import pytest
from fork_server import run_cli
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, read_log
from slider_drilling.log.info import log_info
from slider_drilling.log.recover import recover
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import JOINT_STATE


def write(path: Path, steps: range, start: float = 100.0, rig: str = "schema: x") -> bytes:
    with LogWriter(path, rig_text=rig, recorded_by="test") as writer:
        for step in steps:
            now = start + 0.1 * step
            writer.joint_state("top_drive/joint_states", now, "top_drive", step, 0.0, 0.0)
            writer.fluid_pressure("standpipe_pressure", now, step, log_time_s=now + 0.02)
            writer.wrench("other/topic", now, (step, 0.0, 0.0))
    return path.read_bytes()


def test_a_broken_log_becomes_a_whole_one(tmp_path: Path) -> None:
    whole = write(tmp_path / "whole.mcap", range(2000))
    (tmp_path / "broken.mcap").write_bytes(whole[: len(whole) * 2 // 3])
    done = run_cli("recover", "broken.mcap", "-o", "fixed.mcap", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "note: broken.mcap: breaks off at byte" in done.stderr
    assert "wrote fixed.mcap: " in done.stdout
    before, after = read_log(tmp_path / "broken.mcap"), read_log(tmp_path / "fixed.mcap")
    assert after.notes == () and before.notes != () and after.rig_text == "schema: x"
    assert before.top_drive is not None and after.top_drive is not None
    np.testing.assert_array_equal(before.top_drive.position, after.top_drive.position)
    with AnyReader([tmp_path / "fixed.mcap"]) as reader:
        topics = {connection.topic: connection.msgcount for connection in reader.connections}
        values = [reader.deserialize(raw, connection.msgtype).wrench.force.x
                  for connection, _, raw in reader.messages() if connection.topic == "/other/topic"]
    assert values == list(range(len(values))) and topics["/other/topic"] == len(values) > 1000
    with (tmp_path / "fixed.mcap").open("rb") as file:
        names = [record.name for record in make_reader(file).iter_metadata()]
    assert names == ["slider_drilling", "slider_drilling_recovered"]


def test_two_runs_become_two_logs(tmp_path: Path) -> None:
    """As a second simulator in the same graph makes them: time begins again."""
    with LogWriter(tmp_path / "two.mcap") as writer:
        for run in (1000, 2000):
            for step in range(300):
                writer.joint_state("top_drive/command", 0.1 * step, "top_drive", run + step, 0.0)
                writer.joint_state("top_drive/joint_states", 0.1 * step, "top_drive", run + step, 0.0, 0.0)
    with pytest.raises(InputError, match="two runs in one log; `slider-drilling recover` splits it"):
        read_log(tmp_path / "two.mcap")
    written, notes = recover(tmp_path / "two.mcap", tmp_path / "run.mcap")
    assert [one.path.name for one in written] == ["run_1.mcap", "run_2.mcap"]
    assert any("held 2 runs" in note for note in notes)
    for one, run in zip(written, (1000, 2000), strict=True):
        log = read_log(one.path)
        assert log.notes == () and log.top_drive is not None and log.top_drive_command is not None
        assert log.top_drive.position.tolist() == [run + step for step in range(300)]
        assert log.top_drive_command.position[1:].tolist() == [run + step for step in range(1, 300)]


def test_concatenated_logs_and_folders_are_recovered(tmp_path: Path) -> None:
    one, two = write(tmp_path / "a.mcap", range(500)), write(tmp_path / "b.mcap", range(500, 900))
    (tmp_path / "joined.mcap").write_bytes(one + two)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "p.mcap").write_bytes(one)
    (tmp_path / "parts" / "p_1.mcap").write_bytes(two[:-3000])
    for source, least in (("joined.mcap", 900), ("parts", 700)):
        recover(tmp_path / source, tmp_path / "fixed.mcap")
        log = read_log(tmp_path / "fixed.mcap")
        assert log.notes == () and log.top_drive is not None and len(log.top_drive.time) >= least
        with (tmp_path / "fixed.mcap").open("rb") as file:
            summary = make_reader(file).get_summary()
        assert summary is not None and len(summary.channels) == 3 and len(summary.attachment_indexes) == 1


def test_swapped_chunks_are_put_in_order(tmp_path: Path) -> None:
    whole = write(tmp_path / "run.mcap", range(2000))
    with (tmp_path / "run.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    places = [(one.chunk_start_offset, one.chunk_start_offset + one.chunk_length + one.message_index_length)
              for one in summary.chunk_indexes]
    (a, b), (c, d) = places[0], places[2]
    (tmp_path / "run.mcap").write_bytes(whole[:a] + whole[c:d] + whole[b:c] + whole[a:b] + whole[d:])
    recover(tmp_path / "run.mcap", tmp_path / "fixed.mcap")
    log = read_log(tmp_path / "fixed.mcap")
    assert log.notes == () and log.top_drive is not None
    np.testing.assert_array_equal(log.top_drive.position, np.arange(2000))


@pytest.mark.parametrize(("make", "expected"), [
    (lambda path: path.write_bytes(b"no log"), "not an MCAP file"),
    (lambda path: LogWriter(path).close(), "holds no message that can be recovered"),
    (lambda path: None, "no such log"),
])
def test_nothing_to_recover_is_one_line(tmp_path: Path, make, expected) -> None:
    make(tmp_path / "log.mcap")
    done = run_cli("recover", "log.mcap", "-o", "fixed.mcap", folder=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr
    assert not (tmp_path / "fixed.mcap").exists()


def test_the_log_itself_is_not_written_over(tmp_path: Path) -> None:
    before = write(tmp_path / "log.mcap", range(10))
    (tmp_path / "link.mcap").symlink_to("log.mcap")
    for output in ("log.mcap", "link.mcap"):
        done = run_cli("recover", "log.mcap", "-o", output, folder=tmp_path)
        assert done.returncode == 2 and "choose another name" in done.stderr
    assert (tmp_path / "log.mcap").read_bytes() == before


def test_info_counts_what_there_is(tmp_path: Path, repository: Path) -> None:
    """A gap, a step back of the clock, messages lost, another's topic: every figure is what was written."""
    rig = (repository / "config" / "rig.example.yaml").read_text()
    path = tmp_path / "run.mcap"
    with LogWriter(path, rig_text=rig) as writer:
        for step in range(200):
            now = 50.0 + 0.1 * step + (30.0 if step >= 100 else 0.0)
            stamp = now - 5.0 if step == 150 else now
            data = cdr.encode_joint_state(round((stamp - 0.05) * 1e9), "top_drive", step, 0.0, 0.0)
            # Three messages never came before the fiftieth.
            writer.message("top_drive/joint_states", JOINT_STATE, data, round(now * 1e9), 0,
                           step if step < 50 else step + 3)
            if step % 2 == 0:
                writer.wrench("gripper/force", now, (0.0, 0.0, 0.0))
    found = log_info(path)
    (other, drive) = found.topics
    assert (other.topic, other.messages) == ("/gripper/force", 100)
    assert other.message_type == "geometry_msgs/msg/WrenchStamped"
    assert (drive.messages, drive.gaps, drive.lost, drive.stamp_steps_back) == (200, 1, 3, 1)
    assert drive.rate == pytest.approx(10.0) and drive.longest_gap == pytest.approx(30.1)
    assert drive.largest_step_back == pytest.approx(4.9) and drive.lag == pytest.approx(0.05)
    assert other.lost == 0 and other.rate == pytest.approx(5.0) and np.isnan(other.lag)
    assert found.seconds == pytest.approx(49.9) and found.attachments == ("rig.yaml",) and found.notes == ()


def test_info_says_what_is_missing(tmp_path: Path, repository: Path) -> None:
    with LogWriter(tmp_path / "bare.mcap") as writer:
        for step in range(20):
            writer.joint_state("mud_pump/joint_states", 0.1 * step, "mud_pump", velocity=1.0)
    done = run_cli("info", "bare.mcap", "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    tree = json.loads(done.stdout)
    assert any("has no rig.yaml attachment" in reason for reason in tree["missing_for_replay"])
    assert any("nothing drives the plant" in reason for reason in tree["missing_for_diagnosis"])
    with LogWriter(tmp_path / "full.mcap", (repository / "config" / "rig.example.yaml").read_text()) as writer:
        for step in range(20):
            writer.joint_state("top_drive/joint_states", 0.1 * step, "top_drive", 0.0, 0.0, 1.0)
    done = run_cli("info", "full.mcap", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "replay: ready; diagnosis: not possible" in done.stdout  # the drive stands still
    assert "the block is assumed to stand still" in done.stdout
    done = run_cli("info", "nothing.mcap", folder=tmp_path)
    assert done.returncode == 2 and done.stderr == "nothing.mcap: no such log; check the path\n"


def test_info_tells_why_replay_is_impossible(tmp_path: Path) -> None:
    path = tmp_path / "two.mcap"
    with LogWriter(path) as writer:
        for time in (1.0, 2.0, 3.0, 0.0, 1.0):
            writer.joint_state("top_drive/joint_states", time, "top_drive", 0.0, 0.0, 0.0)
    done = run_cli("info", path, folder=tmp_path)
    assert done.returncode == 0
    assert "two runs in one log" in done.stdout and "replay: not possible" in done.stdout and "1 (3.0 s)" in done.stdout
