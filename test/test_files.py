"""Files are read and written as a whole, or refused in one line."""

import os
import stat
from pathlib import Path

import pytest

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import check_distinct, read_text, write_atomically
from slider_drilling.log import read_log


def test_file_is_written_atomically_with_usual_permissions(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("before")
    write_atomically(path, "µ".encode())
    plain = tmp_path / "plain"
    plain.touch()
    assert read_text(path, "page") == "µ"
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)
    assert sorted(os.listdir(tmp_path)) == ["page.html", "plain"]


def test_failed_write_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no-such/page\.html: cannot write this file: No such file or directory"):
        write_atomically(tmp_path / "no-such" / "page.html", b"")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="cannot write this file: Is a directory"):
        write_atomically(tmp_path / "folder", b"")
    assert os.listdir(tmp_path) == ["folder"]


def test_unreadable_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.yaml: no such rig file; check the path"):
        read_text(tmp_path / "a.yaml", "rig file")
    with pytest.raises(InputError, match="cannot read this rig file: Is a directory"):
        read_text(tmp_path, "rig file")
    (tmp_path / "b.yaml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="cannot read this rig file: not UTF-8 text"):
        read_text(tmp_path / "b.yaml", "rig file")


def test_byte_order_mark_is_dropped(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"\xef\xbb\xbft,x\n")
    assert read_text(tmp_path / "a.csv", "table") == "t,x\n"


def test_pipes_and_endless_files_are_refused(tmp_path: Path) -> None:
    pipe, device = tmp_path / "pipe", tmp_path / "device"
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="pipe: is a pipe, which may never end, and no survey; give a file"):
        read_text(pipe, "survey")
    with pytest.raises(InputError, match="device: longer than 100 MB, which no survey is"):
        read_text(device, "survey")
    for path in (pipe, device):
        check_distinct([path, path])
        with pytest.raises(InputError, match=f"{path.name}: is a pipe, a socket or a device; give a file"):
            read_log(path)
    # What a shell makes of <(command) is a pipe that somebody writes to.
    reading, writing = os.pipe()
    os.write(writing, b"text")
    os.close(writing)
    assert read_text(f"/dev/fd/{reading}", "survey") == "text"
    os.close(reading)
