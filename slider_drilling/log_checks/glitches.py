"""Single samples that no rig makes: found, masked and said."""

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
from slider_drilling.log_inputs.fill_drive_gaps import too_seldom
from slider_drilling.rig import Rig
from slider_drilling.wellbore.static_loads import static_loads

Series = TypeVar("Series", JointSeries, ScalarSeries)

_WINDOW, _LONGEST = 7, 3  # samples of the running median; of one glitch
# A glitch stands out of its neighbourhood by this many times the usual scatter there, and leaves it and returns in one
# sample each by this share of the range that nine tenths of the samples have. Waves in a string take several tenths of
# a second to do that; where samples are farther apart it may be the rig, and only a leap by the rig's own size counts.
_SCATTERS, _RANGE = 12.0, 0.5
_LEVEL = 0.05  # of the channel's own level, where it is constant otherwise
_MOST = 0.01  # of the samples; what happens more often is no glitch
_FASTEST_BLOCK = 5.0  # m/s


@dataclass(frozen=True)
class _Column:
    """One array of a series. leap: the smallest that no rig makes in one sample, where the motion's limits tell;
    size: of what the rig does in this channel, both in its unit; caused: (n,) where a leap has a cause in the log."""

    name: str
    unit: str
    field: str
    size: float
    leap: float | None = None
    caused: NDArray[np.bool_] | None = None


def mask_glitches(log: RigLog, rig: Rig) -> tuple[RigLog, list[LogIssue]]:
    """The log with glitches of its surface channels made NaN, and a note for each channel that had some."""
    drive, hydraulics = rig.top_drive, rig.hydraulics
    hanging = static_loads(rig, elements=50).hook_load
    pressure = hydraulics.reference_pressure + rig.motor.max_pressure
    pump = hydraulics.reference_flow / rig.mud_pump.displacement
    found: list[LogIssue] = []

    def masked(series: Series | None, columns: Callable[[float], Sequence[_Column]]) -> Series | None:
        if series is None or series.time.size <= _WINDOW:
            return series
        interval = float(np.median(np.diff(series.time)))
        changed = {}
        for column in columns(interval):
            values, note = _masked(column, series.time, getattr(series, column.field))
            if note is not None:
                changed[column.field] = values
                found.append(note)
        return replace(series, **changed)

    log = replace(
        log,
        top_drive=masked(log.top_drive, lambda dt: (
            _Column("top-drive angle", "rad", "position", 0.0, 2.0 * drive.max_speed * dt),
            _Column("top-drive speed", "rad/s", "velocity", 0.0, drive.max_acceleration * dt),
            _Column("surface_torque", "N m", "effort", drive.max_torque, caused=_speeding(log.top_drive)),
        )),
        draw_works=masked(log.draw_works, lambda dt: (
            _Column("block position", "m", "position", 0.0, _FASTEST_BLOCK * dt),
            _Column("block speed", "m/s", "velocity", 0.0, _FASTEST_BLOCK),
            _Column("hook_load", "N", "effort", hanging),
        )),
        standpipe_pressure=masked(
            log.standpipe_pressure, lambda dt: (_Column("standpipe_pressure", "Pa", "value", pressure),)
        ),
        mud_pump=masked(log.mud_pump, lambda dt: (_Column("pump speed", "rad/s", "velocity", pump),)),
    )  # fmt: skip
    return log, found


def _speeding(drive: JointSeries | None) -> NDArray[np.bool_] | None:
    """(n,) where the top drive changes its speed: a torque that is read at its motor leaps with that."""
    if drive is None or drive.velocity.size < 2 or not np.isfinite(drive.velocity).any():
        return None
    change = np.abs(np.diff(drive.velocity, prepend=drive.velocity[:1])) > 0.1 * np.nanmax(np.abs(drive.velocity))
    return change | np.r_[change[1:], False]


def _masked(column: _Column, time: Array, values: Array) -> tuple[Array, LogIssue | None]:
    where = find_glitches(time, values, column.size if too_seldom(time) and column.leap is None else column.leap)
    if column.caused is not None:
        where = where & ~column.caused
    if not where.any():
        return values, None
    worst = int(np.flatnonzero(where)[np.argmax(np.abs(values[where] - np.nanmedian(values)))])
    count = int(np.count_nonzero(where))
    text = (
        f"{column.name}: {count} of {values.size} samples {'is' if count == 1 else 'are'} no reading of a rig "
        f"({values[worst]:.4g} {column.unit} at {time[worst]:.1f} s) and left out"
    )
    return np.where(where, np.nan, values), LogIssue("note", column.name, text)


def find_glitches(time: Array, values: Array, least: float | None = None) -> NDArray[np.bool_]:
    """(n,) whether each sample is a glitch: up to three that leave their neighbourhood and return to it at once.

    least: the smallest departure that counts, in the values' unit, by default half of their range; where samples were
    lost as many times as large as intervals passed, for which the rig had the time. None are where more than a
    hundredth of the samples would be: what happens that often is the signal's own.
    """
    nothing = np.zeros(values.shape, dtype=bool)
    known = np.flatnonzero(np.isfinite(values))
    if known.size <= _WINDOW:
        return nothing
    own, passed = values[known], np.diff(time[known])
    passed = np.maximum(passed / np.median(passed), 1.0)
    departure = np.abs(own - median_filter(own, _WINDOW, mode="nearest"))
    if least is None:
        low, high = np.quantile(own, (0.05, 0.95))
        least = max(_RANGE * (high - low), _LEVEL * float(np.median(np.abs(own))))
    least = max(_SCATTERS * 1.4826 * float(np.median(departure)), least)
    apart = departure > least * maximum_filter1d(np.maximum(np.r_[1.0, passed], np.r_[passed, 1.0]), _WINDOW)
    if not apart.any() or np.count_nonzero(apart) > _MOST * own.size:
        return nothing
    edges = np.flatnonzero(np.diff(np.r_[False, apart, False].astype(int)))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        around = slice(max(begin - 1, 0), end + 1)
        steps = np.abs(np.diff(own[around])) / passed[around.start : around.stop - 1]
        left_and_returned = min(steps[0], steps[-1]) > 0.8 * least
        if end - begin > _LONGEST or not left_and_returned:
            apart[begin:end] = False
    nothing[known[apart]] = True
    return nothing
