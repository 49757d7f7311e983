"""Recognises the clock of a stamp that is not the rig's."""

from __future__ import annotations

import time

MAX_OFFSET = 3600.0  # s between a stamp and the clock that it is taken to come from
SET_BACK = 1.0  # s by which the rig's clock goes back when the rig has started anew
MAX_SAMPLE_AGE = 5.0  # s between a sample's stamp and the time at which it comes, with clocks that agree


def describe_clock(stamp_ns: int) -> str:
    """Which clock a stamp, ns, probably comes from, and what to do about it."""
    if stamp_ns == 0:
        return "it has no stamp (0); give it that of the sample it answers"
    if abs(stamp_ns - time.time_ns()) < MAX_OFFSET * 1e9:
        return "that is the wall's clock; set use_sim_time on its node"
    if abs(stamp_ns - time.monotonic_ns()) < MAX_OFFSET * 1e9:
        return "that is this machine's uptime; stamp commands with the sample that they answer"
    return "that is another clock than this rig's; stamp commands with the sample that they answer"


def is_on_clock(stamp_ns: int, now_ns: int) -> bool:
    """Whether a sample that comes now was stamped by the clock that shows now_ns."""
    return abs(now_ns - stamp_ns) <= MAX_SAMPLE_AGE * 1e9


def clock_offset_message(stamp_ns: int, now_ns: int, use_sim_time: bool) -> str:
    """What is wrong with the stamps of samples that come now, and what to do; "" if nothing is."""
    if is_on_clock(stamp_ns, now_ns):
        return ""
    offset = (stamp_ns - now_ns) / 1e9
    what = f"the rig's stamps are {abs(offset):.0f} s {'ahead of' if offset > 0.0 else 'behind'} this node's clock"
    if use_sim_time and now_ns == 0:
        return f"{what}: no /clock comes; set use_sim_time to false, or start what publishes the rig's time"
    if use_sim_time:
        return f"{what}: /clock belongs to another rig, or stands; remap it to this rig's"
    return f"{what}: synchronise the clocks of rig and controller (NTP), or set use_sim_time for a simulated rig"
