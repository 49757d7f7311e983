"""Who sent what: channels of one topic, second publishers, joints without names or in one topic."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, RigLog, read_log
from slider_drilling.log.info import log_info
from slider_drilling.log.recover import recover
from slider_drilling.messages import cdr
from slider_drilling.messages.message_types import MESSAGE_TYPES
from slider_drilling.messages.topics import JOINT_STATE

START_NS = 1_700_000_000_000_000_000
COUNT = 100
Row = tuple[int, float, bytes, int]  # publisher, log time s, message, sequence number


def angle(time: float) -> float:
    return 20.0 + 5.0 * float(np.sin(0.3 * time))


def torque(time: float) -> float:
    return 9000.0 + 4000.0 * float(np.sin(0.3 * time - 0.5))


def state(time: float, values: tuple[float, float, float], frame: bytes = b"rig_floor") -> bytes:
    """A JointState of the top drive in a frame, which has nine letters."""
    return cdr.encode_joint_state(stamp(time), "top_drive", *values).replace(b"rig_floor", frame)


def stamp(time: float) -> int:
    return START_NS + round(time * 1e9)


def real(publisher: int = 1, first: int = 0, last: int = COUNT, late: float = 0.0, **options: bytes) -> list[Row]:
    """Samples of a rocking top drive at 10 Hz."""
    times = [0.1 * step + late for step in range(first, last)]
    return [
        (publisher, time, state(time, (angle(time), 0.0, torque(time)), **options), step)
        for step, time in enumerate(times)
    ]


def zeros(publisher: int = 1, late: float = 0.03, period: float = 0.1, **options: bytes) -> list[Row]:
    """Samples of a publisher that has nothing to say."""
    times = [period * step + late for step in range(round(0.1 * COUNT / period))]
    return [(publisher, time, state(time, (0.0, 0.0, 0.0), **options), step) for step, time in enumerate(times)]


def write(path: Path, rows: list[Row], topic: str = "/top_drive/joint_states", sort: bool = True) -> Path:
    """A log of these messages; each publisher is a channel."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("ros2", "other recorder")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", MESSAGE_TYPES[JOINT_STATE].definition.encode())
        channels: dict[int, int] = {}
        for publisher, time, data, sequence in sorted(rows, key=lambda row: row[1]) if sort else rows:
            if publisher not in channels:
                channels[publisher] = writer.register_channel(topic, "cdr", schema, {"publisher": str(publisher)})
            writer.add_message(channels[publisher], stamp(time), data, stamp(time), sequence)
        writer.finish()
    return path


def check_real(log: RigLog, words: str | None = None) -> None:
    """The log holds the real samples and no others; its only note has these words."""
    assert log.top_drive is not None
    expected = [angle(0.1 * step) for step in range(COUNT)]
    np.testing.assert_allclose(log.top_drive.position, expected)
    assert [words in note for note in log.notes] == [True] if words else log.notes == ()


@pytest.mark.parametrize("split", [
    lambda step: step == 0, lambda step: step % 2, lambda step: step % 7 == 3, lambda step: step // 40,
    lambda step: step == 99,
])  # fmt: skip
@pytest.mark.parametrize("sort", [True, False], ids=["by time", "by channel"])
def test_one_run_in_several_channels_is_one(tmp_path: Path, split: Callable[[int], int], sort: bool) -> None:
    rows = [(int(split(step)), *row[1:]) for step, row in enumerate(real())]
    rows = rows if sort else sorted(rows, key=lambda row: row[0])
    path = write(tmp_path / "log.mcap", rows, sort=sort)
    check_real(read_log(path))
    [topic] = log_info(path).topics
    assert (topic.messages, topic.lost, topic.stamp_steps_back) == (COUNT, 0, 0) and len(topic.channels) > 1
    written, notes = recover(path, tmp_path / "whole.mcap")
    assert [log.messages for log in written] == [COUNT] and notes == []


