"""Check for values that were logged more often than they were renewed; mask samples that only repeat the one before."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.log_checks.issue import LogIssue

# Renewals needed to decide, and the share of them that may follow one another in consecutive samples.
_MIN_RENEWALS, _MAX_CONSECUTIVE = 20, 0.02
# Quantile of the intervals between changes that counts as the shortest: an evenly turning drive repeats its speed.
_SHORTEST = 0.05
_TOLERANCE = 0.5  # sampling intervals: a stamp that is farther from a renewal belongs to another sample
# A coarse sensor steps by equal amounts rather than at equal times: its share of equal steps is larger by this.
_COARSE = 0.2
_COLUMNS = {
    "top_drive": {"position": "top-drive angle", "velocity": "top-drive speed", "effort": "surface_torque"},
    "draw_works": {"position": "block position", "velocity": "block speed", "effort": "hook_load"},
    "standpipe_pressure": {"value": "standpipe_pressure"},
    "mud_pump": {"velocity": "pump speed"},
}


@dataclass(frozen=True)
class _RenewalTimes:
    """When a column is renewed.

    Attributes:
        seen: (m,) s, ascending: renewals that changed the value.
        period: s between renewals.
        interval: s between samples.
    """

    seen: Array
    period: float
    interval: float

    def is_renewal(self, time: Array) -> NDArray[np.bool_]:
        """(n,) which samples are stamped at a renewal, whether it changed the value or not.

        If that sample was lost, the next one shows an old measurement and is no renewal.
        """
        expected = self._expected(float(time[0]), float(time[-1]))
        first = np.searchsorted(time, expected - _TOLERANCE * self.interval)
        first = first[first < time.size]
        renewal = np.zeros(time.size, dtype=bool)
        renewal[first[time[first] < expected[: first.size] + _TOLERANCE * self.interval]] = True
        return renewal

    def _expected(self, start: float, end: float) -> Array:
        """All renewal times: interpolated between those seen, extrapolated evenly before and after them."""
        count_before = int((self.seen[0] - start) / self.period + _TOLERANCE)
        before = self.seen[0] - self.period * np.arange(count_before, 0, -1)
        after = self.seen[-1] + self.period * np.arange(1, int((end - self.seen[-1]) / self.period + _TOLERANCE) + 1)
        steps = np.maximum(np.round(np.diff(self.seen) / self.period), 1.0)
        count = np.concatenate([[0.0], np.cumsum(steps)])
        return np.concatenate([before, np.interp(np.arange(count[-1] + 1.0), count, self.seen), after])

    def includes(self, changes: Array) -> bool:
        """Whether all of these times (k,), s, are renewals."""
        return changes.size == 0 or bool(self.is_renewal(changes).all())


def mask_repeated_samples(log: RigLog) -> tuple[RigLog, list[LogIssue]]:
    """Make samples NaN that only repeat the one before, in columns that are renewed less often than they are logged.

    A fieldbus or a historian holds a value until it is renewed. A column that hardly changes is taken to be renewed
    with the others of its message, a pump's speed with the other messages.

    Returns:
        The masked log, and one note for all columns with the same times.
    """
    columns_of: dict[tuple[str, str], list[str]] = {}
    shared: _RenewalTimes | None = None
    for name, columns in _COLUMNS.items():
        series: Any = getattr(log, name)
        if series is None or series.time.size < 2:
            continue
        renewals = _renewals(series.time, {column: getattr(series, column) for column in columns}, shared)
        shared = next(iter(renewals.values()), shared)
        masked = {}
        for column, times in renewals.items():
            masked[column] = np.where(times.is_renewal(series.time), getattr(series, column), np.nan)
            columns_of.setdefault((f"{times.period:.3g}", f"{times.interval:.3g}"), []).append(columns[column])
        changed: dict[str, Any] = {name: replace(series, **masked)}
        log = replace(log, **changed)
    return log, [
        LogIssue(
            "note", "clock",
            f"{', '.join(names)}: logged every {interval} s but renewed every {period} s: repeated samples are left "
            "out",
        )
        for (period, interval), names in columns_of.items()
    ]  # fmt: skip


def _renewals(time: Array, columns: dict[str, Array], shared: _RenewalTimes | None) -> dict[str, _RenewalTimes]:
    """Renewal times of the columns that are held; shared: of other messages, for a column that hardly changes."""
    interval = float(np.median(np.diff(time)))
    changes = {column: _changes(time, values, interval) for column, values in columns.items()}
    known = {
        column: times for column, change in changes.items() if (times := _renewal_times(*change, interval)) is not None
    }
    if known:
        shared = min(known.values(), key=lambda times: times.period)
    elif shared is None or not 0 < max(at.size for at, _ in changes.values()) < _MIN_RENEWALS:
        return {}
    for column, (at, _) in changes.items():
        if column not in known and np.isfinite(columns[column]).any() and shared.includes(at):
            known[column] = shared
    return {column: known[column] for column in columns if column in known}


def _changes(time: Array, values: Array, interval: float) -> tuple[Array, Array]:
    """Times (k,), s, at which a column (n,) differs from the sample before, and by how much.

    Changes across a missing sample do not count: their renewal may be the missing one.
    """
    known = np.isfinite(values)
    at, value = time[known], values[known]
    steps = np.diff(value)
    seen = (steps != 0.0) & (np.diff(at) < (1.0 + _TOLERANCE) * interval)
    return at[1:][seen], steps[seen]


def _renewal_times(changes: Array, steps: Array, interval: float) -> _RenewalTimes | None:
    """Renewal times by the changes (k,), s, of a column; None if every sample renews it or too few changes tell.

    None also for a coarse sensor, whose steps are more alike in size than in time.
    """
    gaps, sizes = np.diff(changes), np.abs(steps)
    if gaps.size < _MIN_RENEWALS or np.mean(gaps < (1.0 + _TOLERANCE) * interval) > _MAX_CONSECUTIVE:
        return None
    if _equal_share(sizes, 1e-6 * float(np.median(sizes))) > _equal_share(gaps, _TOLERANCE * interval) + _COARSE:
        return None
    shortest = float(np.quantile(gaps, _SHORTEST))
    return _RenewalTimes(changes, float(np.mean(gaps[gaps < (1.0 + _TOLERANCE) * shortest])), interval)


def _equal_share(values: Array, tolerance: float) -> float:
    """Share of values (k,) that lie within a tolerance of their median."""
    return float(np.mean(np.abs(values - np.median(values)) <= tolerance))
