"""Recognises the clock of a stamp that is not the rig's."""

from __future__ import annotations

import time

MAX_OFFSET = 3600.0  # s between a stamp and the clock that it is taken to come from
SET_BACK = 1.0  # s by which the rig's clock goes back when the rig has started anew
REPEAT_AFTER = 300.0  # s of wall time after which a fault of the clock that lasts is said again
CHANGED_FACTOR = 2.0  # of the offset since it was said last, either way, for a fault that has changed
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


class ClockFaultReports:
    """When a fault of the clock is said: at first, when it has changed, and after minutes.

    Args:
        now: Wall time from which on faults are watched, s.
    """

    def __init__(self, now: float) -> None:
        self._last = now  # when a fault was said, or watching began
        self._said: tuple[str, float] | None = None  # advice and offset, s

    def is_due(self, message: str, offset: float, now: float, min_period: float) -> bool:
        """Whether to say a fault now; the answer True counts as said.

        Args:
            message: Of `clock_offset_message`.
            offset: Stamp minus clock, s.
            now: Wall time, s.
            min_period: Between reports, and before the first one: clocks may come late at the start, s.
        """
        if not message:
            self._said = None
            return False
        elapsed = now - self._last
        if elapsed <= min_period or not (elapsed > REPEAT_AFTER or self._has_changed(message, offset)):
            return False
        self._last, self._said = now, (_advice(message), offset)
        return True

    def _has_changed(self, message: str, offset: float) -> bool:
        if self._said is None:
            return True
        advice, before = self._said
        # An offset of the other sign has a negative ratio. Neither is 0: that would be no fault.
        return advice != _advice(message) or not 1.0 / CHANGED_FACTOR < offset / before < CHANGED_FACTOR


def _advice(message: str) -> str:
    """The part of a message that does not change with the offset."""
    return message.partition(": ")[2]
