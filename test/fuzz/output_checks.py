"""Checks a command's output folder: no old file lost, no file half-written."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import slider_drilling as sd
from slider_drilling.errors import InputError
from slider_drilling.log import read_log

PNG_END = b"IEND\xaeB`\x82"


def contents(out: Path) -> dict[Path, bytes]:
    """The content of every file."""
    return {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}


def wrong_in(out: Path, before: dict[Path, bytes], allow_parts: bool) -> str:
    """The first file that was lost or is not whole; "" if there is none.

    before: contents of the folder before the command ran; allow_parts: whether hidden, unfinished files may remain.
    """
    for path in before:
        if not path.exists():
            return f"lost {path.name}"
    for path, content in sorted(contents(out).items()):
        if before.get(path) == content:
            continue
        if path.name.endswith(".part"):
            if allow_parts:
                continue
            return f"left {path.name}"
        wrong = _wrong_with(path, content)
        if allow_parts and "it holds no topics" in wrong:
            continue  # a recording that was killed before its first chunk
        if wrong:
            return f"{path.relative_to(out)}: {wrong}"
    return ""


def _wrong_with(path: Path, content: bytes) -> str:
    try:
        if path.suffix == ".json":
            json.loads(content)
        elif path.suffix == ".yaml" and "rig" in path.name:
            sd.load_rig(path)
        elif path.suffix == ".mcap":
            read_log(path)
    except (ValueError, InputError) as error:
        return f"cannot be read: {error}"
    whole = {
        ".html": lambda: content.rstrip().endswith(b"</html>"),
        ".png": lambda: content.endswith(PNG_END),
        ".csv": lambda: len({len(row) for row in csv.reader(content.decode().splitlines())}) == 1,
    }
    return "" if path.suffix not in whole or whole[path.suffix]() else "not whole"
