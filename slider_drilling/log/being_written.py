"""Whether a program is writing to a file right now, so that a log without an end is not called damaged."""

from __future__ import annotations

import os
from pathlib import Path


def is_being_written(path: Path) -> bool:
    """Whether a process of this user holds the file open for writing. False where the system does not tell."""
    try:
        own = path.stat()
        processes = [entry for entry in Path("/proc").iterdir() if entry.name.isdigit()]
    except OSError:
        return False
    return any(_writes(process, own) for process in processes)


def _writes(process: Path, file: os.stat_result) -> bool:
    """Whether a process, given by its folder in /proc, has the file open for writing."""
    try:
        for descriptor in (process / "fd").iterdir():
            if not os.path.samestat(descriptor.stat(), file):
                continue
            for line in (process / "fdinfo" / descriptor.name).read_text().splitlines():
                if line.startswith("flags:") and int(line.split()[1], 8) & (os.O_WRONLY | os.O_RDWR):
                    return True
    except (OSError, ValueError):
        return False  # another user's process, or one that has ended
    return False
