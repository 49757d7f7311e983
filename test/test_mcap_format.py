"""Whatever the MCAP format allows is read without a word of damage: padding, no statistics, other orders."""

import struct
import zlib
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer

from slider_drilling.log import read_log
from slider_drilling.log.info import log_info
from slider_drilling.log.mcap_reader import McapReader
from slider_drilling.log.recover import recover
from slider_drilling.messages import cdr
from slider_drilling.messages.topics import JOINT_STATE

MAGIC = b"\x89MCAP0\r\n"
RIG = b"schema: x\n"
KINDS = {"NoData": (0, 0, 0), "OneAttachment": (0, 1, 0), "OneMetadata": (0, 0, 1), "OneMessage": (1, 0, 0),
         "OneSchemalessMessage": (1, 0, 0), "TenMessages": (10, 0, 0)}  # fmt: skip


def contents(path: Path) -> tuple[int, int, int]:
    """Numbers of messages, attachments and metadata records; no note is allowed."""
    reader = McapReader(path)
    messages = sum(1 for _ in reader.messages())
    assert reader.notes == [], path.name
    return messages, len(reader.attachments), len(reader.metadata)


def test_conformance_files_are_read_without_a_note(shared_data: Path) -> None:
    files = sorted((shared_data / "mcap_conformance").glob("*.mcap"))
    assert len(files) == 416
    wrong = [file.name for file in files if contents(file) != KINDS[file.stem.partition("-")[0]]]
    assert wrong == []
    assert [file.name for file in files if log_info(file).notes] == []


def write(path: Path, count: int = 30, **options: object) -> None:
    """A run of one topic, with its rig file, by the mcap library."""
    with path.open("wb") as file:
        writer = Writer(file, **options)  # type: ignore[arg-type]
        writer.start("ros2", "other recorder")
        schema = writer.register_schema(JOINT_STATE, "ros2msg", b"")
        channel = writer.register_channel("/top_drive/joint_states", "cdr", schema)
        writer.add_attachment(7, 8, "rig.yaml", "application/yaml", RIG)
        writer.add_metadata("other", {"key": "value"})
        for step in range(count):
            now = 1_000_000_000 + step * 100_000_000
            data = cdr.encode_joint_state(now, "top_drive", 0.1 * step, 1.0, 5.0)
            writer.add_message(channel, now, data, now, step)
        writer.finish()


@pytest.mark.parametrize("missing", [
    "use_statistics", "use_summary_offsets", "repeat_channels", "repeat_schemas", "enable_data_crcs", "enable_crcs",
    "use_chunking",
])  # fmt: skip
def test_what_writers_may_leave_out_is_not_missed(tmp_path: Path, missing: str) -> None:
    write(tmp_path / "log.mcap", **{missing: False})
    log = read_log(tmp_path / "log.mcap")
    assert log.notes == () and log.rig_text == RIG.decode()
    assert log.top_drive is not None and len(log.top_drive.time) == 30


def pad(data: bytes, opcode: int, padding: bytes) -> bytes:
    """The file with bytes behind the fields of every record of a kind; without checksums over whole sections."""
    out, at = MAGIC, len(MAGIC)
    sections: dict[int | str, int] = {}
    while at < len(data) - len(MAGIC):
        code, length = struct.unpack_from("<BQ", data, at)
        content = data[at + 9 : at + 9 + length]
        sections.setdefault(code, len(out))
        if code == Opcode.CHUNK:
            packed = pad_chunk(content, opcode, padding)
            content = packed + (padding if opcode == Opcode.CHUNK else b"")
        elif code == Opcode.DATA_END:
            content = struct.pack("<I", 0)
            sections["summary"] = len(out) + 13 + (len(padding) if opcode == code else 0)
        elif code == Opcode.CHUNK_INDEX:
            content = content[:16] + struct.pack("<Q", sections[Opcode.CHUNK]) + content[24:]
        elif code == Opcode.FOOTER:
            content = struct.pack("<QQI", sections["summary"], 0, 0)
        if code == opcode and code != Opcode.CHUNK:
            content += padding
        out += struct.pack("<BQ", code, len(content)) + content
        at += 9 + length
    return out + MAGIC


def pad_chunk(content: bytes, opcode: int, padding: bytes) -> bytes:
    """The same within a chunk that is not compressed."""
    records, at, out = content[40:], 0, b""
    while at < len(records):
        code, length = struct.unpack_from("<BQ", records, at)
        record = records[at + 9 : at + 9 + length] + (padding if code == opcode else b"")
        out += struct.pack("<BQ", code, len(record)) + record
        at += 9 + length
    return content[:16] + struct.pack("<QIIQ", len(out), zlib.crc32(out), 0, len(out)) + out


@pytest.mark.parametrize("opcode", [code for code in Opcode if code != Opcode.MESSAGE], ids=lambda code: code.name)
@pytest.mark.parametrize("padding", [b"\x01", bytes(3), b"\xa5" * 29])
def test_padding_behind_any_record_is_skipped(tmp_path: Path, opcode: int, padding: bytes) -> None:
    path = tmp_path / "log.mcap"
    write(path, compression=CompressionType.NONE)
    path.write_bytes(pad(path.read_bytes(), opcode, padding))
    assert contents(path) == (30, 1, 1)
    log = read_log(path)
    assert log.notes == () and log.rig_text == RIG.decode()


def test_recover_keeps_a_padded_attachment(tmp_path: Path) -> None:
    write(tmp_path / "log.mcap", compression=CompressionType.NONE)
    padded = pad((tmp_path / "log.mcap").read_bytes(), Opcode.ATTACHMENT, b"\x01\x02")
    (tmp_path / "padded.mcap").write_bytes(padded)
    _, notes = recover(tmp_path / "padded.mcap", tmp_path / "whole.mcap")
    reader = McapReader(tmp_path / "whole.mcap")
    assert sum(1 for _ in reader.messages()) == 30 and notes == []
    assert [(one.name, one.data, one.create_time, one.log_time) for one in reader.attachments] == [
        ("rig.yaml", RIG, 7, 8)
    ]
