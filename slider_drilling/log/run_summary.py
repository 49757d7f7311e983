"""Figures of a run that a directional driller asks for first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from slider_drilling.errors import InputError
from slider_drilling.log.series import Array, LogContents
from slider_drilling.units import SI, Units

ON_TARGET = np.radians(15.0)
MAX_PAUSE = 60.0  # s without new hole that still count as drilling
HOLD_TIME = 60.0  # s on target after which the toolface is set, and off target after which it is lost
NOT_SET = "not within 15 deg for 60 s"


@dataclass(frozen=True)
class TargetHold:
    """How one target was held.

    Attributes:
        target: rad.
        since: When it was set as a target, s.
        set_after: s from then until the toolface came within ON_TARGET for HOLD_TIME; None where it never did.
        lost_after: s from then until it was off target again for HOLD_TIME or to the end; None where it was held.
        error_once_set: Mean magnitude of the error from set to lost, rad.
    """

    target: float
    since: float
    set_after: float | None
    lost_after: float | None
    error_once_set: float | None


@dataclass(frozen=True)
class ToolFaceHold:
    """How the toolface was held.

    Attributes:
        source: `truth`, or `MWD` where the log holds no truth.
        mean_error: Mean magnitude of the wrapped error, rad.
        on_target: Fraction of the time within ON_TARGET.
        targets: How each target was held.
    """

    source: str
    mean_error: float
    on_target: float
    targets: tuple[TargetHold, ...]


@dataclass(frozen=True)
class DrilledInterval:
    """New hole, or how far the block was lowered where the log does not hold the bit's depth.

    Attributes:
        source: `truth` or `bit depth`; `block` where only the block is known.
        start: Depth of the hole at the start, m; position of the block.
        end: Depth of the hole at the end, m; position of the block.
        length: New hole, m; how far the block was lowered.
        rate: New hole over the time on bottom, m/s; of the block over the run.
        on_bottom: Time on bottom, s; None where unknown.
    """

    source: str
    start: float
    end: float
    length: float
    rate: float
    on_bottom: float | None


@dataclass(frozen=True)
class RunSummary:
    """Figures of one run, in SI units; None where the log does not hold the topic.

    Attributes:
        duration: s.
        tool_face: How the toolface was held; None for a programme, which holds one in its slides only.
        torque_peak: Largest magnitude of the surface torque, N m.
        torque_range: Lowest and highest surface torque, N m.
        rocking_range: Lowest and highest angle of the top drive, rad.
        hook_load: Lowest, mean and highest, N.
        standpipe_pressure: Lowest, mean and highest, Pa.
        weight_on_bit: Lowest, mean and highest of the truth, N.
        block_lowered: m.
        drilled: New hole.
        mwd_samples: Number of MWD toolfaces.
    """

    duration: float
    tool_face: ToolFaceHold | None
    torque_peak: float | None
    torque_range: tuple[float, float] | None
    rocking_range: tuple[float, float] | None
    hook_load: tuple[float, float, float] | None
    standpipe_pressure: tuple[float, float, float] | None
    weight_on_bit: tuple[float, float, float] | None
    block_lowered: float | None
    drilled: DrilledInterval | None
    mwd_samples: int

    @property
    def drilled_nothing(self) -> bool:
        """Whether the bit made no new hole; False where the log does not hold its depth."""
        return self.drilled is not None and self.drilled.source != "block" and self.drilled.length < 1e-3


def summarise_run(log: LogContents) -> RunSummary:
    """The figures of one log. Raises InputError where it holds no surface topic."""
    surface = (log.top_drive, log.draw_works, log.standpipe_pressure, log.truth_bit)
    ends = [float(series.time[-1]) for series in surface if series is not None]
    if not ends:
        raise InputError(f"{log.source}: no surface channel to summarise")
    torque = None if log.top_drive is None else _finite(log.top_drive.effort)
    angle = None if log.top_drive is None else _finite(log.top_drive.position)
    block = None if log.draw_works is None else _finite(log.draw_works.position)
    return RunSummary(
        duration=max(ends),
        tool_face=None if log.programme_text is not None else tool_face_hold(log),
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
    """New hole from the best topic that the log holds; None without depth and block.

    New hole is made where the bit is deeper than ever before in the log.
    """
    for source, series in (("truth", log.truth_depth), ("bit depth", log.bit_depth)):
        if series is None:
            continue
        given = ~np.isnan(series.position)
        time, depth = series.time[given], series.position[given]
        if not len(depth):
            continue
        hole = np.maximum.accumulate(depth)
        # Advances up to a minute apart are one interval on bottom: bits stick, and recorders round the depth.
        pauses = np.diff(time[np.flatnonzero(np.diff(hole) > 0.0)])
        on_bottom = float(pauses[pauses <= MAX_PAUSE].sum())
        length = float(hole[-1] - hole[0])
        rate = length / on_bottom if on_bottom > 0.0 else 0.0
        return DrilledInterval(source, float(hole[0]), float(hole[-1]), length, rate, on_bottom)
    block = None if log.draw_works is None else _finite(log.draw_works.position)
    if block is None or log.draw_works is None:
        return None
    span, lowered = float(np.ptp(log.draw_works.time)), float(block[-1] - block[0])
    rate = lowered / span if span > 0.0 else 0.0
    return DrilledInterval("block", float(block[0]), float(block[-1]), lowered, rate, None)


def tool_face_error(log: LogContents) -> tuple[Array, Array, str] | None:
    """Error of the toolface over time.

    Returns:
        Time s, wrapped error rad (measured minus target; a missing target is 0) and source; None without a toolface.
    """
    series, source = (log.mwd_tool_face, "MWD") if log.truth_bit is None else (log.truth_bit, "truth")
    if series is None:
        return None
    error = series.position - target_at(log, series.time)
    return series.time, np.pi - (np.pi - error) % (2.0 * np.pi), source


def target_at(log: LogContents, time: Array) -> Array:
    """The target at each time, rad, (n,): the last one set, before that the first one; 0 without any."""
    if log.tool_face_target is None:
        return np.zeros_like(time)
    index = np.searchsorted(log.tool_face_target.time, time, side="right") - 1
    return log.tool_face_target.position[np.maximum(index, 0)]


def tool_face_hold(log: LogContents) -> ToolFaceHold | None:
    """How the toolface was held; None where the log holds no toolface."""
    deviation = tool_face_error(log)
    if deviation is None:
        return None
    time, error, source = deviation
    weight = np.gradient(time) if len(time) > 1 else np.ones(1)
    target = target_at(log, time)
    starts = np.flatnonzero(np.append(True, np.abs(np.diff(target)) > 1e-6))
    ends = np.append(starts[1:], len(time))
    parts = [slice(int(first), int(last)) for first, last in zip(starts, ends, strict=True)]
    return ToolFaceHold(
        source=source,
        mean_error=float(np.average(np.abs(error), weights=weight)),
        on_target=float(np.average(np.abs(error) <= ON_TARGET, weights=weight)),
        targets=tuple(_target_hold(time[part], error[part], weight[part], float(target[part][0])) for part in parts),
    )


def _target_hold(time: Array, error: Array, weight: Array, target: float) -> TargetHold:
    """How a target was held, from its part of the run."""
    good = np.abs(error) <= ON_TARGET
    first = _start_of_lasting(time, good)
    if first is None:
        return TargetHold(target, float(time[0]), None, None, None)
    lost = _start_of_lasting(time[first:], ~good[first:])
    last = len(time) if lost is None else first + lost
    return TargetHold(
        target, float(time[0]), float(time[first] - time[0]), None if lost is None else float(time[last] - time[0]),
        float(np.average(np.abs(error[first:last]), weights=weight[first:last])),
    )  # fmt: skip


def _start_of_lasting(time: Array, state: Array) -> int | None:
    """Index of the first sample from which the state lasts for HOLD_TIME; None where it never does."""
    other = np.flatnonzero(np.logical_not(state))
    for start in np.flatnonzero(np.diff(state.astype(int), prepend=0) > 0):
        later = int(np.searchsorted(other, start))
        end = time[other[later]] if later < len(other) else time[-1]
        if end - time[start] >= HOLD_TIME:
            return int(start)
    return None


def _finite(values: Array) -> Array | None:
    """The values that are given; None where there are none."""
    given = values[~np.isnan(values)]
    return given if len(given) else None


def _range(values: Array) -> tuple[float, float, float] | None:
    """Lowest, mean and highest value."""
    given = _finite(values)
    return None if given is None else (float(given.min()), float(given.mean()), float(given.max()))


def summary_rows(summary: RunSummary, units: Units = SI) -> list[tuple[str, str]]:
    """The summary as (name, value) texts in the given units."""
    rows = [("simulated or recorded time", f"{summary.duration:.1f} s"), *_drilled_rows(summary, units)]
    if summary.tool_face is not None:
        rows += _hold_rows(summary.tool_face, summary.drilled_nothing)
    if summary.torque_peak is not None and summary.torque_range is not None:
        low, high = (torque / 1e3 for torque in summary.torque_range)
        peak = units.format(summary.torque_peak / 1e3, "kN m")
        rows.append(("surface torque", f"{units.format_range(low, high, 'kN m')}, peak {peak}"))
    if summary.rocking_range is not None:
        rows.append(("top drive", units.format_range(*summary.rocking_range, "rad")))
    for name, values, scale, unit in (
        ("hook load", summary.hook_load, 1e3, "kN"),
        ("standpipe pressure", summary.standpipe_pressure, 1e5, "bar"),
        ("weight on bit (truth)", summary.weight_on_bit, 1e3, "kN"),
    ):
        if values is not None:
            low, mean, high = (value / scale for value in values)
            rows.append((name, f"{units.format(mean, unit, 4)} mean, {units.format_range(low, high, unit, 4)}"))
    rows.append(("MWD toolfaces", str(summary.mwd_samples)))
    return rows


def _drilled_rows(summary: RunSummary, units: Units) -> list[tuple[str, str]]:
    drilled, lowered = summary.drilled, summary.block_lowered
    rows = [] if lowered is None else [("block lowered", units.format(lowered, "m"))]
    if drilled is None or drilled.source == "block":
        return rows
    if summary.drilled_nothing:
        return [("drilled", "nothing: the bit made no new hole"), *rows]
    rate = f"{units.format(drilled.rate * 3600.0, 'm/h')} while drilling"
    length = f"{units.format(drilled.length, 'm')}, {rate} ({drilled.on_bottom or 0.0:.0f} s)"
    return [("drilled", length), ("bit depth", units.format_range(drilled.start, drilled.end, "m", 6)), *rows]


def _hold_rows(hold: ToolFaceHold, drilled_nothing: bool) -> list[tuple[str, str]]:
    if drilled_nothing:
        return [("toolface", "not evaluated: without drilling nothing turns the toolface")]
    rows = [
        (f"toolface error, mean ({hold.source})", f"{np.degrees(hold.mean_error):.1f} deg"),
        ("toolface within 15 deg", f"{100.0 * hold.on_target:.0f} % of the time"),
    ]
    for target in hold.targets:
        which = f" at {np.degrees(target.target):.0f} deg" if len(hold.targets) > 1 else ""
        rows.append((f"toolface set{which}", hold_sentence(target)))
    return rows


def hold_sentence(hold: TargetHold) -> str:
    """How one target was held, as a phrase to follow "set"."""
    if hold.set_after is None or hold.error_once_set is None:
        return f"never: {NOT_SET}"
    error = f"{np.degrees(hold.error_once_set):.1f} deg mean error"
    if hold.lost_after is None:
        return f"after {hold.set_after:.0f} s, {error} from there"
    return f"after {hold.set_after:.0f} s, {error} until lost after {hold.lost_after:.0f} s"


def run_summary_table(summary: RunSummary, more: tuple[tuple[str, str], ...] = (), units: Units = SI) -> Table:
    """The summary as a table for the terminal; `more`: rows after it."""
    table = Table(box=SIMPLE_HEAD, show_header=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, value in (*summary_rows(summary, units), *more):
        table.add_row(name, value)
    return table
