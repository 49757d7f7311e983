"""What happened in a run, in the figures that a directional driller asks for first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from slider_drilling.errors import InputError
from slider_drilling.log.series import Array, JointSeries, RigLog

ON_TARGET = np.radians(15.0)


@dataclass(frozen=True)
class ToolFaceHold:
    """How the tool-face was held. source: `truth`, or `MWD` where the log holds no truth.

    mean_error: rad, mean of the absolute wrapped error; on_target: share of the time within 15 deg; set_after: s
    until it came within 15 deg for good or for 60 s, None where it never did; error_once_set: rad, mean from there on.
    """

    source: str
    mean_error: float
    on_target: float
    set_after: float | None
    error_once_set: float | None


@dataclass(frozen=True)
class RunSummary:
    """SI units; None where the log lacks the channel. A mean is over the run, torque_peak is of the magnitude."""

    duration: float
    tool_face: ToolFaceHold | None
    torque_peak: float | None
    torque_range: tuple[float, float] | None
    rocking_range: tuple[float, float] | None
    hook_load: tuple[float, float, float] | None     # lowest, mean, highest, N
    standpipe_pressure: tuple[float, float, float] | None
    weight_on_bit: tuple[float, float, float] | None
    drilled: float | None                            # m that the block was lowered
    mwd_samples: int


def summarise(log: RigLog) -> RunSummary:
    """The figures of one log. Raises InputError where it holds no surface channel."""
    series = [one for one in (log.top_drive, log.draw_works, log.standpipe_pressure, log.truth_bit) if one is not None]
    if not series:
        raise InputError(f"{log.source}: no surface channel to summarise")
    torque = None if log.top_drive is None else _there(log.top_drive.effort)
    angle = None if log.top_drive is None else _there(log.top_drive.position)
    block = None if log.draw_works is None else _there(log.draw_works.position)
    return RunSummary(
        duration=max(float(one.time[-1]) for one in series),
        tool_face=tool_face_hold(log),
        torque_peak=None if torque is None else float(np.abs(torque).max()),
        torque_range=None if torque is None else (float(torque.min()), float(torque.max())),
        rocking_range=None if angle is None else (float(angle.min()), float(angle.max())),
        hook_load=None if log.draw_works is None else _range(log.draw_works.effort),
        standpipe_pressure=None if log.standpipe_pressure is None else _range(log.standpipe_pressure.value),
        weight_on_bit=None if log.truth_weight_on_bit is None else _range(log.truth_weight_on_bit.value),
        drilled=None if block is None else float(block[-1] - block[0]),
        mwd_samples=0 if log.mwd_tool_face is None else len(log.mwd_tool_face.time),
    )


def tool_face_error(log: RigLog) -> tuple[Array, Array, str] | None:
    """Time s, wrapped error rad (measured minus target) and source; None without a tool-face. No target means 0."""
    shown: tuple[JointSeries, str] | None = None
    if log.truth_bit is not None:
        shown = (log.truth_bit, "truth")
    elif log.mwd_tool_face is not None:
        shown = (log.mwd_tool_face, "MWD")
    if shown is None:
        return None
    series, source = shown
    error = series.position - target_at(log, series.time)
    return series.time, np.pi - (np.pi - error) % (2.0 * np.pi), source


def target_at(log: RigLog, time: Array) -> Array:
    """The target that held at each time, rad: the last one said, the first one before that, 0 without any."""
    if log.tool_face_target is None:
        return np.zeros_like(time)
    index = np.searchsorted(log.tool_face_target.time, time, side="right") - 1
    return log.tool_face_target.position[np.maximum(index, 0)]


def tool_face_hold(log: RigLog) -> ToolFaceHold | None:
    """See ToolFaceHold; None where the log holds no tool-face."""
    found = tool_face_error(log)
    if found is None:
        return None
    time, error, source = found
    weight = np.gradient(time) if len(time) > 1 else np.ones(1)
    good = np.abs(error) <= ON_TARGET
    first = _set_at(time, good)
    return ToolFaceHold(
        source=source,
        mean_error=float(np.average(np.abs(error), weights=weight)),
        on_target=float(np.average(good, weights=weight)),
        set_after=None if first is None else float(time[first]),
        error_once_set=None if first is None else float(np.average(np.abs(error[first:]), weights=weight[first:])),
    )


def _set_at(time: Array, good: Array, hold: float = 60.0) -> int | None:
    """Index where the longest wait ends: the first sample from which the error stays small for `hold` s."""
    bad = np.flatnonzero(np.logical_not(good))
    for start in np.flatnonzero(np.diff(good.astype(int), prepend=0) > 0):
        later = int(np.searchsorted(bad, start))
        end = time[bad[later]] if later < len(bad) else time[-1]
        if end - time[start] >= hold:
            return int(start)
    return None


def _there(values: Array) -> Array | None:
    found = values[~np.isnan(values)]
    return found if len(found) else None


def _range(values: Array) -> tuple[float, float, float] | None:
    found = _there(values)
    return None if found is None else (float(found.min()), float(found.mean()), float(found.max()))


def rows(summary: RunSummary) -> list[tuple[str, str]]:
    """What it was and how much, in field units, for a table or a page."""
    found = [("simulated or recorded time", f"{summary.duration:.1f} s")]
    hold = summary.tool_face
    if hold is not None:
        found.append((f"tool-face error, mean ({hold.source})", f"{np.degrees(hold.mean_error):.1f} deg"))
        found.append(("tool-face within 15 deg", f"{100.0 * hold.on_target:.0f} % of the time"))
        if hold.set_after is None or hold.error_once_set is None:
            found.append(("tool-face set", "not within 15 deg for 60 s"))
        else:
            found.append(("tool-face set", f"after {hold.set_after:.0f} s, "
                                           f"{np.degrees(hold.error_once_set):.1f} deg mean error from there"))
    if summary.torque_peak is not None and summary.torque_range is not None:
        low, high = summary.torque_range
        found.append(("surface torque", f"{low / 1e3:.2f} to {high / 1e3:.2f} kN m, "
                                        f"peak {summary.torque_peak / 1e3:.2f} kN m"))
    if summary.rocking_range is not None:
        found.append(("top drive", "{:.1f} to {:.1f} rad".format(*summary.rocking_range)))
    for name, value, scale, unit in (
        ("hook load", summary.hook_load, 1e3, "kN"),
        ("standpipe pressure", summary.standpipe_pressure, 1e5, "bar"),
        ("weight on bit (truth)", summary.weight_on_bit, 1e3, "kN"),
    ):
        if value is not None:
            low, mean, high = (one / scale for one in value)
            found.append((name, f"{mean:.1f} {unit} mean, {low:.1f} to {high:.1f}"))
    if summary.drilled is not None:
        rate = summary.drilled / summary.duration * 3600.0 if summary.duration > 0.0 else 0.0
        found.append(("block lowered", f"{summary.drilled:.2f} m, {rate:.1f} m/h"))
    found.append(("MWD tool-faces", str(summary.mwd_samples)))
    return found


def summary_table(summary: RunSummary, more: tuple[tuple[str, str], ...] = ()) -> Table:
    """The rows as a table for the terminal, others after them."""
    table = Table(box=SIMPLE_HEAD, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, value in (*rows(summary), *more):
        table.add_row(name, value)
    return table
