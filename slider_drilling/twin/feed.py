"""Where a twin's samples come from: a log, a recording that grows, a stream of WITS."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Protocol

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log.follow_recording import RecordingFollower
from slider_drilling.log.series import JointSeries, ScalarSeries
from slider_drilling.log.timestamps import SECOND, StampedSamples
from slider_drilling.log_checks.repeated_samples import mask_repeated_samples
from slider_drilling.messages.topics import TOPICS
from slider_drilling.rig import Rig, parse_rig
from slider_drilling.twin.samples import Array

Samples = dict[str, tuple[Array, Array]]
"""Channel of the twin -> times s and values."""
_ARRAYS = {
    ("top_drive", "position"): "top_drive_angle", ("top_drive", "velocity"): "top_drive_speed",
    ("top_drive", "effort"): "surface_torque", ("draw_works", "position"): "block_position",
    ("draw_works", "velocity"): "block_speed", ("draw_works", "effort"): "hook_load",
    ("standpipe_pressure", "value"): "standpipe_pressure", ("mud_pump", "velocity"): "pump_speed",
    ("mwd_tool_face", "position"): "tool_face",
}  # fmt: skip
CLOCK = "top_drive"


class Feed(Protocol):
    """A source of samples.

    Attributes:
        ended: Whether no more will come.
    """

    ended: bool

    def poll(self) -> list[Samples]:
        """What has come since the last call, in pieces of about a second; empty while nothing does."""
        ...


class LogFeed:
    """A whole log, second by second as it was recorded.

    Args:
        log: The log; samples that only repeat the one before are left out.
    """

    def __init__(self, log: RigLog) -> None:
        self.ended = False
        self._series = _series_of(mask_repeated_samples(log)[0])
        if CLOCK not in {key for key, _ in self._series}:
            raise InputError(log.lack_of_top_drive("drives the twin"))
        self._seconds = self._iterate()

    def poll(self) -> list[Samples]:
        """See `Feed`: one second."""
        found = next(self._seconds, None)
        self.ended = found is None
        return [] if found is None else [found]

    def _iterate(self) -> Iterator[Samples]:
        arrivals = {key: np.maximum.accumulate(series.arrival) for key, series in self._series.items()}
        begin = min(float(each[0]) for each in arrivals.values())
        last = max(float(each[-1]) for each in arrivals.values())
        position = dict.fromkeys(self._series, 0)
        while begin <= last:
            second: Samples = {}
            for key, series in self._series.items():
                end = int(np.searchsorted(arrivals[key], begin + 1.0))
                rows = slice(position[key], end)
                position[key] = end
                if rows.stop > rows.start:
                    second[_ARRAYS[key]] = series.time[rows], getattr(series, key[1])[rows]
            begin += 1.0
            yield second


class RecordingFeed:
    """A recording while it is written.

    Args:
        follower: Of the recording.
        patient: Whether to wait for more although no program of this machine writes to it.
        note: Called with a sentence where it ends without being complete.
    """

    def __init__(
        self, follower: RecordingFollower, patient: bool, note: Callable[[str], None] = lambda text: None
    ) -> None:
        self._follower, self._patient, self._note = follower, patient, note
        self._start_ns: int | None = None
        self._held: list[dict[str, StampedSamples]] = []
        self.ended = False

    def rig(self) -> Rig | None:
        """The rig of the recording, once it shows it. Raises InputError where it cannot be used."""
        text = self._follower.rig_text
        return None if text is None else parse_rig(text, "the recording's rig.yaml")

    def poll(self) -> list[Samples]:
        """See `Feed`."""
        still = self._follower.ended or not (self._patient or self._follower.being_written)
        found = self._follower.poll()
        self.ended = still and not found
        if self.ended and not self._follower.ended:
            ended = "the program that wrote it has ended, or is on another machine; --follow waits for more"
            self._note(f"{self._follower.path}: breaks off: {ended}")
        if found:
            self._held.append(found)
        if self._start_ns is None and CLOCK in found:
            self._start_ns = int(found[CLOCK].stamp[0])
        if self._start_ns is None:
            return []
        pieces = [_samples_of(each, self._start_ns) for each in self._held]
        self._held = []
        return pieces


def recording_grows(path: Path) -> bool:
    """Whether an MCAP file or a folder of them is being written by a program of this machine."""
    if path.is_file() and path.suffix != ".mcap":
        return False
    return path.exists() and RecordingFollower(path).being_written


def _series_of(log: RigLog) -> Mapping[tuple[str, str], JointSeries | ScalarSeries]:
    held = log.series()
    return {key: held[key[0]] for key in _ARRAYS if key[0] in held}


def _samples_of(found: Mapping[str, StampedSamples], start_ns: int) -> Samples:
    samples: Samples = {}
    for key, track in found.items():
        names = [part.array for part in TOPICS[key].message_type().logged]
        for column, array in enumerate(names):
            channel = _ARRAYS.get((key, array))
            if channel is not None:
                samples[channel] = (track.stamp - start_ns) / SECOND, track.values[:, column]
    return samples
