"""The log's clock: stamps that do not ascend, jumps, gaps and rates."""

from __future__ import annotations

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries, ScalarSeries
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.rig import Rig

# A gap is this many intervals long, or this many seconds where samples are dense.
_GAP_INTERVALS, _GAP_S = 10.0, 1.0
# Share of the log in which the drive's motion may be unknown, and the turn (rad) that makes a gap one of those.
_MOST_UNKNOWN, _TURNED = 0.1, 0.5
_JUMP_S = 1.0
_SLOW = 0.5  # of the declared rate
_DROPPED = 1.5  # intervals


def check_time_stamps(log: RigLog, rig: Rig) -> list[LogIssue]:
    """Every finding about the stamps of the surface channels."""
    series = surface_series(log)
    found = [why for name, own in series.items() if (why := _stamps(name, own.time))]
    if found:
        return found
    for name, own in series.items():
        found += _jump(name, own.time, own.arrival)
    found += _alike({name: _dropped(own.time) for name, own in series.items()})
    found += _alike({name: _rate(own.time, rig.sensors.rate) for name, own in series.items()})
    found += _unknown_motion(log)
    return found + _coverage(series)


def surface_series(log: RigLog) -> dict[str, JointSeries | ScalarSeries]:
    """The series sampled at the surface that a diagnosis reads, by the log's names."""
    named = {
        "top_drive": log.top_drive,
        "draw_works": log.draw_works,
        "standpipe_pressure": log.standpipe_pressure,
        "mud_pump": log.mud_pump,
    }
    return {name: own for name, own in named.items() if own is not None and own.time.size > 1}


def _stamps(name: str, time: Array) -> LogIssue | None:
    if not np.isfinite(time).all():
        return LogIssue("unusable", "clock", f"{name}: {np.count_nonzero(~np.isfinite(time))} stamps are no numbers")
    back = int(np.count_nonzero(np.diff(time) <= 0.0))
    if back == 0:
        return None
    at = float(time[np.flatnonzero(np.diff(time) <= 0.0)[0]])
    return LogIssue("unusable", "clock", f"{name}: stamps do not ascend at {back} places, first after {at:.2f} s")


def _jump(name: str, time: Array, arrival: Array) -> list[LogIssue]:
    """A stamp that leaps while the recorder's own clock goes on: the rig's clock was set during the log."""
    if arrival.shape != time.shape or not np.isfinite(arrival).all():
        return []
    leap = np.diff(time) - np.diff(arrival)
    at = int(np.argmax(np.abs(leap)))
    late = arrival - time
    lasting = float(np.median(late[: at + 1]) - np.median(late[at + 1 :]))
    if abs(leap[at]) < _JUMP_S or abs(lasting) < 0.5 * abs(leap[at]):
        return []
    text = (
        f"{name}: stamps leap by {leap[at]:+.1f} s at {time[at]:.1f} s while the recorder's clock goes on: "
        "a clock was set; use the log before or after that"
    )
    return [LogIssue("unusable", "clock", text)]


def _alike(notes: dict[str, str | None]) -> list[LogIssue]:
    """One note for the channels of which the same is to be said: as a rule they were logged together."""
    together: dict[str, list[str]] = {}
    for name, text in notes.items():
        if text is not None:
            together.setdefault(text, []).append(name)
    return [LogIssue("note", names[0], f"{', '.join(names)}: {text}") for text, names in together.items()]


def _dropped(time: Array) -> str | None:
    steps = np.diff(time)
    interval = float(np.median(steps))
    missing = int(np.sum(np.round(steps[steps > _DROPPED * interval] / interval) - 1.0))
    if missing == 0:
        return None
    longest = int(np.argmax(steps))
    share = 100.0 * missing / (missing + time.size)
    return (
        f"{missing} samples ({share:.2g} %) are missing, the longest gap is {steps[longest]:.1f} s "
        f"at {time[longest]:.1f} s"
    )


def _rate(time: Array, declared: float) -> str | None:
    rate = 1.0 / float(np.median(np.diff(time)))
    if rate >= _SLOW * declared:
        return None
    return (
        f"{rate:.3g} samples a second where the rig file's sensors.rate is {declared:g} Hz; what happens between two "
        "of them is not known"
    )


def _unknown_motion(log: RigLog) -> list[LogIssue]:
    """Gaps of the top drive through which it turned: what drives the simulation is made up there."""
    drive = log.top_drive
    if drive is None or drive.time.size < 2 or not np.isfinite(drive.position).any():
        return []
    known = np.isfinite(drive.position)
    time, angle = drive.time[known], drive.position[known]
    steps = np.diff(time)
    if steps.size == 0:
        return []
    gaps = steps > max(_GAP_INTERVALS * float(np.median(steps)), _GAP_S)
    gaps &= np.abs(np.diff(angle)) > _TURNED
    unknown = float(steps[gaps].sum())
    if unknown == 0.0:
        return []
    worst = int(np.argmax(np.where(gaps, steps, 0.0)))
    text = (
        f"the top drive turned through gaps of {unknown:.1f} s in all, the longest {steps[worst]:.1f} s at "
        f"{time[worst]:.1f} s: its motion there is not known"
    )
    share = unknown / float(time[-1] - time[0])
    return [LogIssue("uninformative" if share > _MOST_UNKNOWN else "note", "top_drive", text)]


def _coverage(series: dict[str, JointSeries | ScalarSeries]) -> list[LogIssue]:
    """Channels that hold only part of the time that the top drive was logged."""
    if "top_drive" not in series:
        return []
    begin, end = series["top_drive"].time[[0, -1]]
    found = []
    for name, own in series.items():
        inside = max(min(own.time[-1], end) - max(own.time[0], begin), 0.0) / max(end - begin, 1e-9)
        if inside < 0.9:
            found.append(LogIssue("note", name, f"{name}: covers {100.0 * inside:.0f} % of the top drive's log"))
    return found
