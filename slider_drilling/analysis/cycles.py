"""Rocking cycles, friction work and breakover from surface torque and angle alone."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIN_SWING = 0.5
"""rad; smaller oscillation of the angle is not rocking."""
ROTATING = 0.5
"""Fraction of the largest speed above which the top drive is rotating."""


@dataclass(frozen=True)
class RockingCycle:
    """One rocking cycle, from one clockwise turning point to the next.

    Attributes:
        start, end: s.
        swing: Peak to peak, rad.
        work: Work that friction took, J: area of the torque-angle loop, closed by a straight line where the centre
            moved.
        clockwise_torque, counter_torque: Largest and smallest torque in the cycle, N m.
    """

    start: float
    end: float
    swing: float
    work: float
    clockwise_torque: float
    counter_torque: float


@dataclass(frozen=True)
class Breakover:
    """A start of rotation from rest.

    Attributes:
        peak: Torque that broke the string loose, N m.
        steady: Median torque of the rotation after it, N m.
        at: Time of the peak, s.
    """

    peak: float
    steady: float
    at: float


def rocking_cycles(time: Array, angle: Array, torque: Array) -> list[RockingCycle]:
    """Every full cycle in a record: time (n,) s, angle (n,) rad, torque (n,) N m, all finite."""
    tops = _tops(angle)
    cycles = []
    for first, last in itertools.pairwise(tops):
        part = slice(first, last + 1)
        along = float(np.sum(0.5 * (torque[part][1:] + torque[part][:-1]) * np.diff(angle[part])))
        # A straight line closes the loop where its centre moved; otherwise the shift would count as work.
        work = along - 0.5 * (torque[first] + torque[last]) * float(angle[last] - angle[first])
        cycles.append(
            RockingCycle(
                float(time[first]),
                float(time[last]),
                float(np.ptp(angle[part])),
                work,
                float(torque[part].max()),
                float(torque[part].min()),
            )
        )
    return cycles


def breakover(time: Array, speed: Array, torque: Array) -> Breakover | None:
    """The first start from rest into lasting rotation; None where the record holds none.

    Lasting is at least 20 s in one direction. The peak is the largest torque in the first half of that time, and must
    exceed the median of the second half; a string that turns without such a peak has no breakover.

    Args:
        time, speed, torque: s, rad/s and N m, (n,).
    """
    fastest = np.abs(speed).max()
    if fastest <= 0.0:
        return None
    for sign in (1.0, -1.0):
        turning = sign * speed > ROTATING * fastest
        edges = np.flatnonzero(np.diff(np.concatenate([[False], turning, [False]]).astype(int)))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            if time[last - 1] - time[first] < 20.0:
                continue
            rest = np.flatnonzero(sign * speed[:first] < 0.05 * fastest)
            begin = int(rest[-1]) if rest.size else 0
            middle = int(np.searchsorted(time, 0.5 * (time[first] + time[last - 1])))
            peak = begin + int(np.argmax(sign * torque[begin:middle]))
            steady = float(np.median(torque[middle:last]))
            if sign * torque[peak] > sign * steady:
                return Breakover(float(torque[peak]), steady, float(time[peak]))
    return None


def _tops(angle: Array) -> list[int]:
    """Indices of clockwise turning points that are followed by a swing back of at least MIN_SWING."""
    tops: list[int] = []
    highest, lowest, rising = 0, 0, True
    for k, value in enumerate(angle):
        if rising:
            if value >= angle[highest]:
                highest = k
            elif angle[highest] - value > MIN_SWING:
                tops.append(highest)
                lowest, rising = k, False
        elif value <= angle[lowest]:
            lowest = k
        elif value - angle[lowest] > MIN_SWING:
            highest, rising = k, True
    return tops
