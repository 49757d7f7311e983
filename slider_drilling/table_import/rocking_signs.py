"""Signs of an unsigned speed or torque of a rocking top drive, where the other one tells them.

Between two reversals the string winds up like a spring: torque rises while the drive turns right, falls while it turns
left. So the sign of speed times change of torque is positive throughout, up to friction in the drive.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError

Array = NDArray[np.float64]

_LOW = 0.35  # of the 95 % quantile: below it an unsigned signal may pass zero
_MIN_LOBES = 6
_WHOLE = 0.8  # of a lobe's work that has one sign, where the lobe lies between two reversals
_AGREEMENT = 0.7  # of |speed x change of torque| that must have one sign within the lobes
_MIN_SAMPLES = 30


def looks_unsigned(values: Array) -> bool:
    """Whether a signal is never negative and touches zero again and again at regular times, as a rocking one would."""
    known = values[np.isfinite(values)]
    if known.size < _MIN_SAMPLES or known.min() < 0.0 or known.max() <= 0.0:
        return False
    top = float(np.quantile(known, 0.95))
    turns = _turning_points(known, _LOW * top)
    if turns.size < 2 * _MIN_LOBES:
        return False
    # A drive that rocks is near zero for a moment each time and high between; its period hardly changes.
    periods = np.diff(turns)
    middle = float(np.median(periods))
    regular = np.mean(np.abs(periods - middle) <= max(0.35 * middle, 1.5))
    return bool(regular > 0.6 and np.median(known[turns[0] : turns[-1]]) > 0.25 * top)


def signed_by(unsigned: Array, other: Array, of_speed: bool, where: str) -> Array:
    """An unsigned signal with the signs that the other, signed one gives.

    Args:
        unsigned: Magnitude of speed or torque, (n,).
        other: The signed torque, or the signed speed, (n,).
        of_speed: Whether the unsigned one is the speed.
        where: Starts the message.

    Raises:
        InputError: The other has no sign either, or does not follow the lobes of the first.
    """
    refusal = InputError(
        f"{where}: {'speed' if of_speed else 'torque'} has no sign, and {'torque' if of_speed else 'speed'} does not "
        "tell it; export it with its sign, or leave the channel out"
    )
    known = np.isfinite(unsigned) & np.isfinite(other)
    if np.count_nonzero(known) < _MIN_SAMPLES or other[known].min() >= 0.0:
        raise refusal
    size, signal = unsigned[known], other[known]
    bounds = np.r_[0, _turning_points(size, _LOW * float(np.quantile(size, 0.95))), size.size]
    work = _work(size, signal, of_speed)
    signs = np.ones(size.size)
    agreed = total = 0.0
    nearby = np.convolve(work, np.ones(3), "same")
    for first, last in itertools.pairwise(bounds.tolist()):
        inside = work[first:last]
        # A reversal between two samples leaves no low one: then a lobe holds two signs, and neighbours tell.
        whole = abs(float(inside.sum())) > _WHOLE * float(np.abs(inside).sum())
        votes = np.full(inside.size, inside.sum()) if whole else nearby[first:last]
        signs[first:last] = np.where(votes < 0.0, -1.0, 1.0)
        agreed += float(np.sum(inside * signs[first:last]))
        total += float(np.abs(inside).sum())
    if total <= 0.0 or agreed < _AGREEMENT * total:
        raise refusal
    result = np.full(unsigned.shape, np.nan)
    result[known] = signs * size
    return result


def _work(size: Array, signal: Array, of_speed: bool) -> Array:
    """Speed times change of torque at each sample, up to a positive factor."""
    speed, torque = (size, signal) if of_speed else (signal, size)
    return speed * np.gradient(torque)


def _turning_points(values: Array, low: float) -> NDArray[np.int_]:
    """Indices of the lowest sample of each stretch below a limit."""
    below = values < low
    edges = np.flatnonzero(np.diff(np.r_[False, below, False].astype(np.int8)))
    return np.array([first + int(np.argmin(values[first:last])) for first, last in zip(edges[::2], edges[1::2],
                     strict=True)], dtype=np.int_)  # fmt: skip
