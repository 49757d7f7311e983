"""Angle or position from a recorded speed, with the error that coarse samples leave, and never over a gap."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A gap is this many usual steps long, and this many s.
_GAP_STEPS, _MIN_GAP_S = 3.0, 0.5
# Standard error of the trapezoidal rule in one step, per second difference of the speed times the step. A corner of a
# piecewise linear speed at a random place between two samples leaves sqrt(1 / 720) of slope change times step squared;
# twice that, since the corners of a rocking drive fall on like places one after another. On simulated drives the
# largest deviation is 0.3 (sine) to 1.2 (trapezoid) times the sum.
_CORNER = 2.0 / math.sqrt(720.0)


@dataclass(frozen=True)
class Integral:
    """An integrated speed.

    Attributes:
        values: Zero at the first row, NaN in rows without a speed, (n,). It stands still in gaps.
        error: Standard error at the end, without what happened in gaps.
        gaps: Number of gaps.
        in_gaps: s in all gaps.
    """

    values: Array
    error: float
    gaps: int
    in_gaps: float


def integrate(rate: Array, seconds: Array) -> Integral:
    """The integral of a speed over time by the trapezoidal rule.

    Args:
        rate: Speed, (n,), NaN where it is not known.
        seconds: Time, s, (n,), ascending, NaN in rows without one.
    """
    known = ~np.isnan(rate) & ~np.isnan(seconds)
    values = np.full(rate.shape, math.nan)
    speed, time = rate[known], seconds[known]
    if speed.size == 0:
        return Integral(values, 0.0, 0, 0.0)
    steps = np.diff(time)
    usual = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0
    gap = steps > max(_GAP_STEPS * usual, _MIN_GAP_S)
    travelled = np.where(gap, 0.0, steps * (speed[1:] + speed[:-1]) / 2.0)
    values[known] = np.concatenate([[0.0], np.cumsum(travelled)])
    return Integral(values, _error(speed, steps, gap), int(np.count_nonzero(gap)), float(steps[gap].sum()))


def _error(speed: Array, steps: Array, gap: NDArray[np.bool_]) -> float:
    """Standard error of the sum: corners between samples, and rounding of the speed."""
    if speed.size < 3:
        return 0.0
    inner = ~(gap[1:] | gap[:-1])
    width = np.maximum(steps[1:], steps[:-1])[inner]
    bends = np.abs(np.diff(speed, 2))[inner]
    corners = float(np.sum((_CORNER * bends * width) ** 2))
    sizes = np.abs(np.diff(speed))
    sizes = sizes[sizes > 1e-9]
    rounding = float(sizes.min()) / math.sqrt(12.0) if sizes.size else 0.0
    return math.sqrt(corners + float(np.sum((rounding * steps[~gap]) ** 2)))
