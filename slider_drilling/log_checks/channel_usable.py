"""Check that a channel carries information: neither too short, nor stuck, nor saturated."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array, Channel

# A channel is stuck if one value fills this share of it, saturated if this share of the samples is at a limit.
_MAX_REPEATED, _MAX_AT_LIMIT = 0.5, 0.02
# This many equal samples in a row at a limit are saturation; fewer may be a peak.
_MAX_RUN_AT_LIMIT = 5
_MIN_SAMPLES = 12


def why_unusable(channel: Channel) -> str | None:
    """Why a channel cannot be fitted, None if it can."""
    values = channel.measured
    if values.size < _MIN_SAMPLES:
        return f"only {values.size} samples"
    if np.ptp(values) == 0.0:
        return "stuck: it never changes"
    if channel.period is not None or channel.resolution > 0.0:
        return None
    longest = longest_repeat(values)
    if longest > _MAX_REPEATED * values.size:
        return f"stuck: the same value for {100.0 * longest / values.size:.0f} % of the log"
    # Before the rig first moves and after it last does, a sound channel is constant too.
    changed = np.flatnonzero(np.diff(values) != 0.0)
    values = values[changed[0] + 1 : changed[-1] + 1]
    if values.size < _MIN_SAMPLES:
        return f"only {values.size} samples that change"
    for limit, name in ((values.max(), "upper"), (values.min(), "lower")):
        share = float(np.mean(values == limit))
        # All other samples are made unequal, so that only runs at the limit count.
        at_limit = np.where(values == limit, 1.0, np.arange(values.size) + 2.0)
        if share > _MAX_AT_LIMIT and longest_repeat(at_limit) > _MAX_RUN_AT_LIMIT:
            return f"saturated: {100.0 * share:.0f} % of the samples at its {name} limit {limit:g} {channel.unit}"
    return None


def longest_repeat(values: Array) -> int:
    """Length of the longest stretch of equal samples."""
    changes = np.flatnonzero(np.diff(values) != 0.0)
    edges = np.concatenate([[-1], changes, [values.size - 1]])
    return int(np.max(np.diff(edges)))
