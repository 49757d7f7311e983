"""What a damaged, doubled or hostile log still holds is read, and what it does not hold any more is said."""

import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.records import ChunkIndex
from mcap.writer import CompressionType, Writer

from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, RigLog, read_log
from slider_drilling.messages import cdr
from slider_drilling.messages.message_types import MESSAGE_TYPES
from slider_drilling.messages.topics import JOINT_STATE

STEPS = 1500
SEC = 10**9
DRIVE = "/top_drive/joint_states"


def write(path: Path, steps: range = range(STEPS), start: float = 1000.0) -> bytes:
    """A log of several chunks and two channels, the value of every sample telling its place."""
    path.unlink(missing_ok=True)
    with LogWriter(path, rig_text="schema: x") as writer:
        for step in steps:
            writer.joint_state("top_drive/joint_states", start + step * 0.1, "top_drive", step, 2.0 * step, 3.0 * step)
            writer.fluid_pressure("standpipe_pressure", start + step * 0.1, 1e6 + step, 1.0)
    return path.read_bytes()


def foreign(path: Path, rows: list[tuple[int, bytes]], chunked: bool = True, data_crc: bool = False) -> None:
    """The top drive's messages (log time ns, bytes) as the mcap package's own writer puts them."""
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=chunked, chunk_size=4000, compression=CompressionType.ZSTD,
                        enable_data_crcs=data_crc)
        writer.start("ros2")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", MESSAGE_TYPES[JOINT_STATE].definition.encode())
        channel = writer.register_channel(DRIVE, "cdr", schema)
        for log_time, data in rows:
            writer.add_message(channel, log_time, data, log_time)
        writer.finish()


def drive(stamp_ns: int, value: float = 1.0) -> bytes:
    return cdr.encode_joint_state(stamp_ns, "top_drive", value, 0.0, 0.0)


def chunks_of(path: Path) -> list[ChunkIndex]:
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return summary.chunk_indexes


def check(log: RigLog) -> int:
    """How many samples there are, all of them right."""
    assert log.top_drive is not None
    step = np.round((log.start - 1000.0) * 10.0 + log.top_drive.time * 10.0)
    np.testing.assert_array_equal(log.top_drive.position, step)
    np.testing.assert_array_equal(log.top_drive.effort, 3.0 * step)
    return len(step)