@pytest.mark.parametrize("period", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("late", [0.0, 0.03])
@pytest.mark.parametrize("mark", ["channel", "frame", "nothing"])
def test_a_second_publisher_of_zeros_is_left_out(tmp_path: Path, mark: str, late: float, period: float) -> None:
    if mark == "channel":
        other = zeros(2, late, period)
    else:
        other = zeros(1, late, period, frame=b"other_frm" if mark == "frame" else b"rig_floor")
    for order in (real() + other, other + real()):
        log = read_log(write(tmp_path / "log.mcap", order))
        check_real(log, "samples were left out" if mark != "nothing" else "samples of zeros between")


def test_zeros_of_one_publisher_are_kept(tmp_path: Path) -> None:
    """A pump that stands between two stages, and a drive that has not begun to turn."""
    times = [0.1 * step for step in range(3 * COUNT)]
    rows = [(1, time, state(time, (0.0, 0.0 if COUNT <= step < 2 * COUNT else 12.0, 0.0)), step)
            for step, time in enumerate(times)]  # fmt: skip
    log = read_log(write(tmp_path / "log.mcap", rows))
    assert log.notes == () and log.top_drive is not None and len(log.top_drive.time) == 3 * COUNT


@pytest.mark.parametrize("late", [0.0, 0.03])
@pytest.mark.parametrize("publisher", [1, 2])
def test_zeros_of_one_quantity_are_left_out(tmp_path: Path, publisher: int, late: float) -> None:
    """Another program sends angle and speed on, with a torque of zero."""
    other = [(publisher, time + late, state(time + late, (angle(time + late), 0.0, 0.0)), step)
             for step, (_, time, _, _) in enumerate(real())]  # fmt: skip
    log = read_log(write(tmp_path / "log.mcap", real() + other))
    assert log.top_drive is not None and any("zeros between other numbers" in note for note in log.notes)
    torques = log.top_drive.effort[~np.isnan(log.top_drive.effort)]
    np.testing.assert_allclose(torques, [torque(0.1 * step) for step in range(COUNT)])


def test_a_coarse_speed_around_zero_is_kept(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    times = [0.1 * step for step in range(10 * COUNT)]
    rows = [(1, time, cdr.encode_joint_state(stamp(time), "top_drive", None, 0.01 * float(rng.integers(0, 2)), None), k)
            for k, time in enumerate(times)]  # fmt: skip
    log = read_log(write(tmp_path / "log.mcap", rows))
    assert log.notes == () and log.top_drive is not None and len(log.top_drive.time) == 10 * COUNT


def test_two_publishers_that_disagree_are_refused(tmp_path: Path) -> None:
    other = [(2, time, state(time + 0.03, (900.0 - 3.0 * time, 2.0, 1.0)), step)
             for step, (_, time, _, _) in enumerate(real())]  # fmt: skip
    path = write(tmp_path / "log.mcap", real() + other)
    with pytest.raises(InputError, match=r"two publishers .*\(channel 1, channel 2\); choose one with `channel`"):
        read_log(path)
    (tmp_path / "topics.yaml").write_text("top_drive: {topic: /top_drive/joint_states, channel: 1}\n")
    check_real(read_log(path, topics=tmp_path / "topics.yaml"))


def others(values: Callable[[float], tuple[float, float, float]], late: float, period: float) -> list[Row]:
    """Samples of another publisher in the same channel, as a bag without sequence numbers holds them."""
    times = [period * step + late for step in range(round(0.1 * COUNT / period))]
    return [(1, time, state(time, values(time)), 0) for time in times]


@pytest.mark.parametrize("late", [0.0, 0.03, 0.05])
@pytest.mark.parametrize("period", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("values", [(5.0, 0.0, 12.0), (-999.25, -999.25, -999.25), (20.0, 1.0, 1.0)])
def test_a_publisher_of_constants_is_left_out(
    tmp_path: Path, values: tuple[float, float, float], period: float, late: float
) -> None:
    ours = [(*row[:3], 0) for row in real()]
    log = read_log(write(tmp_path / "log.mcap", ours + others(lambda time: values, late, period)))
    assert log.top_drive is not None and any("samples that never change" in note for note in log.notes)
    np.testing.assert_allclose(log.top_drive.position, [angle(0.1 * step) for step in range(COUNT)])
    np.testing.assert_allclose(log.top_drive.effort, [torque(0.1 * step) for step in range(COUNT)])


@pytest.mark.parametrize("values", [
    lambda time: (900.0 - 3.0 * time, 2.0, 1.0), lambda time: (1e-6 * round(10.0 * time % 3), 0.0, 1e-3 * (time % 2)),
])  # fmt: skip
@pytest.mark.parametrize("period", [0.1, 0.3])
def test_two_publishers_in_one_channel_are_refused(
    tmp_path: Path, values: Callable[[float], tuple[float, float, float]], period: float
) -> None:
    ours = [(*row[:3], 0) for row in real()]
    with pytest.raises(InputError, match="two publishers in one channel: its values jump away and back"):
        read_log(write(tmp_path / "log.mcap", ours + others(values, 0.03, period)))


@pytest.mark.parametrize("constant", [False, True])
@pytest.mark.parametrize("late", [0.0, 0.03])
def test_two_publishers_of_one_reading_are_seen_by_their_clocks(tmp_path: Path, late: float, constant: bool) -> None:
    """Where nothing but the torque differs."""
    rows = real()
    rows += [
        (1, time + late, state(time + late, (angle(time), 0.5, 90.0 if constant else 3000.0 + torque(time))), 0)
        for _, time, _, _ in real()
    ]
    path = write(tmp_path / "log.mcap", [(*row[:3], 0) for row in rows])
    with pytest.raises(InputError, match="two publishers in one channel: its values jump away and back"):
        read_log(path)


@pytest.mark.parametrize("column", [1, 2])
def test_a_reading_that_swings_at_half_the_rate_is_kept(tmp_path: Path, column: int) -> None:
    rows = []
    for step in range(3 * COUNT):
        values = [angle(0.1 * step), 0.5, torque(0.1 * step)]
        values[column] += (3000.0 if column == 2 else 0.3) * (-1) ** step + 0.01 * np.sin(step)
        rows.append((1, 0.1 * step, state(0.1 * step, tuple(values)), 0))  # type: ignore[arg-type]
    log = read_log(write(tmp_path / "log.mcap", rows))
    assert log.notes == () and log.top_drive is not None and len(log.top_drive.time) == 3 * COUNT


def test_noise_of_a_parked_drive_is_one_publisher(tmp_path: Path) -> None:
    """It turned before; then its encoder flickers between two steps in every fifth sample."""
    rows = []
    for step in range(3 * COUNT):
        turned = 0.5 * min(step, 20) + (0.0004 if step > 20 and step % 5 == 0 else 0.0)
        rows.append((1, 0.1 * step, state(0.1 * step, (turned, 0.0, torque(0.1 * step))), 0))
    assert len(read_log(write(tmp_path / "log.mcap", rows)).top_drive.time) == 3 * COUNT


def test_sequence_numbers_tell_publishers_apart(tmp_path: Path) -> None:
    other = [(1, time + 0.03, state(time + 0.03, (900.0 - 3.0 * time, 2.0, 1.0)), 5000 + step)
             for step, (_, time, _, _) in enumerate(real())]  # fmt: skip
    with pytest.raises(InputError, match="two publishers send different values"):
        read_log(write(tmp_path / "log.mcap", real() + other))


def test_runs_in_channels_of_their_own_are_split(tmp_path: Path) -> None:
    second = [(2, time, state(time, (-angle(time) - 300.0, 0.0, 1.0)), step) for _, time, _, step in real()]
    path = write(tmp_path / "log.mcap", real() + second, sort=False)
    with pytest.raises(InputError, match="two runs in one log"):
        read_log(path)
    written, _ = recover(path, tmp_path / "run.mcap")
    assert [log.messages for log in written] == [COUNT, COUNT]
    check_real(read_log(written[0].path))


def test_quantities_of_two_publishers_with_equal_stamps_are_joined(tmp_path: Path) -> None:
    rows = [row for time in (0.1 * step for step in range(COUNT)) for row in (
        (1, time, cdr.encode_joint_state(stamp(time), "top_drive", angle(time), None, None), 0),
        (1, time, cdr.encode_joint_state(stamp(time), "top_drive", None, None, torque(time)), 0))]  # fmt: skip
    log = read_log(write(tmp_path / "log.mcap", rows))
    assert log.top_drive is not None
    np.testing.assert_allclose(log.top_drive.position, [angle(0.1 * step) for step in range(COUNT)])
    np.testing.assert_allclose(log.top_drive.effort, [torque(0.1 * step) for step in range(COUNT)])


def joints(time: float, names: list[str], arrays: list[list[float]]) -> bytes:
    """A JointState of any joints, by hand."""
    packer = cdr._Packer()
    packer.put(JOINT_STATE.replace("/msg/", "/"), ((divmod(stamp(time), 10**9), ""), names, *arrays))
    return cdr.struct.pack(packer.format, *packer.values)


def joint_rows(names: list[str], columns: list[int]) -> list[Row]:
    """Block, top drive and pump in one message; `columns`: which of them, in which order."""
    made = []
    for step in range(COUNT):
        time = 0.1 * step
        every = [(0.01 * step, 0.1, 9e5), (angle(time), 0.5, torque(time)), (0.0, 12.0, 0.0)]
        arrays = [[every[column][k] for column in columns] for k in range(3)]
        made.append((1, time, joints(time, names, arrays), step))
    return made


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_log(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(("names", "columns", "why"), [
    ([], [0, 1], "2 joints without names: which is top_drive is unknown"),
    ([], [0, 1, 2], "3 joints without names"),
    (["a", "b"], [0, 1], "joints a, b, none named top_drive"),
    (["top_drive"], [0, 1], r"1 joint names (top_drive) for 2 values"),
    (["top_drive", "block", "mud_pump"], [0, 1], "3 joint names"),
    (["a", "b", "c"], [0, 1], "joints a, b, c, none named top_drive"),
    (["top_drive", "top_drive"], [0, 1], "several named top_drive"),
    (["block"], [0], "joint block, not top_drive"),
])  # fmt: skip
def test_a_joint_that_cannot_be_told_is_refused(
    tmp_path: Path, names: list[str], columns: list[int], why: str
) -> None:
    message = refusal(write(tmp_path / "log.mcap", joint_rows(names, columns)))
    assert why in message and "--topics" in message


@pytest.mark.parametrize(("names", "columns"), [(["block", "top_drive"], [0, 1]), (["rotary"], [1]), ([], [1])])
def test_a_joint_that_can_be_told_is_read(tmp_path: Path, names: list[str], columns: list[int]) -> None:
    check_real(read_log(write(tmp_path / "log.mcap", joint_rows(names, columns))))


def test_joints_of_one_topic_are_found_by_name(tmp_path: Path) -> None:
    rows = joint_rows(["block", "top_drive", "mud_pump"], [0, 1, 2])
    log = read_log(write(tmp_path / "log.mcap", rows, "/rig/joint_states"))
    check_real(log, "/rig/joint_states: holds the joints top_drive, block, mud_pump")
    assert log.draw_works is not None and log.mud_pump is not None
    assert set(log.draw_works.effort) == {9e5} and set(log.mud_pump.velocity) == {12.0}


def test_joints_of_other_names_need_a_map(tmp_path: Path) -> None:
    rows = joint_rows(["hoist", "rotary", "pump_1"], [0, 1, 2])
    path = write(tmp_path / "log.mcap", rows, "/joint_states")
    assert "/joint_states: 100 unreadable messages: joints hoist, rotary, pump_1 (needs " in refusal(path)
    topics = tmp_path / "topics.yaml"
    topics.write_text("top_drive: {topic: /joint_states, joint: rotary}\n"
                      "draw_works: {topic: joint_states, joint: 0}\n")  # fmt: skip
    log = read_log(path, topics=topics)
    check_real(log)
    assert log.draw_works is not None and set(log.draw_works.effort) == {9e5}


def test_unreadable_joints_are_the_reason_beside_readable_topics(tmp_path: Path) -> None:
    """A hook load of the rig's own topic is read; why there is no top drive is said wherever one is needed."""
    path = tmp_path / "log.mcap"
    with LogWriter(path) as writer:
        for step in range(COUNT):
            arrays = [[angle(0.1 * step), 0.0]] * 3
            writer.message("joint_states", JOINT_STATE, joints(0.1 * step, ["rotary", "pump_1"], arrays), 0, step)
            writer.joint_state("draw_works/joint_states", START_NS / 1e9 + 0.1 * step, "block", 0.0, 0.0, 9e5)
    log = read_log(path)
    why = "/joint_states: 100 unreadable messages: joints rotary, pump_1 (needs top_drive or block or mud_pump); say"
    assert why in log.lack_of_top_drive("drives the plant")
    assert any(note.startswith(why) for note in log.notes)


def test_an_array_of_another_length_is_left_out_and_said(tmp_path: Path) -> None:
    rows = [
        (1, 0.1 * step, joints(0.1 * step, ["block", "top_drive"], [[0.0, angle(0.1 * step)], [0.1, 0.5], [9e5]]), step)
        for step in range(COUNT)
    ]
    log = read_log(write(tmp_path / "log.mcap", rows))
    assert log.top_drive is not None and np.isnan(log.top_drive.effort).all()
    why = "1 values of effort for 2 joints, of which each needs one: left out"
    assert log.why_unreadable("top_drive") == f"; /top_drive/joint_states: {why}"
    assert f"/top_drive/joint_states: 100 messages: {why}" in log.notes


@pytest.mark.parametrize(("text", "why"), [
    ("", "no topics; give lines such as"),
    ("hookload: /hook", "hookload: no such channel of a rig; use one of top_drive, "),
    ("top_drive: 3", "top_drive: give the name of its topic"),
    ("top_drive: {topic: /a, joints: b}", "top_drive: unknown key joints; use topic, joint, channel"),
    ("top_drive: {topic: /a, joint: [b]}", "top_drive: joint: ['b'] is neither a name nor an index"),
    ("top_drive: {topic: /a, channel: b}", "top_drive: channel: 'b' is no channel"),
    ("standpipe_pressure: {topic: /a, joint: b}", "standpipe_pressure: joint: a FluidPressure has no joints"),
    ("{top_drive: /a, draw_works: /a}", "are the same topic and joint"),
    ("top_drive: /absent", "top_drive: no sample in topic /absent, which the topics file names"),
    ("top_drive: {topic: /joint_states, joint: saw}", "joints hoist, rotary, none named saw"),
    ("top_drive: {topic: /joint_states, joint: 7}", "2 joints, none with index 7"),
    ("standpipe_pressure: /joint_states", "its type is sensor_msgs/msg/JointState, not sensor_msgs/msg/FluidPressure"),
])  # fmt: skip
def test_a_wrong_topics_file_is_one_line(tmp_path: Path, text: str, why: str) -> None:
    write(tmp_path / "log.mcap", joint_rows(["hoist", "rotary"], [0, 1]), "/joint_states")
    (tmp_path / "topics.yaml").write_text(text)
    with pytest.raises(InputError) as caught:
        read_log(tmp_path / "log.mcap", topics=tmp_path / "topics.yaml")
    assert why in str(caught.value) and "\n" not in str(caught.value)
