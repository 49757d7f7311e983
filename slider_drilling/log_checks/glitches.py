"""Check for glitches: up to three samples that jump away and back faster than a rig can; mask them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, median_filter

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array, JointSeries, ScalarSeries
from slider_drilling.log_checks.issue import LogIssue
from slider_drilling.log_inputs.fill_drive_gaps import is_undersampled
from slider_drilling.rig import Rig
from slider_drilling.units import Quantity, sentence
from slider_drilling.wellbore.static_loads import static_loads

Series = TypeVar("Series", JointSeries, ScalarSeries)

# Samples of the running median, and of the longest glitch.
_WINDOW, _MAX_LENGTH = 7, 3
# A glitch departs from the running median by this many times the usual departure, and by this share of the range of
# nine tenths of the samples. Waves in a string take several tenths of a second for that. With samples farther apart
# the rig itself may do it: then only a departure of the rig's own size counts.
_SCATTERS, _RANGE = 12.0, 0.5
_LEVEL = 0.05  # of the channel's level, if it is constant otherwise
_MAX_SHARE = 0.01  # of the samples: what happens more often is signal
_MAX_BLOCK_SPEED = 5.0  # m/s


@dataclass(frozen=True)
class _Column:
    """One array of a series.

    Attributes:
        name: In words.
        unit: Of its values.
        field: Name in the series.
        size: Largest change that the rig makes in this channel.
        min_jump: Smallest jump that no rig makes in one sample; None if motion limits do not say.
        explained: (n,) where another channel explains a jump.
    """

    name: str
    unit: str
    field: str
    size: float
    min_jump: float | None = None
    explained: NDArray[np.bool_] | None = None


def mask_glitches(log: RigLog, rig: Rig) -> tuple[RigLog, list[LogIssue]]:
    """Make glitches of the surface channels NaN.

    Returns:
        The masked log, and a note for each channel that had glitches.
    """
    drive, hydraulics = rig.top_drive, rig.hydraulics
    hanging = static_loads(rig, elements=50).hook_load
    pressure = hydraulics.reference_pressure + rig.motor.pressure_at_stall
    pump = rig.reference_pump_speed
    issues: list[LogIssue] = []

    def masked(series: Series | None, columns: Callable[[float], Sequence[_Column]]) -> Series | None:
        if series is None or series.time.size <= _WINDOW:
            return series
        interval = float(np.median(np.diff(series.time)))
        changed = {}
        for column in columns(interval):
            values, note = _masked(column, series.time, getattr(series, column.field))
            if note is not None:
                changed[column.field] = values
                issues.append(note)
        return replace(series, **changed)

    log = replace(
        log,
        top_drive=masked(log.top_drive, lambda dt: (
            _Column("top-drive angle", "rad", "position", 0.0, 2.0 * drive.max_speed * dt),
            _Column("top-drive speed", "rad/s", "velocity", 0.0, drive.max_acceleration * dt),
            _Column("surface_torque", "N m", "effort", drive.max_torque, explained=_accelerating(log.top_drive)),
        )),
        draw_works=masked(log.draw_works, lambda dt: (
            _Column("block position", "m", "position", 0.0, _MAX_BLOCK_SPEED * dt),
            _Column("block speed", "m/s", "velocity", 0.0, _MAX_BLOCK_SPEED),
            _Column("hook_load", "N", "effort", hanging),
        )),
        standpipe_pressure=masked(
            log.standpipe_pressure, lambda dt: (_Column("standpipe_pressure", "Pa", "value", pressure),)
        ),
        mud_pump=masked(log.mud_pump, lambda dt: (_Column("pump speed", "rad/s", "velocity", pump),)),
    )  # fmt: skip
    return log, issues


def _accelerating(drive: JointSeries | None) -> NDArray[np.bool_] | None:
    """(n,) where the top drive changes its speed: torque read at its motor jumps there."""
    if drive is None or drive.velocity.size < 2 or not np.isfinite(drive.velocity).any():
        return None
    change = np.abs(np.diff(drive.velocity, prepend=drive.velocity[:1])) > 0.1 * np.nanmax(np.abs(drive.velocity))
    return change | np.r_[change[1:], False]


def _masked(column: _Column, time: Array, values: Array) -> tuple[Array, LogIssue | None]:
    # Samples may be so far apart that a real change looks like a jump: it must then be as large as the rig's own.
    min_jump = column.size if is_undersampled(time) and column.min_jump is None else column.min_jump
    where = find_glitches(time, values, min_jump)
    if column.explained is not None:
        where = where & ~column.explained
    if not where.any():
        return values, None
    worst = int(np.flatnonzero(where)[np.argmax(np.abs(values[where] - np.nanmedian(values)))])
    count = int(np.count_nonzero(where))
    text = sentence(
        f"{column.name}: {count} of {values.size} samples {'is a glitch' if count == 1 else 'are glitches'} and left "
        f"out (the largest at {time[worst]:.1f} s: ", Quantity(float(values[worst]), column.unit, 4), ")",
    )  # fmt: skip
    return np.where(where, np.nan, values), LogIssue("note", column.name, text)


def find_glitches(time: Array, values: Array, min_jump: float | None = None) -> NDArray[np.bool_]:
    """Find up to three samples in a row that depart from their neighbourhood and return to it at once.

    Args:
        time: (n,) s, ascending.
        values: (n,); NaN where a sample is missing.
        min_jump: Smallest departure that counts, in the unit of the values; by default half of their range. Across
            missing samples it grows with the number of intervals, in which the rig had time to move.

    Returns:
        (n,) True at glitches; nowhere if more than one sample in a hundred would be one.
    """
    is_glitch = np.zeros(values.shape, dtype=bool)
    known = np.flatnonzero(np.isfinite(values))
    if known.size <= _WINDOW:
        return is_glitch
    samples, intervals = values[known], np.diff(time[known])
    intervals = np.maximum(intervals / np.median(intervals), 1.0)
    departure = np.abs(samples - median_filter(samples, _WINDOW, mode="nearest"))
    if min_jump is None:
        low, high = np.quantile(samples, (0.05, 0.95))
        min_jump = max(_RANGE * (high - low), _LEVEL * float(np.median(np.abs(samples))))
    # 1.4826 times the median departure is a robust standard deviation.
    min_jump = max(_SCATTERS * 1.4826 * float(np.median(departure)), min_jump)
    nearby = maximum_filter1d(np.maximum(np.r_[1.0, intervals], np.r_[intervals, 1.0]), _WINDOW)
    apart = departure > min_jump * nearby
    if not apart.any() or np.count_nonzero(apart) > _MAX_SHARE * samples.size:
        return is_glitch
    edges = np.flatnonzero(np.diff(np.r_[False, apart, False].astype(int)))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        around = slice(max(start - 1, 0), end + 1)
        steps = np.abs(np.diff(samples[around])) / intervals[around.start : around.stop - 1]
        left_and_returned = min(steps[0], steps[-1]) > 0.8 * min_jump
        if end - start > _MAX_LENGTH or not left_and_returned:
            apart[start:end] = False
    is_glitch[known[apart]] = True
    return is_glitch
