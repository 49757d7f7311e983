"""One activity for each second of a log."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import uniform_filter1d

from slider_drilling.log.series import Array
from slider_drilling.rig_activities.bit_track import BitTrack, runs, without_short
from slider_drilling.rig_activities.surface_channels import Mask, SurfaceChannels

ROTATING, SLIDING, ROCKING = "rotating", "sliding", "rocking"
CONNECTION, TRIPPING, CIRCULATING, OFF_BOTTOM = "connection", "tripping", "circulating", "off bottom"
NOT_RECORDED = "not recorded"
KINDS = (ROTATING, SLIDING, ROCKING, CONNECTION, TRIPPING, CIRCULATING, OFF_BOTTOM, NOT_RECORDED)

TURNING_SPEED = 2.0 * math.pi / 60.0
"""rad/s, 1 rpm: a drive at rest reads less."""
TURNING_TIME = 30.0
"""s in which a rotating or rocking drive turns once or more; a driller who sets the toolface turns it less."""
ROCKING_TIME = 60.0
"""s: more than two periods of rocking, which take 5 to 25 s."""
ROCKING_NET_SHARE = 0.3
"""Net turn over turned angle, below which the drive rocks: 1 for rotation, 0 for rocking."""
ROCKING_SPREAD = 0.25
"""Standard deviation over mean of a speed without sign, above which it rocks: 0.48 for a sine, 0 for rotation."""
NEAR_BOTTOM = 60.0
"""m: two stands. Nearer the bottom slips are a connection, farther off they are part of a trip."""
STANDING = 1.0 / 600.0
"""m/s, 1 cm in 6 s: what the block sensor resolves."""
SHORTEST = 10
"""s: shorter activities join the one before, or the next at the start."""


def classify(channels: SurfaceChannels, track: BitTrack) -> Array:
    """Index into `KINDS` of the activity in each second, (n,)."""
    turning = _turning(channels)
    # A drive that starts or stops varies as well; rocking goes on for longer than the window that shows it.
    rocks = without_short(track.drilling & turning & rocking(channels), int(ROCKING_TIME))
    still = np.abs(np.gradient(channels.block)) < STANDING
    far = track.hole - track.depth > NEAR_BOTTOM
    conditions = [
        (~channels.recorded, NOT_RECORDED),
        (rocks, ROCKING),
        (track.drilling & turning, ROTATING),
        (track.drilling, SLIDING),
        (track.in_slips & ~far, CONNECTION),
        (far & ~channels.pumping, TRIPPING),
        (channels.pumping & still, CIRCULATING),
    ]
    codes = np.full(len(channels.time), float(KINDS.index(OFF_BOTTOM)))
    for mask, kind in reversed(conditions):
        codes[mask] = KINDS.index(kind)
    return _joined(codes)


def _turning(channels: SurfaceChannels) -> Mask:
    """Whether the drive rotates or rocks: it moves, and turns at least once in TURNING_TIME around."""
    half = int(TURNING_TIME / 2.0)
    turned = np.pad(channels.turned, half, mode="edge")
    often = turned[2 * half :] - turned[: -2 * half] >= 2.0 * math.pi
    moving = often & (np.abs(channels.speed) > TURNING_SPEED)
    filled = moving.copy()
    for first, last in runs(~moving):  # a rocking drive stands at each reversal
        filled[first:last] = last - first <= half
    return filled


def rocking(channels: SurfaceChannels) -> Mask:
    """Whether the drive's motion within ROCKING_TIME around is to and fro, for a drive that turns."""
    half = int(ROCKING_TIME / 2.0)
    if channels.is_signed:
        turned, net = (np.pad(values, half, mode="edge") for values in (channels.turned, channels.net_angle))
        path = np.maximum(turned[2 * half :] - turned[: -2 * half], 1e-9)
        return np.asarray(np.abs(net[2 * half :] - net[: -2 * half]) < ROCKING_NET_SHARE * path)
    speed = np.abs(channels.speed)
    mean = uniform_filter1d(speed, 2 * half + 1, mode="nearest")
    spread = np.sqrt(np.maximum(uniform_filter1d(speed**2, 2 * half + 1, mode="nearest") - mean**2, 0.0))
    return np.asarray(spread > ROCKING_SPREAD * np.maximum(mean, 1e-9))


def _joined(codes: Array) -> Array:
    """The codes without activities shorter than SHORTEST, which take that of their neighbour."""
    joined = codes.copy()
    for first, last in stretches(codes):
        if last - first < SHORTEST:
            joined[first:last] = joined[first - 1] if first else codes[min(last, len(codes) - 1)]
    return joined


def stretches(codes: Array) -> list[tuple[int, int]]:
    """First and past-the-last index of each stretch of one code."""
    edges = np.flatnonzero(np.diff(codes, prepend=codes[0] - 1.0)).tolist()
    return list(zip(edges, [*edges[1:], len(codes)], strict=True))
