"""Values that were logged again and again before they were renewed: only what is new was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.log.series import Array, RigLog
from slider_drilling.log_checks.issue import LogIssue

# Renewals that say whether a column is held between them, and how many of these may follow upon one another at once.
_FEWEST, _AT_ONCE = 20, 0.02
_SOONEST = 0.05  # of the renewals: a drive that turns evenly has the same speed for many of them
_BESIDE = 0.5  # of the interval between samples: a stamp that is farther from a renewal is of another sample
# By how much larger the share of equal steps is than that of equal times between them where a sensor is coarse: of an
# even motion both are equal.
_COARSE = 0.2
_SERIES = {
    "top_drive": {"position": "top-drive angle", "velocity": "top-drive speed", "effort": "surface_torque"},
    "draw_works": {"position": "block position", "velocity": "block speed", "effort": "hook_load"},
    "standpipe_pressure": {"value": "standpipe_pressure"},
    "mud_pump": {"velocity": "pump speed"},
}


@dataclass(frozen=True)
class _RenewalTimes:
    """When a column is renewed. at: (m,) s, ascending, of renewals that were seen; every: s between renewals; logged: s
    between samples.
    """

    at: Array
    every: float
    logged: float

    def new(self, time: Array) -> NDArray[np.bool_]:
        """(n,) which samples are renewals, seen or not: those of which the stamp is an instant of this clock. Where
        that sample was lost the next one says what was measured then, and nothing of now.
        """
        instants = self._instants(float(time[0]), float(time[-1]))
        first = np.searchsorted(time, instants - _BESIDE * self.logged)
        first = first[first < time.size]
        found = np.zeros(time.size, dtype=bool)
        found[first[time[first] < instants[: first.size] + _BESIDE * self.logged]] = True
        return found

    def _instants(self, begin: float, end: float) -> Array:
        """From one renewal that was seen to the next as many as come between; before and behind them evenly."""
        before = self.at[0] - self.every * np.arange(int((self.at[0] - begin) / self.every + _BESIDE), 0, -1)
        behind = self.at[-1] + self.every * np.arange(1, int((end - self.at[-1]) / self.every + _BESIDE) + 1)
        steps = np.maximum(np.round(np.diff(self.at) / self.every), 1.0)
        count = np.concatenate([[0.0], np.cumsum(steps)])
        return np.concatenate([before, np.interp(np.arange(count[-1] + 1.0), count, self.at), behind])

    def holds(self, changes: Array) -> bool:
        """Whether every one of the times s (k,) is an instant of this clock."""
        return changes.size == 0 or bool(self.new(changes).all())


def mask_repeated_samples(log: RigLog) -> tuple[RigLog, list[LogIssue]]:
    """The log with NaN for every sample that repeats the one before in a column which is renewed more seldom than it
    is logged, as a bus or a historian holds it, and a note that names them.

    A column that hardly changes is renewed with the others of its message if it changes with them alone, a pump's speed
    with the other messages.
    """
    held: dict[tuple[str, str], list[str]] = {}
    common: _RenewalTimes | None = None
    for name, columns in _SERIES.items():
        series: Any = getattr(log, name)
        if series is None or series.time.size < 2:
            continue
        clocks = _clocks(series.time, {column: getattr(series, column) for column in columns}, common)
        common = next((clock for clock in clocks.values()), common)
        kept = {}
        for column, clock in clocks.items():
            kept[column] = np.where(clock.new(series.time), getattr(series, column), np.nan)
            held.setdefault((f"{clock.every:.3g}", f"{clock.logged:.3g}"), []).append(columns[column])
        changed: dict[str, Any] = {name: replace(series, **kept)}
        log = replace(log, **changed)
    return log, [
        LogIssue(
            "note", "clock",
            f"{', '.join(words)}: logged every {logged} s and renewed every {renewed} s: samples that only repeat the "
            "one before are left out",
        )
        for (renewed, logged), words in held.items()
    ]  # fmt: skip


def _clocks(time: Array, columns: dict[str, Array], common: _RenewalTimes | None) -> dict[str, _RenewalTimes]:
    """The clocks of the columns that are held; common: of other messages, for one whose columns hardly change."""
    interval = float(np.median(np.diff(time)))
    changes = {column: _changes(time, values, interval) for column, values in columns.items()}
    found = {column: own for column, one in changes.items() if (own := _clock(*one, interval)) is not None}
    if found:
        common = min(found.values(), key=lambda one: one.every)
    elif common is None or not 0 < max(at.size for at, _ in changes.values()) < _FEWEST:
        return {}
    for column, (at, _) in changes.items():
        if column not in found and np.isfinite(columns[column]).any() and common.holds(at):
            found[column] = common
    return {column: found[column] for column in columns if column in found}


def _changes(time: Array, values: Array, interval: float) -> tuple[Array, Array]:
    """Times s, (k,), at which a column (n,) has another value than in the sample before, none being lost between (a
    renewal that was lost shows too late), and by how much it is another.
    """
    known = np.isfinite(values)
    at, value = time[known], values[known]
    steps = np.diff(value)
    seen = (steps != 0.0) & (np.diff(at) < (1.0 + _BESIDE) * interval)
    return at[1:][seen], steps[seen]


def _clock(changes: Array, steps: Array, interval: float) -> _RenewalTimes | None:
    """None where values are renewed with every sample, where too few changes (k,), s, could say, or where these are
    more alike in size than in time: a coarse sensor's value steps when it comes to the next.
    """
    gaps, sizes = np.diff(changes), np.abs(steps)
    if gaps.size < _FEWEST or np.mean(gaps < (1.0 + _BESIDE) * interval) > _AT_ONCE:
        return None
    if _alike(sizes, 1e-6 * float(np.median(sizes))) > _alike(gaps, _BESIDE * interval) + _COARSE:
        return None
    soonest = float(np.quantile(gaps, _SOONEST))
    return _RenewalTimes(changes, float(np.mean(gaps[gaps < (1.0 + _BESIDE) * soonest])), interval)


def _alike(values: Array, within: float) -> float:
    """Share of values (k,) that are their median, or are within so much of it."""
    return float(np.mean(np.abs(values - np.median(values)) <= within))
