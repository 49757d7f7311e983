"""A pump that nobody logged: what standpipe pressure tells of its flow."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array
from slider_drilling.log_inputs.fill_pump_gaps import locate_flow_change
from slider_drilling.rig import Rig

# Times s, and Pa by which pressure steps then.
PressureSteps = tuple[tuple[float, float], ...]
# Of the pressure that circulation at the reference flow needs: below so much of it the pump is slower whatever the
# motor does, for the file may be off by no more; and what a step is from.
_SLOWER, _STEP = 0.7, 0.05
_SETTLED = 6.0  # lags in which pressure has gone to its new level
_REACH = 4.0  # lags before and behind a moment that tell whether pressure steps there
_STEPS = 0.8  # share of what a parabola leaves of that stretch, which a step explains
_FEWEST, _MOST = 3, 6  # samples on either side of a step; steps of a run, the largest
_BACK = 0.25  # of a step, by which the one back may differ: the motor's share has changed meanwhile


def flow_fraction(seen: Array, pressure: Array, steps: PressureSteps, rig: Rig) -> Array:
    """(m,) of the reference flow at the times s of a pressure Pa, finite, with these `flow_steps`: less than 1 where
    circulation alone needs more, and between a step down and one up by as much, when the pump was set to another speed
    and back.
    """
    needed = rig.circulating_pressure
    share = np.clip(pressure / needed, 0.0, None) ** (1.0 / 1.8)
    share = np.where(pressure < _SLOWER * needed, share, 1.0)
    for (begin, down), (end, up) in itertools.pairwise(steps):
        size = 0.5 * (up - down)
        if down < 0.0 < up and abs(up + down) < _BACK * size and size < needed:
            between = (seen >= begin) & (seen < end)
            share[between] = np.minimum(share[between], (1.0 - size / needed) ** (1.0 / 1.8))
    return share


def flow_reduced(seen: Array, pressure: Array, rig: Rig) -> NDArray[np.bool_]:
    """(m,) where the pump runs much slower than at the reference flow, or had done so some lags before: how its speed
    changed there nothing tells.
    """
    low = pressure < _SLOWER * rig.circulating_pressure
    reach = _SETTLED * rig.hydraulics.lag
    around = (np.searchsorted(seen[low], seen + side * reach) for side in (1.0, -1.0))
    behind, before = around
    return np.asarray(behind > before)


def pressure_steps(seen: Array, pressure: Array, rig: Rig) -> PressureSteps:
    """Times s at which pressure (m,), Pa at s, finite, steps as it does where a pump is set to another speed, and by
    how much Pa.

    So does what a motor does when a string breaks free: whether the pump did it a fit decides.
    """
    interval = float(np.median(np.diff(seen))) if seen.size > 1 else 0.0
    reach = round(_REACH * rig.hydraulics.lag / interval) if interval > 0.0 else 0
    if reach < _FEWEST or seen.size < 2 * reach + 1:
        return ()
    time = np.arange(seen[0], seen[-1], interval)
    size, explained = _step_at_each(np.interp(time, seen, pressure), reach, interval / rig.hydraulics.lag)
    size = np.where((np.abs(size) > _STEP * rig.circulating_pressure) & (explained > _STEPS), size, 0.0)
    found: list[tuple[float, float]] = []
    while len(found) < _MOST and size.any():
        peak = int(np.abs(size).argmax())
        around = slice(*np.searchsorted(seen, (time[peak], time[min(peak + 2 * reach, time.size - 1)])))
        found.append((locate_flow_change(seen[around], pressure[around]), float(size[peak])))
        size[max(peak - reach, 0) : peak + reach] = 0.0
    return tuple(sorted(found))


def _step_at_each(pressure: Array, reach: int, per_lag: float) -> tuple[Array, Array]:
    """For every stretch of so many samples before and behind a moment (n - 2 reach,): how far Pa pressure (n,), evenly
    sampled so many lags apart, steps at that moment beside a parabola, and which share that explains of what the
    parabola alone leaves.
    """
    u = np.arange(-reach, reach + 1) * per_lag
    smooth = np.linalg.qr(np.stack([np.ones_like(u), u, u**2], axis=1))[0]
    step = -np.expm1(-np.maximum(u, 0.0))
    step -= smooth @ (smooth.T @ step)
    about = pressure - pressure.mean()
    left = np.correlate(about**2, np.ones_like(u)) - sum(np.correlate(about, one) ** 2 for one in smooth.T)
    size = np.correlate(about, step) / (step @ step)
    return size, size**2 * (step @ step) / np.maximum(left, 1e-300)
