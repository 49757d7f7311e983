"""Recognises the clock of a stamp that is not the rig's."""

from __future__ import annotations

import time

MAX_OFFSET = 3600.0  # s between a stamp and the clock that it is taken to come from


def describe_clock(stamp_ns: int) -> str:
    """Which clock a stamp, ns, probably comes from, and what to do about it."""
    if stamp_ns == 0:
        return "it has no stamp (0); give it that of the sample it answers"
    if abs(stamp_ns - time.time_ns()) < MAX_OFFSET * 1e9:
        return "that is the wall's clock; set use_sim_time on its node"
    if abs(stamp_ns - time.monotonic_ns()) < MAX_OFFSET * 1e9:
        return "that is this machine's uptime; stamp commands with the sample that they answer"
    return "that is another clock than this rig's; stamp commands with the sample that they answer"
