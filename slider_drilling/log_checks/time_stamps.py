"""Check the time stamps: they ascend, no clock was set, few samples are missing, the rate is high enough."""

from __future__ import annotations

import numpy as np

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries, ScalarSeries
from slider_drilling.log.timestamps import Mask
from slider_drilling.log_checks.issue import Check, LogIssue
from slider_drilling.log_inputs.commands_from_log import unfilled_field
from slider_drilling.rig import Rig

# A gap is this many sampling intervals long, and at least this many seconds.
_GAP_INTERVALS, _GAP_S = 10.0, 1.0
# The drive moved during a gap if it turned by more than this, rad. Such gaps may fill this share of the log.
_TURNED, _MAX_UNKNOWN = 0.5, 0.1
_ABOUT_S = 10.0  # about a gap: whether the drive turns there shows whether it turned in the gap, without an angle
_JUMP_S = 1.0
_MIN_RATE = 0.5  # of the rate that the rig file declares
_DROPPED = 1.5  # sampling intervals: samples are missing between two stamps that are farther apart
_MIN_COVERAGE = 0.9  # of the top drive's log


def check_time_stamps(log: RigLog, rig: Rig | None) -> list[LogIssue]:
    """Every issue with the stamps of the surface channels; without a rig file no rate is expected."""
    series = surface_series(log)
    issues = [issue for name, channel in series.items() if (issue := _not_ascending(name, channel.time))]
    if issues:
        return issues
    for name, channel in series.items():
        issues += _clock_set(name, channel.time, channel.arrival)
    issues += _one_note_per_text({name: _dropped(channel.time) for name, channel in series.items()}, "gaps")
    if rig is not None:
        slow = {name: _slow(channel.time, rig.sensors.rate) for name, channel in series.items()}
        issues += _one_note_per_text(slow, "rate")
    issues += _unknown_motion(log)
    return issues + _coverage(series)


def surface_series(log: RigLog) -> dict[str, JointSeries | ScalarSeries]:
    """The surface channels that a diagnosis reads, by their names in the log; those of one sample are left out."""
    named = {
        "top_drive": log.top_drive,
        "draw_works": log.draw_works,
        "standpipe_pressure": log.standpipe_pressure,
        "mud_pump": log.mud_pump,
    }
    return {name: series for name, series in named.items() if series is not None and series.time.size > 1}


def _not_ascending(name: str, time: Array) -> LogIssue | None:
    if not np.isfinite(time).all():
        text = f"{name}: {np.count_nonzero(~np.isfinite(time))} stamps are not numbers"
        return LogIssue("unusable", "clock", text, "clock")
    backward = np.flatnonzero(np.diff(time) <= 0.0)
    if backward.size == 0:
        return None
    first = float(time[backward[0]])
    text = f"{name}: stamps do not ascend at {backward.size} places, first after {first:.2f} s"
    return LogIssue("unusable", "clock", text, "clock")


def _clock_set(name: str, time: Array, arrival: Array) -> list[LogIssue]:
    """Whether the rig's clock was set: stamps jump while the recorder's clock runs on."""
    if arrival.shape != time.shape or not np.isfinite(arrival).all():
        return []
    jump = np.diff(time) - np.diff(arrival)
    at = int(np.argmax(np.abs(jump)))
    delay = arrival - time
    # A message that arrived late jumps too, but the delay after it is what it was before.
    lasting = float(np.median(delay[: at + 1]) - np.median(delay[at + 1 :]))
    if abs(jump[at]) < _JUMP_S or abs(lasting) < 0.5 * abs(jump[at]):
        return []
    text = (
        f"{name}: stamps jump by {jump[at]:+.1f} s at {time[at]:.1f} s while the recorder's clock runs on: "
        "a clock was set; use the log before or after that"
    )
    return [LogIssue("unusable", "clock", text, "clock")]


def _one_note_per_text(texts: dict[str, str | None], check: Check) -> list[LogIssue]:
    """One note for all channels with the same text: channels are usually logged together."""
    channels: dict[str, list[str]] = {}
    for name, text in texts.items():
        if text is not None:
            channels.setdefault(text, []).append(name)
    return [LogIssue("note", names[0], f"{', '.join(names)}: {text}", check) for text, names in channels.items()]


def _dropped(time: Array) -> str | None:
    steps = np.diff(time)
    interval = float(np.median(steps))
    missing = int(np.sum(np.round(steps[steps > _DROPPED * interval] / interval) - 1.0))
    if missing == 0:
        return None
    longest = int(np.argmax(steps))
    share = 100.0 * missing / (missing + time.size)
    return (
        f"{missing} samples ({_percent(share)} %) are missing; the longest gap is {steps[longest]:.1f} s, "
        f"at {time[longest]:.1f} s"
    )


def _percent(share: float) -> str:
    return f"{share:.2g}" if share < 99.5 else f"{share:.0f}"


def _slow(time: Array, declared: float) -> str | None:
    rate = 1.0 / float(np.median(np.diff(time)))
    if rate >= _MIN_RATE * declared:
        return None
    return (
        f"sampled at {rate:.3g} Hz, but the rig file's sensors.rate is {declared:g} Hz; faster changes are not "
        "in the log"
    )


def _unknown_motion(log: RigLog) -> list[LogIssue]:
    """Gaps in which the top drive turned: the motion that drives the simulation is unknown there."""
    drive = log.top_drive
    if drive is None:
        return []
    has_angle = np.isfinite(drive.position).any() and unfilled_field(drive) != "position"
    motion = drive.position if has_angle else drive.velocity
    known = np.isfinite(motion)
    time, motion = drive.time[known], motion[known]
    steps = np.diff(time)
    if steps.size == 0:
        return []
    gaps = steps > max(_GAP_INTERVALS * float(np.median(steps)), _GAP_S)
    turned = np.abs(np.diff(motion)) if has_angle else steps * _speed_about(time, motion, gaps)
    gaps &= turned > _TURNED
    unknown = float(steps[gaps].sum())
    if unknown == 0.0:
        return []
    worst = int(np.argmax(np.where(gaps, steps, 0.0)))
    text = (
        f"the top drive turned during gaps of {unknown:.1f} s in total, the longest {steps[worst]:.1f} s at "
        f"{time[worst]:.1f} s: its motion there is unknown"
    )
    share = unknown / float(time[-1] - time[0])
    return [LogIssue("uninformative" if share > _MAX_UNKNOWN else "note", "top_drive", text, "gaps")]


def _speed_about(time: Array, speed: Array, gaps: Mask) -> Array:
    """The fastest speed shortly before or after each gap, (n - 1,), zero elsewhere: a drive that reverses may be at
    rest just where its samples are lost."""
    fastest = np.zeros(time.size - 1)
    for gap in np.flatnonzero(gaps):
        near = (time >= time[gap] - _ABOUT_S) & (time <= time[gap + 1] + _ABOUT_S)
        fastest[gap] = np.abs(speed[near]).max()
    return fastest


def _coverage(series: dict[str, JointSeries | ScalarSeries]) -> list[LogIssue]:
    """Channels that cover only part of the top drive's log."""
    if "top_drive" not in series:
        return []
    start, end = series["top_drive"].time[[0, -1]]
    issues = []
    for name, channel in series.items():
        covered = max(min(channel.time[-1], end) - max(channel.time[0], start), 0.0) / max(end - start, 1e-9)
        if covered < _MIN_COVERAGE:
            text = f"{name}: covers {100.0 * covered:.0f} % of the top drive's log"
            issues.append(LogIssue("note", name, text, "gaps"))
    return issues
