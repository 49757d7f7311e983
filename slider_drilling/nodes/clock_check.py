"""Names the clock that a stamp was taken from, where it is not the rig's."""

from __future__ import annotations

import time

NEAR = 3600.0  # s within which a stamp is taken to come from a clock; time zones and drift are no part of these two


def describe_clock(stamp_ns: int) -> str:
    """What a stamp of another clock looks like, and what to do about it; ns, compared with the clocks of now."""
    if stamp_ns == 0:
        return "it has no stamp (0); give it that of the sample it answers"
    if abs(stamp_ns - time.time_ns()) < NEAR * 1e9:
        return "that is the wall's clock; set use_sim_time on its node"
    if abs(stamp_ns - time.monotonic_ns()) < NEAR * 1e9:
        return "that is this machine's uptime; stamp commands with the sample that they answer"
    return "that is another clock than this rig's; stamp commands with the sample that they answer"
