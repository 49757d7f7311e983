"""A pump that nobody logged: what standpipe pressure tells of its flow."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.layout import Array
from slider_drilling.drillstring.lost_flow import change_at
from slider_drilling.rig import Rig

# Of the pressure that circulation at the reference flow needs: below so much of it the pump is slower whatever the
# motor does, for the file may be off by no more; and what a step is from.
_SLOWER, _STEP = 0.7, 0.05
_SETTLED = 3.0  # lags in which pressure goes to its new level
_LEVEL_S = 6.0  # of pressure that a level is the median of
_SUDDEN = 2.0  # times what it changes by before and behind in as long
_MOST = 6  # steps of a run, the largest
_BACK = 0.25  # of a step, by which the one back may differ: the motor's share has changed meanwhile


def flow_share(seen: Array, pressure: Array, rig: Rig) -> Array:
    """(m,) of the reference flow at the times s of a pressure Pa, finite: less than 1 where circulation alone needs
    more, and between a step down and one up by as much, when the pump was set to another speed and back.
    """
    needed = circulating_pressure(rig)
    share = np.clip(pressure / needed, 0.0, None) ** (1.0 / 1.8)
    share = np.where(pressure < _SLOWER * needed, share, 1.0)
    for (begin, down), (end, up) in itertools.pairwise(flow_steps(seen, pressure, rig)):
        size = 0.5 * (up - down)
        if down < 0.0 < up and abs(up + down) < _BACK * size and size < needed:
            between = (seen >= begin) & (seen < end)
            share[between] = np.minimum(share[between], (1.0 - size / needed) ** (1.0 / 1.8))
    return share


def slower(seen: Array, pressure: Array, rig: Rig) -> NDArray[np.bool_]:
    """(m,) where the pump runs much slower than at the reference flow, or had done so some lags before: how its speed
    changed there nothing tells.
    """
    low = pressure < _SLOWER * circulating_pressure(rig)
    reach = 2.0 * _SETTLED * rig.hydraulics.lag
    around = (np.searchsorted(seen[low], seen + side * reach) for side in (1.0, -1.0))
    behind, before = around
    return np.asarray(behind > before)


def circulating_pressure(rig: Rig) -> float:
    """Pa that the rig file's reference flow needs through the string, without the motor; another flow by its 1.8th
    power.
    """
    return rig.hydraulics.reference_pressure * rig.mud.density / rig.hydraulics.reference_density


def flow_steps(seen: Array, pressure: Array, rig: Rig) -> tuple[tuple[float, float], ...]:
    """Times s at which pressure (m,), Pa at s, finite, steps as it does where a pump is set to another speed, and by
    how much Pa.

    So does what a motor does when a string breaks free: whether the pump did it a fit decides.
    """
    interval = float(np.median(np.diff(seen))) if seen.size > 1 else 0.0
    if interval <= 0.0:
        return ()
    level, settle = (max(round(length / interval), 3) for length in (_LEVEL_S, _SETTLED * rig.hydraulics.lag))
    if seen.size < 4 * (level + settle):
        return ()
    medians = np.median(np.lib.stride_tricks.sliding_window_view(pressure, level), axis=1)
    at = np.arange(2 * level + settle, seen.size - 2 * (level + settle) + 1)
    change, before, behind = (
        medians[end] - medians[begin]
        for begin, end in ((at - level, at + settle), (at - 2 * level - settle, at - level),
                           (at + settle, at + 2 * settle + level))
    )  # fmt: skip
    usual = np.maximum(np.abs(before), np.abs(behind))
    least = np.maximum(_SUDDEN * usual, _STEP * circulating_pressure(rig))
    size = np.where(np.abs(change) > least, np.abs(change), 0.0)
    found: list[tuple[float, float]] = []
    while len(found) < _MOST and size.any():
        peak = int(size.argmax())
        around = slice(max(at[peak] - level, 0), at[peak] + settle + level)
        found.append((change_at(seen[around], pressure[around]), float(change[peak])))
        size[max(peak - settle - level, 0) : peak + settle + level] = 0.0
    return tuple(sorted(found))
