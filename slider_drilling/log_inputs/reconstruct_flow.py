"""Flow of a pump that was not logged, as far as the standpipe pressure shows it."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.log_inputs.fill_pump_gaps import locate_flow_change
from slider_drilling.rig import FLOW_EXPONENT, Rig

PressureSteps = tuple[tuple[float, float], ...]
"""Times (s) at which pressure steps, and by how much (Pa)."""
# Of the pressure that circulation at the reference flow needs. Below the first the pump is slower whatever the motor
# does, since the rig file errs by less; the second is the smallest step.
_REDUCED, _MIN_STEP = 0.7, 0.05
_SETTLED = 6.0  # lags after which pressure has reached its new level
_REACH = 4.0  # lags before and after a moment that show whether pressure steps there
_MIN_EXPLAINED = 0.8  # of what a parabola leaves of that stretch, by a step
_MIN_SAMPLES, _MAX_STEPS = 3, 6  # samples on either side of a step; steps per run, the largest
_MAX_MISMATCH = 0.25  # of a step, between a step down and the step back: the motor's part changes meanwhile


def flow_fraction(time: Array, pressure: Array, steps: PressureSteps, rig: Rig) -> Array:
    """Flow over the reference flow.

    It is below 1 where circulation alone would need more pressure than was measured, and between a step down and an
    equal step up, where the pump was set to another speed and back.

    Args:
        time, pressure: Standpipe pressure, s and Pa, (m,), finite.
        steps: Those that `pressure_steps` found.

    Returns:
        (m,).
    """
    needed = rig.circulating_pressure
    fraction = np.clip(pressure / needed, 0.0, None) ** (1.0 / FLOW_EXPONENT)
    fraction = np.where(pressure < _REDUCED * needed, fraction, 1.0)
    for (begin, down), (end, up) in itertools.pairwise(steps):
        size = 0.5 * (up - down)
        if down < 0.0 < up and abs(up + down) < _MAX_MISMATCH * size and size < needed:
            between = (time >= begin) & (time < end)
            fraction[between] = np.minimum(fraction[between], (1.0 - size / needed) ** (1.0 / FLOW_EXPONENT))
    return fraction


def flow_reduced(time: Array, pressure: Array, rig: Rig) -> NDArray[np.bool_]:
    """Where the pump runs much slower than at the reference flow, or did some lags before, (m,).

    Pressure does not show how its speed changed there.
    """
    low = pressure < _REDUCED * rig.circulating_pressure
    reach = _SETTLED * rig.hydraulics.lag
    until, since = (np.searchsorted(time[low], time + side * reach) for side in (1.0, -1.0))
    return np.asarray(until > since)


def pressure_steps(time: Array, pressure: Array, rig: Rig) -> PressureSteps:
    """Steps of a pressure (m,) Pa, finite, as a pump that is set to another speed makes them.

    A motor makes such steps too, when a string breaks free. A fit decides which of the two made each.
    """
    interval = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    reach = round(_REACH * rig.hydraulics.lag / interval) if interval > 0.0 else 0
    if reach < _MIN_SAMPLES or time.size < 2 * reach + 1:
        return ()
    grid = np.arange(time[0], time[-1], interval)
    size, explained = _step_at_each(np.interp(grid, time, pressure), reach, interval / rig.hydraulics.lag)
    large = np.abs(size) > _MIN_STEP * rig.circulating_pressure
    size = np.where(large & (explained > _MIN_EXPLAINED), size, 0.0)
    steps: list[tuple[float, float]] = []
    while len(steps) < _MAX_STEPS and size.any():
        peak = int(np.abs(size).argmax())
        around = slice(*np.searchsorted(time, (grid[peak], grid[min(peak + 2 * reach, grid.size - 1)])))
        steps.append((locate_flow_change(time[around], pressure[around]), float(size[peak])))
        size[max(peak - reach, 0) : peak + reach] = 0.0
    return tuple(sorted(steps))


def _step_at_each(pressure: Array, reach: int, interval: float) -> tuple[Array, Array]:
    """Least squares of a lagged step beside a parabola, at every sample that has `reach` others on both sides.

    Args:
        pressure: Pa, (n,), evenly sampled.
        interval: Between samples, in lags.

    Returns:
        Size of the step (n - 2 reach,) Pa, and the fraction that it explains of what the parabola leaves.
    """
    u = np.arange(-reach, reach + 1) * interval
    smooth = np.linalg.qr(np.stack([np.ones_like(u), u, u**2], axis=1))[0]
    step = -np.expm1(-np.maximum(u, 0.0))
    step -= smooth @ (smooth.T @ step)
    centred = pressure - pressure.mean()
    residual = np.correlate(centred**2, np.ones_like(u)) - sum(np.correlate(centred, row) ** 2 for row in smooth.T)
    size = np.correlate(centred, step) / (step @ step)
    return size, size**2 * (step @ step) / np.maximum(residual, 1e-300)
