"""Splits a log into activities and slides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.log.series import Array, LogContents
from slider_drilling.rig_activities.bit_track import track_bit
from slider_drilling.rig_activities.classify import KINDS, classify, stretches
from slider_drilling.rig_activities.slides import DrilledSlide, find_slides
from slider_drilling.rig_activities.surface_channels import SurfaceChannels, surface_channels


@dataclass(frozen=True)
class Activity:
    """One stretch of a log with one activity.

    Attributes:
        kind: One of `classify.KINDS`.
        start: s since the log's start.
        end: s.
        depth_from: Of the bit at the start, m.
        depth_to: At the end, m.
        drilled: New hole, m.
        rate: Of penetration, m/s; 0 where no hole was made.
    """

    kind: str
    start: float
    end: float
    depth_from: float
    depth_to: float
    drilled: float
    rate: float

    @property
    def duration(self) -> float:
        """s."""
        return self.end - self.start


@dataclass(frozen=True)
class DaySplit:
    """The activities of a log.

    Attributes:
        source: The log.
        start: Epoch seconds of t = 0.
        activities: In the order of their times, without holes between them.
        slides: Stretches drilled without rotation at one toolface.
        channels: What they were found in, one sample a second.
        depth: Of the bit, m, (n,).
        depth_source: Where the depth comes from.
        notes: What a reader should know, one sentence each.
    """

    source: str
    start: float
    activities: tuple[Activity, ...]
    slides: tuple[DrilledSlide, ...]
    channels: SurfaceChannels
    depth: Array
    depth_source: str
    notes: tuple[str, ...]

    def totals(self) -> dict[str, tuple[float, float]]:
        """Time in s and new hole in m of each kind that occurs, in the order of `KINDS`."""
        sums = {}
        for kind in KINDS:
            own = [activity for activity in self.activities if activity.kind == kind]
            if own:
                sums[kind] = (sum(part.duration for part in own), sum(part.drilled for part in own))
        return sums


def split_day(log: LogContents, start_depth: float | None = None) -> DaySplit:
    """Split a log into activities and slides.

    Args:
        log: The log, of any length from a minute on.
        start_depth: Depth of the bit at the start, m. If None, that of the topic `bit_depth`; else depths count from
            the start of the log.

    Raises:
        InputError: The log lacks a channel that activities need.
    """
    channels = surface_channels(log)
    measured, source = _measured_depth(log, channels, start_depth)
    track = track_bit(channels, start_depth or 0.0, measured)
    codes = classify(channels, track)
    parts = []
    for first, last in stretches(codes):
        end = min(last, len(codes) - 1)
        drilled = float(track.hole[end] - track.hole[first])
        duration = float(channels.time[end] - channels.time[first])
        rate = drilled / duration if duration > 0.0 else 0.0
        kind = KINDS[int(codes[first])]
        parts.append(Activity(kind, float(channels.time[first]), float(channels.time[end]), float(track.depth[first]),
                              float(track.depth[end]), drilled, rate))  # fmt: skip
    slides = find_slides(log, channels, track, codes)
    return DaySplit(log.source, log.start, tuple(parts), slides, channels, track.depth, source,
                    _notes(channels, track.block_weight))  # fmt: skip


def _measured_depth(
    log: LogContents, channels: SurfaceChannels, start_depth: float | None
) -> tuple[Array | None, str]:
    """The depth that the log holds, and where depths come from."""
    if start_depth is not None:
        return None, "the depth at the start as given, and the block"
    series = log.bit_depth if log.bit_depth is not None else log.truth_depth
    if series is not None and np.isfinite(series.position).any():
        there = np.isfinite(series.position)
        return np.interp(channels.time, series.time[there], series.position[there]), "the log"
    return None, "the block, from 0 at the start of the log"


def _notes(channels: SurfaceChannels, block_weight: float) -> tuple[str, ...]:
    notes = []
    if not channels.is_signed:
        notes.append("The top drive's speed has no sign: rocking is distinguished from rotation by how much it varies.")
    if np.isnan(block_weight):
        notes.append("The hook load never falls to that of the block alone: no connections were found.")
    lost = int((~channels.recorded).sum())
    if lost:
        notes.append(f"Nothing was recorded for {lost} s; the bit's depth after that is that of the block.")
    return tuple(notes)
