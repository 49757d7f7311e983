"""Speed of the pump while it was not logged: the standpipe pressure shows when it changed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.log_inputs.fill_drive_gaps import hidden_speed_changes

_MIN_CHANGE = 2e-3  # of the pump's speed
_MIN_JITTERS = 5.0  # times the usual change between two samples
# Samples of pressure on either side that show its levels before and after; not longer than the time, since the motor's
# part of the pressure changes too; and the fewest that are enough.
_BESIDE, _BESIDE_S, _MIN_BESIDE = 10, 5.0, 3
_MIN_RATIO = 4.0  # of a change of pressure to what it leaves unexplained
# Moments that are tried in one stretch, and lags (s) with which pressure follows the flow.
_MOMENTS, _LAGS_S = 61, np.geomspace(0.02, 5.0, 60)


def fill_pump_gaps(time: Array, speed: Array, pressure_time: Array, pressure: Array) -> tuple[Array, Array]:
    """The pump's samples, with the moment of each unseen change of speed added.

    A straight line from one speed to the other is wrong by up to half of the gap, and what the motor does meanwhile
    lasts. Pressure follows the flow without delay, so it shows when one constant flow became the other. Where it shows
    no such change the straight line stays.

    Args:
        time, speed: s and rad/s, (n,).
        pressure_time, pressure: Standpipe pressure, s and Pa, (m,); NaN where unknown.

    Returns:
        Time and speed with the added samples.
    """
    known = np.isfinite(pressure)
    pressure_time, pressure = pressure_time[known], pressure[known]
    added: list[tuple[float, float]] = []
    for index in hidden_flow_changes(time, speed):
        before, after = float(speed[index]), float(speed[index + 1])
        moments = _moment(float(time[index]), float(time[index + 1]), pressure_time, pressure, after > before)
        added += zip(moments, (before, after), strict=False)
    if not added:
        return time, speed
    rows = np.vstack([np.column_stack([time, speed]), added])
    rows = rows[np.argsort(rows[:, 0])]
    return rows[:, 0], rows[:, 1]


def hidden_flow_changes(time: Array, speed: Array) -> NDArray[np.int_]:
    """Indices of the pump's samples (n,) after which its speed changed unseen, by more than it usually varies.

    Pressure goes with the square of the flow, and a sensor shows a change of one in a thousand.
    """
    hidden, steps = hidden_speed_changes(time, speed), np.abs(np.diff(speed))
    if hidden.size == 0:
        return hidden
    least = max(_MIN_CHANGE * float(np.max(np.abs(speed))), _MIN_JITTERS * float(np.median(steps)))
    return hidden[steps[hidden] > least]


def _moment(begin: float, end: float, time: Array, pressure: Array, rises: bool) -> tuple[float, ...]:
    """Two close times (s) around the change of flow inside a stretch, or nothing.

    Nothing is returned unless pressure was even before and then approached another level, higher where the flow rises.
    """
    first, last = np.searchsorted(time, begin, side="right"), np.searchsorted(time, end)
    if min(first, time.size - last) < _MIN_BESIDE:
        return ()
    interval = float(np.median(np.diff(time)))
    beside = int(np.clip(_BESIDE_S / interval, _MIN_BESIDE, _BESIDE))
    here = slice(max(first - beside, 0), last + beside)
    moments = np.linspace(begin, end, _MOMENTS)[1:-1]
    # One moment at a time: a stretch may hold an hour of pressure.
    residual, change, moment = min((*_fit_change(time[here], pressure[here], at), float(at)) for at in moments)
    if not (change if rises else -change) > _MIN_RATIO * residual:
        return ()
    half = 0.5 * (end - begin) / _MOMENTS
    return moment - half, moment + half


def locate_flow_change(time: Array, pressure: Array) -> float:
    """The moment (s) of the change of flow that fits a pressure (n,) Pa best."""
    moments = np.linspace(time[0], time[-1], _MOMENTS)[1:-1]
    return min((_fit_change(time, pressure, float(at))[0], float(at)) for at in moments)[1]


def _fit_change(time: Array, pressure: Array, moment: float) -> tuple[float, float]:
    """Least squares of one change of level that begins at a moment: RMS of the residual and size, Pa; best lag."""
    # For every lag: a straight line through pressure against the completed fraction of the change.
    done = -np.expm1(-np.maximum(time - moment, 0.0) / _LAGS_S[:, None])
    done -= done.mean(axis=1, keepdims=True)
    measured = pressure - pressure.mean()
    changes = (done @ measured) / np.sum(done**2, axis=1)
    residual = np.sqrt(np.mean((measured - changes[:, None] * done) ** 2, axis=1))
    best = int(np.argmin(residual))
    return float(residual[best]), float(changes[best])
