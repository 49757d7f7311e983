"""Slides: hole that is drilled without rotation at one toolface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.log.series import Array, LogContents
from slider_drilling.rig import FLOW_EXPONENT
from slider_drilling.rig_activities.bit_track import BitTrack, runs
from slider_drilling.rig_activities.classify import KINDS, ROCKING, ROTATING, SLIDING
from slider_drilling.rig_activities.surface_channels import Mask, SurfaceChannels

NEW_TOOL_FACE = math.radians(60.0)
"""Turn of the drive at rest after which another slide begins: cos 60 deg = 1/2, so half the build in the old direction
is lost. Smaller turns trim the toolface."""
TURN_TIME = 15
"""s: turns with shorter pauses between them are one."""
MIN_SLIDE = 1.0
"""m of hole; a shorter one only sets the toolface."""
CIRCULATION_FLOW = 0.05
"""Share of the pump speed within which pressure off bottom is compared with pressure on bottom."""


@dataclass(frozen=True)
class DrilledSlide:
    """One slide; NaN where the log does not hold what a figure needs.

    Attributes:
        start: When the string is lowered to drill at this toolface, s since the log's start.
        end: When it is picked up, rotated, or has stood on bottom until the weight is drilled off, s.
        depth_from: Depth of the hole, m.
        depth_to: Depth of the hole, m.
        rate: Of penetration, m/s.
        is_rocking: Whether the drive rocks for most of it.
        tool_face: Mean of the MWD's, rad.
        wraps: Turn of the drive to either side of its centre, rad; 0 for a drive at rest.
        period: Of rocking, s; NaN without it.
        torque_right: Surface torque at the right end of the strokes, N m; the highest without rocking.
        torque_left: At the left end, N m; the lowest without rocking.
        differential_pressure: Mean pressure above that off bottom at this flow, Pa.
        hook_load: Mean, N.
    """

    start: float
    end: float
    depth_from: float
    depth_to: float
    rate: float
    is_rocking: bool
    tool_face: float
    wraps: float
    period: float
    torque_right: float
    torque_left: float
    differential_pressure: float
    hook_load: float

    @property
    def length(self) -> float:
        """New hole, m."""
        return self.depth_to - self.depth_from


def find_slides(
    log: LogContents, channels: SurfaceChannels, track: BitTrack, codes: Array
) -> tuple[DrilledSlide, ...]:
    """The slides of a log.

    Args:
        log: The log, for its MWD toolfaces.
        channels: Of the log.
        track: Of the bit.
        codes: Activity of each second, index into `KINDS`, (n,).
    """
    quiet = np.isin(codes, [KINDS.index(kind) for kind in (SLIDING, ROCKING)])
    stretches = [part for first, last in _joined_over_stands(quiet, channels, codes)
                 for part in _at_one_tool_face(first, last, channels, codes)]  # fmt: skip
    return tuple(
        _slide(log, channels, track, codes, first, last)
        for first, last in stretches
        if track.hole[last - 1] - track.hole[first] >= MIN_SLIDE
    )


def _joined_over_stands(
    quiet: Mask, channels: SurfaceChannels, codes: Array
) -> list[tuple[int, int]]:
    """Stretches of sliding; those with nothing but a stand on bottom between them are one."""
    joined: list[tuple[int, int]] = []
    for first, last in runs(quiet):
        if joined:
            between = slice(joined[-1][1], first)
            stood = np.ptp(channels.block[joined[-1][1] - 1 : first + 1]) < 0.05  # m, the sensor's noise
            turned = (codes[between] == KINDS.index(ROTATING)).any()
            if stood and not turned and channels.pumping[between].all() and channels.recorded[between].all():
                joined[-1] = (joined[-1][0], last)
                continue
        joined.append((first, last))
    return joined


def _at_one_tool_face(
    first: int, last: int, channels: SurfaceChannels, codes: Array
) -> list[tuple[int, int]]:
    """Cut a stretch where the resting drive turns by more than NEW_TOOL_FACE; the turn belongs to neither part."""
    moving = np.abs(channels.speed[first:last]) > 2.0 * math.pi / 60.0
    moving &= codes[first:last] == KINDS.index(SLIDING)
    turns: list[tuple[int, int]] = []
    for begin, end in runs(moving):
        if turns and begin - turns[-1][1] <= TURN_TIME:
            turns[-1] = (turns[-1][0], end)
        else:
            turns.append((begin, end))
    parts, begin = [], first
    for turn_begin, turn_end in turns:
        before, after = max(first + turn_begin - 1, first), min(first + turn_end, last - 1)
        if channels.turned[after] - channels.turned[before] > NEW_TOOL_FACE:
            parts.append((begin, before))
            begin = after
    return [(start, end) for start, end in [*parts, (begin, last)] if end - start > 1]


def _slide(
    log: LogContents, channels: SurfaceChannels, track: BitTrack, codes: Array, first: int, last: int
) -> DrilledSlide:
    inside = slice(first, last)
    start, end = float(channels.time[first]), float(channels.time[last - 1])
    rocks = bool(np.mean(codes[inside] == KINDS.index(ROCKING)) > 0.5)
    wraps, period = _strokes(log, start, end, channels.is_signed) if rocks else (0.0, math.nan)
    torque_right, torque_left = _torques(log, start, end, rocks)
    length = float(track.hole[last - 1] - track.hole[first])
    return DrilledSlide(
        start=start, end=end, depth_from=float(track.hole[first]), depth_to=float(track.hole[last - 1]),
        rate=length / (end - start), is_rocking=rocks, tool_face=_tool_face(log, start, end),
        wraps=wraps, period=period, torque_right=torque_right, torque_left=torque_left,
        differential_pressure=_differential_pressure(channels, track, first, last),
        hook_load=float(np.mean(channels.hook_load[inside])),
    )  # fmt: skip


def _tool_face(log: LogContents, start: float, end: float) -> float:
    """Circular mean of the MWD toolfaces, rad; NaN without any."""
    if log.mwd_tool_face is None:
        return math.nan
    angle = log.mwd_tool_face.position[(log.mwd_tool_face.time >= start) & (log.mwd_tool_face.time <= end)]
    angle = angle[np.isfinite(angle)]
    return float(np.angle(np.mean(np.exp(1j * angle)))) if angle.size else math.nan


def _strokes(log: LogContents, start: float, end: float, is_signed: bool) -> tuple[float, float]:
    """Half of the median stroke of the drive, rad, and the period of rocking, s; NaN if not identified."""
    assert log.top_drive is not None
    inside = (log.top_drive.time >= start) & (log.top_drive.time <= end) & np.isfinite(log.top_drive.position)
    angle, time = log.top_drive.position[inside], log.top_drive.time[inside]
    if len(angle) < 10 or not is_signed:
        return math.nan, math.nan
    peaks, troughs = _stroke_ends(angle)
    if len(peaks) < 2 or len(troughs) < 2:
        return math.nan, math.nan
    ends = np.sort(np.concatenate([peaks, troughs]))
    return 0.5 * float(np.median(np.abs(np.diff(angle[ends])))), float(np.median(np.diff(time[peaks])))


def _stroke_ends(value: Array) -> tuple[Array, Array]:
    """Indices of the right and the left ends of the strokes: they stand out by a quarter of the range."""
    from scipy.signal import find_peaks

    prominence = 0.25 * float(np.ptp(np.percentile(value, [5.0, 95.0])))
    return find_peaks(value, prominence=prominence)[0], find_peaks(-value, prominence=prominence)[0]


def _torques(log: LogContents, start: float, end: float, rocks: bool) -> tuple[float, float]:
    """Torque at the right and left ends of the strokes, medians; highest and lowest of a drive at rest, N m."""
    assert log.top_drive is not None
    inside = (log.top_drive.time >= start) & (log.top_drive.time <= end)
    torque = log.top_drive.effort[inside]
    torque = torque[np.isfinite(torque)]
    if not torque.size:
        return math.nan, math.nan
    peaks, troughs = _stroke_ends(torque) if rocks else (np.empty(0), np.empty(0))
    if not peaks.size or not troughs.size:
        return float(torque.max()), float(torque.min())
    return float(np.median(torque[peaks])), float(np.median(torque[troughs]))


def _differential_pressure(channels: SurfaceChannels, track: BitTrack, first: int, last: int) -> float:
    """Mean pressure above the last pressure off bottom at nearly the same pump speed, Pa; NaN without one."""
    if not np.isfinite(channels.pressure).all():
        return math.nan
    off = channels.pumping & channels.recorded & ~track.drilling & ~track.in_slips
    ratio = np.ones(len(off))
    if np.isfinite(channels.pump_speed).all():
        usual = float(np.median(channels.pump_speed[first:last]))
        ratio = channels.pump_speed / usual
        off &= np.abs(ratio - 1.0) < CIRCULATION_FLOW
    before, after = np.flatnonzero(off[:first]), last + np.flatnonzero(off[last:])
    nearest = before[-60:] if before.size >= 20 else after[:60]  # a minute averages the pumps' ripple
    if nearest.size < 20:
        return math.nan
    baseline = np.median(channels.pressure[nearest] / ratio[nearest] ** FLOW_EXPONENT)
    return float(np.mean(channels.pressure[first:last]) - baseline)
