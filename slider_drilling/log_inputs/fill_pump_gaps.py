"""When a pump changed its speed while its samples were lost: the standpipe pressure saw it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.log_inputs.fill_drive_gaps import hidden_speed_changes

_CHANGED = 2e-3  # of the pump's speed
_JITTERS = 5.0  # times what it commonly changes by between two samples
# Samples of pressure on either side that say what it was before and what it goes to, not longer than s: the motor's
# share of it changes too; and the fewest that do.
_BESIDE, _BESIDE_S, _FEWEST = 10, 5.0, 3
# A change of pressure shows where it is more than so many times what it leaves unexplained.
_CLEAR = 4.0
# Moments that are looked at in one stretch, and times s in which a column of mud takes up another flow.
_MOMENTS, _LAGS_S = 61, np.geomspace(0.02, 5.0, 60)


def fill_pump_gaps(time: Array, speed: Array, seen: Array, pressure: Array) -> tuple[Array, Array]:
    """The pump's samples (n,), s, rad/s, and where some were lost, or come too seldom, the moment at which its speed
    changed.

    seen, pressure: (m,), s, Pa, NaN where there is none. A straight line from one speed to the other is off by up to
    half of the stretch, and what the motor does meanwhile lasts. Pressure begins to follow the flow at once: it tells
    when one even flow became the other. Where it shows no such change the line stays.
    """
    known = np.isfinite(pressure)
    seen, pressure = seen[known], pressure[known]
    found: list[tuple[float, float]] = []
    for index in hidden_flow_changes(time, speed):
        before, after = float(speed[index]), float(speed[index + 1])
        moments = _moment(float(time[index]), float(time[index + 1]), seen, pressure, after > before)
        found += zip(moments, (before, after), strict=False)
    if not found:
        return time, speed
    rows = np.vstack([np.column_stack([time, speed]), found])
    rows = rows[np.argsort(rows[:, 0])]
    return rows[:, 0], rows[:, 1]


def hidden_flow_changes(time: Array, speed: Array) -> NDArray[np.int_]:
    """Indices of the pump's samples (n,) after which its speed became another unseen, by more than it commonly varies:
    pressure goes with the square of the flow, and a sensor shows a thousandth of it.
    """
    hidden, steps = hidden_speed_changes(time, speed), np.abs(np.diff(speed))
    if hidden.size == 0:
        return hidden
    least = max(_CHANGED * float(np.max(np.abs(speed))), _JITTERS * float(np.median(steps)))
    return hidden[steps[hidden] > least]


def _moment(begin: float, end: float, seen: Array, pressure: Array, rises: bool) -> tuple[float, ...]:
    """The times s, close together, between which the flow changed inside a stretch; empty where pressure does not show
    that it was even before, and went closer and closer to another level on the right side from some moment on.
    """
    first, last = np.searchsorted(seen, begin, side="right"), np.searchsorted(seen, end)
    if min(first, seen.size - last) < _FEWEST:
        return ()
    interval = float(np.median(np.diff(seen)))
    beside = int(np.clip(_BESIDE_S / interval, _FEWEST, _BESIDE))
    here = slice(max(first - beside, 0), last + beside)
    moments = np.linspace(begin, end, _MOMENTS)[1:-1]
    # One moment after the other: a stretch may be an hour of pressure.
    left, change, moment = min((*_explained(seen[here], pressure[here], one), float(one)) for one in moments)
    if not (change if rises else -change) > _CLEAR * left:
        return ()
    half = 0.5 * (end - begin) / _MOMENTS
    return moment - half, moment + half


def locate_flow_change(time: Array, pressure: Array) -> float:
    """The moment s at which the likeliest change of the flow begins in a pressure (n,) that holds one."""
    moments = np.linspace(time[0], time[-1], _MOMENTS)[1:-1]
    return min((_explained(time, pressure, float(one))[0], float(one)) for one in moments)[1]


def _explained(time: Array, pressure: Array, moment: float) -> tuple[float, float]:
    """RMS that the likeliest change beginning at a moment leaves of a pressure (n,), and how large that change is."""
    # A straight line through pressure against the share of the change that is done, for every lag.
    done = -np.expm1(-np.maximum(time - moment, 0.0) / _LAGS_S[:, None])
    done -= done.mean(axis=1, keepdims=True)
    measured = pressure - pressure.mean()
    changes = (done @ measured) / np.sum(done**2, axis=1)
    left = np.sqrt(np.mean((measured - changes[:, None] * done) ** 2, axis=1))
    best = int(np.argmin(left))
    return float(left[best]), float(changes[best])
