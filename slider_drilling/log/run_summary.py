"""What happened in a run, in the figures that a directional driller asks for first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from slider_drilling.errors import InputError
from slider_drilling.log.series import Array, JointSeries, LogContents
from slider_drilling.units import SI, Units

ON_TARGET = np.radians(15.0)
PAUSE = 60.0  # s without new hole that still count as drilling
SET = 60.0  # s within, to count as set; and out again, to count as lost
NOT_SET = "not within 15 deg for 60 s"


@dataclass(frozen=True)
class TargetHold:
    """How one target was held. target: rad; since: s, when it was asked for; set_after: s from then until the
    toolface came within 15 deg for 60 s, None where it never did; lost_after: s from then until it was out again for
    60 s or to the end, None where it was held; error_once_set: rad, mean of the magnitude from set to lost.
    """

    target: float
    since: float
    set_after: float | None
    lost_after: float | None
    error_once_set: float | None


@dataclass(frozen=True)
class ToolFaceHold:
    """How the toolface was held. source: `truth`, or `MWD` where the log holds no truth.

    mean_error: rad, mean of the absolute wrapped error; on_target: share of the time within 15 deg; targets: one each.
    """

    source: str
    mean_error: float
    on_target: float
    targets: tuple[TargetHold, ...]


@dataclass(frozen=True)
class DrilledInterval:
    """source: `truth` or `bit depth`, where the log knows the bit; `block`, where only the block is known.

    start, end: m, the hole's depth (of the block: its position); metres: m of new hole (of the block: lowered);
    rate: m/s, of new hole over the time on bottom (of the block: over the run); on_bottom: s, None if not known.
    """

    source: str
    start: float
    end: float
    length: float
    rate: float
    on_bottom: float | None


@dataclass(frozen=True)
class RunSummary:
    """SI units; None where the log lacks the channel. A mean is over the run, torque_peak is of the magnitude."""

    duration: float
    tool_face: ToolFaceHold | None
    torque_peak: float | None
    torque_range: tuple[float, float] | None
    rocking_range: tuple[float, float] | None
    hook_load: tuple[float, float, float] | None  # lowest, mean, highest, N
    standpipe_pressure: tuple[float, float, float] | None
    weight_on_bit: tuple[float, float, float] | None
    block_lowered: float | None  # m
    drilled: DrilledInterval | None
    mwd_samples: int

    @property
    def drilled_nothing(self) -> bool:
        """Whether the log knows that nothing was drilled: the bit never touched bottom, or never went deeper."""
        return self.drilled is not None and self.drilled.source != "block" and self.drilled.length < 1e-3


def summarise_run(log: LogContents) -> RunSummary:
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
        block_lowered=None if block is None else float(block[-1] - block[0]),
        drilled=drilled_interval(log),
        mwd_samples=0 if log.mwd_tool_face is None else len(log.mwd_tool_face.time),
    )


def drilled_interval(log: LogContents) -> DrilledInterval | None:
    """What was drilled, from the best channel there is; None without any depth and block. New hole is made where the
    bit is deeper than it ever was in the log."""
    for source, series in (("truth", log.truth_depth), ("bit depth", log.bit_depth)):
        if series is None:
            continue
        there = ~np.isnan(series.position)
        time, depth = series.time[there], series.position[there]
        if not len(depth):
            continue
        hole = np.maximum.accumulate(depth)
        # Advances up to a minute apart are one stretch on bottom: bits stick, and recorders round their depth.
        pauses = np.diff(time[np.flatnonzero(np.diff(hole) > 0.0)])
        on_bottom = float(pauses[pauses <= PAUSE].sum())
        metres = float(hole[-1] - hole[0])
        rate = metres / on_bottom if on_bottom > 0.0 else 0.0
        return DrilledInterval(source, float(hole[0]), float(hole[-1]), metres, rate, on_bottom)
    block = None if log.draw_works is None else _there(log.draw_works.position)
    if block is None or log.draw_works is None:
        return None
    span, lowered = float(np.ptp(log.draw_works.time)), float(block[-1] - block[0])
    rate = lowered / span if span > 0.0 else 0.0
    return DrilledInterval("block", float(block[0]), float(block[-1]), lowered, rate, None)


def tool_face_error(log: LogContents) -> tuple[Array, Array, str] | None:
    """Time s, wrapped error rad (measured minus target) and source; None without a toolface. No target means 0."""
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


def target_at(log: LogContents, time: Array) -> Array:
    """The target that held at each time, rad: the last one said, the first one before that, 0 without any."""
    if log.tool_face_target is None:
        return np.zeros_like(time)
    index = np.searchsorted(log.tool_face_target.time, time, side="right") - 1
    return log.tool_face_target.position[np.maximum(index, 0)]


def tool_face_hold(log: LogContents) -> ToolFaceHold | None:
    """See ToolFaceHold; None where the log holds no toolface."""
    found = tool_face_error(log)
    if found is None:
        return None
    time, error, source = found
    weight = np.gradient(time) if len(time) > 1 else np.ones(1)
    target = target_at(log, time)
    starts = np.flatnonzero(np.append(True, np.abs(np.diff(target)) > 1e-6))
    ends = np.append(starts[1:], len(time))
    parts = [slice(int(first), int(last)) for first, last in zip(starts, ends, strict=True)]
    return ToolFaceHold(
        source=source,
        mean_error=float(np.average(np.abs(error), weights=weight)),
        on_target=float(np.average(np.abs(error) <= ON_TARGET, weights=weight)),
        targets=tuple(_held(time[part], error[part], weight[part], float(target[part][0])) for part in parts),
    )


def _held(time: Array, error: Array, weight: Array, target: float) -> TargetHold:
    good = np.abs(error) <= ON_TARGET
    first = _lasting(time, good)
    if first is None:
        return TargetHold(target, float(time[0]), None, None, None)
    lost = _lasting(time[first:], ~good[first:])
    last = len(time) if lost is None else first + lost
    return TargetHold(
        target, float(time[0]), float(time[first] - time[0]), None if lost is None else float(time[last] - time[0]),
        float(np.average(np.abs(error[first:last]), weights=weight[first:last])),
    )  # fmt: skip


def _lasting(time: Array, state: Array) -> int | None:
    """Index of the first sample from which the state lasts for `SET` s; None where it never does."""
    other = np.flatnonzero(np.logical_not(state))
    for start in np.flatnonzero(np.diff(state.astype(int), prepend=0) > 0):
        later = int(np.searchsorted(other, start))
        end = time[other[later]] if later < len(other) else time[-1]
        if end - time[start] >= SET:
            return int(start)
    return None


def _there(values: Array) -> Array | None:
    found = values[~np.isnan(values)]
    return found if len(found) else None


def _range(values: Array) -> tuple[float, float, float] | None:
    found = _there(values)
    return None if found is None else (float(found.min()), float(found.mean()), float(found.max()))


def summary_rows(summary: RunSummary, units: Units = SI) -> list[tuple[str, str]]:
    """What it was and how much, in the units asked for, for a table or a page."""
    found = [("simulated or recorded time", f"{summary.duration:.1f} s"), *_drilled_rows(summary, units)]
    if summary.tool_face is not None:
        found += _hold_rows(summary.tool_face, summary.drilled_nothing)
    if summary.torque_peak is not None and summary.torque_range is not None:
        low, high = (one / 1e3 for one in summary.torque_range)
        peak = units.format(summary.torque_peak / 1e3, "kN m")
        found.append(("surface torque", f"{units.format_range(low, high, 'kN m')}, peak {peak}"))
    if summary.rocking_range is not None:
        found.append(("top drive", units.format_range(*summary.rocking_range, "rad")))
    for name, value, scale, unit in (
        ("hook load", summary.hook_load, 1e3, "kN"),
        ("standpipe pressure", summary.standpipe_pressure, 1e5, "bar"),
        ("weight on bit (truth)", summary.weight_on_bit, 1e3, "kN"),
    ):
        if value is not None:
            low, mean, high = (one / scale for one in value)
            found.append((name, f"{units.format(mean, unit, 4)} mean, {units.format_range(low, high, unit, 4)}"))
    found.append(("MWD toolfaces", str(summary.mwd_samples)))
    return found


def _drilled_rows(summary: RunSummary, units: Units) -> list[tuple[str, str]]:
    found, lowered = summary.drilled, summary.block_lowered
    rows = [] if lowered is None else [("block lowered", units.format(lowered, "m"))]
    if found is None or found.source == "block":
        return rows
    if summary.drilled_nothing:
        return [("drilled", "nothing: the bit made no new hole"), *rows]
    rate = f"{units.format(found.rate * 3600.0, 'm/h')} while drilling"
    made = f"{units.format(found.length, 'm')}, {rate} ({found.on_bottom or 0.0:.0f} s)"
    return [("drilled", made), ("bit depth", units.format_range(found.start, found.end, "m", 6)), *rows]


def _hold_rows(hold: ToolFaceHold, idle: bool) -> list[tuple[str, str]]:
    if idle:
        return [("toolface", "not judged: a bit that does not drill does not turn the toolface")]
    found = [(f"toolface error, mean ({hold.source})", f"{np.degrees(hold.mean_error):.1f} deg"),
             ("toolface within 15 deg", f"{100.0 * hold.on_target:.0f} % of the time")]  # fmt: skip
    for one in hold.targets:
        which = f" at {np.degrees(one.target):.0f} deg" if len(hold.targets) > 1 else ""
        found.append((f"toolface set{which}", hold_sentence(one)))
    return found


def hold_sentence(one: TargetHold) -> str:
    """How one target was held, to follow "set"."""
    if one.set_after is None or one.error_once_set is None:
        return f"never: {NOT_SET}"
    error = f"{np.degrees(one.error_once_set):.1f} deg mean error"
    if one.lost_after is None:
        return f"after {one.set_after:.0f} s, {error} from there"
    return f"after {one.set_after:.0f} s, {error} until lost after {one.lost_after:.0f} s"


def run_summary_table(summary: RunSummary, more: tuple[tuple[str, str], ...] = (), units: Units = SI) -> Table:
    """The rows as a table for the terminal, others after them."""
    table = Table(box=SIMPLE_HEAD, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, value in (*summary_rows(summary, units), *more):
        table.add_row(name, value)
    return table