def test_a_damaged_first_chunk_loses_no_channel(tmp_path: Path) -> None:
    """The channels are described in the first chunk; the summary describes them too."""
    path = tmp_path / "run.mcap"
    whole = write(path)
    chunks = chunks_of(path)
    assert len(chunks) > 4
    damaged = bytearray(whole)
    damaged[chunks[0].chunk_start_offset + chunks[0].chunk_length // 2] ^= 1
    path.write_bytes(damaged)
    log = read_log(path)
    assert check(log) > STEPS * (len(chunks) - 2) / len(chunks)
    assert log.standpipe_pressure is not None and log.top_drive is not None
    assert abs(len(log.standpipe_pressure.time) - len(log.top_drive.time)) <= 1
    assert any("a damaged chunk was left out: a gap of" in note for note in log.notes)


def test_messages_of_lost_channels_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    whole = write(path)
    chunks = chunks_of(path)
    damaged = bytearray(whole[: chunks[-1].chunk_start_offset])
    damaged[chunks[0].chunk_start_offset + chunks[0].chunk_length // 2] ^= 1
    path.write_bytes(damaged)
    with pytest.raises(InputError, match=r"\d+ messages of channels whose description is lost .*ids 1, 2"):
        read_log(path)


def test_swapped_chunks_lose_nothing(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    whole = write(path)
    chunks = chunks_of(path)
    ends = [chunk.chunk_start_offset + chunk.chunk_length + chunk.message_index_length for chunk in chunks]
    for one, two in ((0, 1), (1, 3), (0, len(chunks) - 1)):
        first, second = chunks[one].chunk_start_offset, chunks[two].chunk_start_offset
        path.write_bytes(whole[:first] + whole[second : ends[two]] + whole[ends[one] : second]
                         + whole[first : ends[one]] + whole[ends[two] :])
        log = read_log(path)
        assert check(log) == STEPS
        assert any("put in the order of their times" in note for note in log.notes)


@pytest.mark.parametrize("chunked", [False, True])
def test_checksum_over_the_data(tmp_path: Path, chunked: bool) -> None:
    """Without chunks nothing else tells that a value is not the one that was written."""
    path = tmp_path / "run.mcap"
    foreign(path, [(k * SEC, drive(k * SEC, k)) for k in range(50)], chunked, data_crc=True)
    assert read_log(path).notes == ()
    whole = path.read_bytes()
    if chunked:
        # Within an index of messages, which no reading needs.
        at = chunks_of(path)[0].chunk_start_offset + chunks_of(path)[0].chunk_length + 20
    else:
        at = whole.index(drive(25 * SEC, 25)) + len(drive(0)) - 20
    path.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
    log = read_log(path)
    assert log.top_drive is not None and len(log.top_drive.time) == 50
    what = "the messages are whole, its notes may not be" if chunked else "some of them may be wrong"
    assert any(what in note for note in log.notes)


def test_logs_one_after_another_are_all_read(tmp_path: Path) -> None:
    first, second = write(tmp_path / "a.mcap", range(700)), write(tmp_path / "b.mcap", range(700, STEPS))
    (tmp_path / "both.mcap").write_bytes(first + second)
    log = read_log(tmp_path / "both.mcap")
    assert check(log) == STEPS
    assert any("holds 2 logs one after another" in note for note in log.notes)
    (tmp_path / "both.mcap").write_bytes(first + first)
    with pytest.raises(InputError, match=r"step back by 69\.9 s.*two runs in one log; `slider-drilling recover`"):
        read_log(tmp_path / "both.mcap")
    (tmp_path / "both.mcap").write_bytes(first[:-5000] + second)
    assert check(read_log(tmp_path / "both.mcap")) > STEPS - 400


@pytest.mark.parametrize("what", ["zstd", "honest zstd"])
def test_a_bomb_is_not_opened(tmp_path: Path, what: str) -> None:
    """A chunk of some kB that unpacks to gigabytes: left out, in little memory."""
    path = tmp_path / "run.mcap"
    whole = write(path)
    first = chunks_of(path)[0].chunk_start_offset
    size = 3_000_000_000
    packer = zstandard.ZstdCompressor(level=1).compressobj(size=size)
    packed = b"".join(packer.compress(bytes(10_000_000)) for _ in range(300)) + packer.flush()
    assert len(packed) < 1_000_000
    claimed = size if what == "honest zstd" else 1000
    content = struct.pack("<QQQI", 0, 0, claimed, 0) + b"\x04\x00\x00\x00zstd" + struct.pack("<Q", len(packed)) + packed
    path.write_bytes(whole[:first] + b"\x06" + struct.pack("<Q", len(content)) + content + whole[first:])
    program = ("import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30));"
               "from slider_drilling.log import read_log; log = read_log(sys.argv[1]);"
               "print(len(log.top_drive.time)); print(*log.notes)")
    done = subprocess.run([sys.executable, "-c", program, str(path)], cwd=Path(__file__).parents[1],
                          capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    count, notes = done.stdout.split("\n", 1)
    assert int(count) == STEPS
    assert ("over the limit of 268 MB" if what == "honest zstd" else "a damaged chunk") in notes


def stamped(change: Callable[[list[int]], None], logged: list[int] | None = None) -> list[tuple[int, bytes]]:
    stamps = [1_700_000_000 * SEC + k * SEC // 10 for k in range(400)]
    times = list(stamps) if logged is None else logged
    change(stamps)
    return [(time, drive(stamp, k)) for k, (time, stamp) in enumerate(zip(times, stamps, strict=True))]


YEAR, DAY = 365 * 86_400 * SEC, 86_400 * SEC


@pytest.mark.parametrize("at", [0, 1, 200, 398, 399])
@pytest.mark.parametrize("change", [lambda stamp: 0, lambda stamp: stamp + YEAR, lambda stamp: stamp - YEAR,
                                    lambda stamp: stamp + DAY, lambda stamp: 7 * SEC],
                         ids=["zero", "a year ahead", "a year back", "a day ahead", "since boot"])
def test_one_wrong_stamp_is_left_out(tmp_path: Path, at: int, change: Callable[[int], int]) -> None:
    def spoil(stamps: list[int]) -> None:
        stamps[at] = change(stamps[at])

    path = tmp_path / "run.mcap"
    foreign(path, stamped(spoil))
    log = read_log(path)
    assert log.top_drive is not None
    assert log.top_drive.position.tolist() == [k for k in range(400) if k != at]
    assert log.top_drive.time[-1] < 40.0
    assert len(log.notes) == 1 and DRIVE in log.notes[0] and "left out" in log.notes[0]


def test_a_clock_that_was_set_is_refused(tmp_path: Path) -> None:
    """From 1970 to today in the middle of a log: what comes of it would be decades long."""
    def spoil(stamps: list[int]) -> None:
        stamps[:200] = [k * SEC // 10 for k in range(1, 201)]

    foreign(tmp_path / "run.mcap", stamped(spoil))
    with pytest.raises(InputError, match=r"stamps leap ahead by 17000000\d\d\.\d s .*recover. splits it"):
        read_log(tmp_path / "run.mcap")


def test_other_channels_by_another_clock_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path) as writer:
        for k in range(100):
            writer.joint_state("top_drive/joint_states", 1e9 + k * 0.1, "top_drive", k, 0.0, 0.0)
            logged = 1e9 + k * 0.1
            writer.joint_state("mud_pump/joint_states", 5.0 + k * 0.1, "mud_pump", velocity=1.0, log_time_s=logged)
            writer.joint_state("tool_face/target", 1e9 - 40_000.0, "tool_face", 0.5, log_time_s=1e9 + k * 0.1)
    log = read_log(path)
    assert log.top_drive is not None and len(log.top_drive.time) == 100 and log.mud_pump is None
    assert log.tool_face_target is not None and log.tool_face_target.time.tolist() == [-40_000.0]
    assert any("/mud_pump/joint_states: stamped -999999995 s off the other topics" in note for note in log.notes)


def test_gaps_and_late_messages_are_no_outliers(tmp_path: Path) -> None:
    """An hour's gap at any place, and messages that arrive out of order: nothing but a gap."""
    for first in (1, 3, 200, 397, 399):
        def spoil(stamps: list[int], first: int = first) -> None:
            stamps[first:] = [stamp + 3_000 * SEC for stamp in stamps[first:]]
            stamps[100:106] = [stamps[k] for k in (103, 101, 100, 105, 102, 104)]

        rows = stamped(lambda stamps: None)
        stamps = [time for time, _ in rows]
        spoil(stamps)
        foreign(tmp_path / "run.mcap", [(max(stamps[: k + 1]), drive(stamp, k)) for k, stamp in enumerate(stamps)])
        log = read_log(tmp_path / "run.mcap")
        assert log.top_drive is not None and len(log.top_drive.time) == 400 and log.notes == ()


def test_log_times_beyond_any_clock(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    foreign(path, [(2**64 - 1 if k == 5 else k * SEC, drive(k * SEC, k)) for k in range(30)])
    log = read_log(path)
    assert log.top_drive is not None and len(log.top_drive.time) == 29
    assert any("1 messages logged after the year 2262" in note for note in log.notes)


def test_what_a_terminal_would_obey_is_written_out(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    evil = "\x1b]0;owned\x07\x1b[2J\u202e"
    with LogWriter(path, notes=f"two\nlines {evil}", recorded_by=evil) as writer:
        writer.joint_state(f"{evil}/top_drive/joint_states", 0.0, "top_drive", 0.0)
        writer.joint_state(f"{evil}/standpipe_pressure", 0.0, "x", 0.0)
    log = read_log(path)
    said = [*log.notes, *log.metadata.values(), log.source]
    assert log.notes and log.metadata["notes"].startswith("two\nlines \\x1b]0;owned\\x07")
    assert not any(one in text for text in said for one in "\x1b\x07\u202e")
    with pytest.raises(InputError) as caught:
        read_log(path, namespace=f"other{evil}")
    assert "\x1b" not in str(caught.value) and "\\x1b[2J" in str(caught.value)


def test_one_flipped_byte_at_the_front_is_borne(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    whole = write(path)
    for at in range(60):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x10]) + whole[at + 1 :])
        log = read_log(path)
        assert check(log) == STEPS and log.notes


def test_many_layouts_of_one_type(tmp_path: Path) -> None:
    """Every message with a frame of its own, some of them unreadable: read one by one, none mixed up."""
    rows = []
    for k in range(300):
        frame = f"frame {k % 40}".encode() + b"\0"
        data = bytearray(struct.pack("<4siII", b"\0\1\0\0", k, 0, len(frame)) + frame)
        data += b"\0" * (-(len(data) - 4) % 4) + struct.pack("<II10s", 1, 10, b"top_drive\0")
        data += b"\0" * (-(len(data) - 4) % 4)
        for value in (k, 2 * k, 3 * k):
            data += struct.pack("<I", 1)
            data += b"\xaa" * (-(len(data) - 4) % 8) + struct.pack("<d", value)
        rows.append((k * SEC, bytes(data) if k % 7 else bytes(data[:40])))
    foreign(tmp_path / "run.mcap", rows)
    log = read_log(tmp_path / "run.mcap")
    assert log.top_drive is not None
    expected = np.array([k for k in range(300) if k % 7])
    np.testing.assert_array_equal(log.top_drive.position, expected)
    np.testing.assert_array_equal(log.top_drive.effort, 3.0 * expected)
    assert any("43 unreadable messages" in note for note in log.notes)
