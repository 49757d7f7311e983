"""The most memory that this process has held."""

from __future__ import annotations

import sys
from pathlib import Path


def peak_bytes() -> int | None:
    """Peak memory of this process, bytes; None if the system does not report it.

    On Linux not from `getrusage`, which includes the parent's memory at the time of the fork.
    """
    try:
        lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    except OSError:  # no such file outside Linux
        return _peak_of_usage()
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM")), None)


def _peak_of_usage() -> int | None:
    if sys.platform == "win32":
        return None
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
