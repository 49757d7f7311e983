"""What surface torque and angle say by themselves: rocking cycles, friction work, breakover."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_SWING = 0.5
"""rad; smaller to-and-fro of the angle is not rocking."""
ROTATING = 0.5
"""Of the largest speed: above it the top drive is rotating."""


@dataclass(frozen=True)
class RockingCycle:
    """One rocking cycle, from one clockwise turning point to the next.

    start, end: s; swing: rad, peak to peak; work: J, area of the torque-angle loop (closed by a
    straight line where the centre moved), what friction took;
    clockwise_torque, counter_torque: N m, largest and smallest in the cycle.
    """

    start: float
    end: float
    swing: float
    work: float
    clockwise_torque: float
    counter_torque: float


@dataclass(frozen=True)
class Breakover:
    """A start of rotation from rest: peak: N m, the torque that broke the string loose; steady: N m, median torque
    while it went on rotating; at: s, time of the peak."""

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
        # The centre may have been shifted: a straight line closes the loop, or the shift would count as work.
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

    Lasting: one way for 20 s on end. The peak is the largest torque in the first half of that stretch where it
    exceeds the median of the second; a string that turns without one has no breakover. Speed (n,) rad/s.
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
    """Indices of clockwise turning points that are followed by a swing back of at least LEAST_SWING."""
    tops: list[int] = []
    highest, lowest, rising = 0, 0, True
    for k, value in enumerate(angle):
        if rising:
            if value >= angle[highest]:
                highest = k
            elif angle[highest] - value > LEAST_SWING:
                tops.append(highest)
                lowest, rising = k, False
        elif value <= angle[lowest]:
            lowest = k
        elif value - angle[lowest] > LEAST_SWING:
            highest, rising = k, True
    return tops
