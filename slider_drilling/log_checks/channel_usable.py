"""Whether a channel can carry a diagnosis: stuck and saturated ones cannot."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array, Channel

# A channel is stuck when this share of its samples repeats the one before.
_STUCK = 0.5
_SATURATED = 0.02
_LEAST_SAMPLES = 12


def why_unusable(channel: Channel) -> str | None:
    """Why a channel cannot be used, None when it can."""
    values = channel.measured
    if values.size < _LEAST_SAMPLES:
        return f"only {values.size} samples"
    if np.ptp(values) == 0.0:
        return "stuck: it never changes"
    if channel.period is not None or channel.resolution > 0.0:
        return None
    longest = longest_repeat(values)
    if longest > _STUCK * values.size:
        return f"stuck: the same value for {100.0 * longest / values.size:.0f} % of the log"
    # A rig that has not moved yet shows one value too: only what lies between the first and the last change counts.
    changed = np.flatnonzero(np.diff(values) != 0.0)
    values = values[changed[0] + 1 : changed[-1] + 1]
    if values.size < _LEAST_SAMPLES:
        return f"only {values.size} samples that change"
    for edge, name in ((values.max(), "upper"), (values.min(), "lower")):
        at_edge = float(np.mean(values == edge))
        if at_edge > _SATURATED and longest_repeat(np.where(values == edge, 1.0, np.arange(values.size) + 2.0)) > 5:
            return f"saturated: {100.0 * at_edge:.0f} % of the samples at its {name} limit {edge:g} {channel.unit}"
    return None


def longest_repeat(values: Array) -> int:
    """Length of the longest stretch of equal samples."""
    changes = np.flatnonzero(np.diff(values) != 0.0)
    edges = np.concatenate([[-1], changes, [values.size - 1]])
    return int(np.max(np.diff(edges)))
