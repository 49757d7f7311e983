"""Signs of an unsigned speed or torque of a rocking drive, where the other one tells them.

Between two reversals the string winds up like a spring: torque rises while the drive turns right and falls while it
turns left. The signs are the likeliest sequence of two states under that law and continuity of the signal (Viterbi,
IEEE Trans. Inf. Theory 13, 1967).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError

Array = NDArray[np.float64]

_MIN_SAMPLES = 30
_MIN_NEGATIVE = 0.02  # share of negative samples from which a signal has a sign
_MIN_LOST, _MIN_FLIPS = 0.05, 4  # share of samples that turn negative, and changes of sign, where one was lost
# Costs in units of the winding of one sample: of a step of the signal by its own size within a second, and of opposite
# signs of speed and torque, which friction makes alike.
_JUMP, _UNLIKE = 5.0, 0.2
_DISTINCT = 0.75  # ratio of the costs of the best signs and of the opposite ones, up to which the signs are identified
_LOW, _SMALL = 0.35, 0.15  # of the 95 % quantile: below them a sample says little, or has no sign to speak of
_REGULAR, _HIGH, _MIN_LOBES = 0.6, 0.25, 6


def looks_unsigned(values: Array, other: Array, of_speed: bool, interval: float = 1.0) -> bool:
    """Whether a speed or torque that is never negative has lost its sign.

    Args:
        values: The speed or the torque, (n,).
        other: The other of the two.
        of_speed: Whether `values` is the speed.
        interval: Between samples, s.

    Returns:
        True where the other one has a sign and shows that this one must have had both; where the other has none, too,
        true if the signal touches zero again and again at regular times, as that of a rocking drive does.
    """
    known = values[np.isfinite(values)]
    if known.size < _MIN_SAMPLES or known.min() < 0.0 or known.max() <= 0.0:
        return False
    if not _has_sign(other):
        return _touches_zero_regularly(known)
    return _restored(values, other, of_speed, interval) is not None


def signed_by(unsigned: Array, other: Array, of_speed: bool, where: str, interval: float = 1.0) -> Array:
    """An unsigned signal with the signs that the other, signed one gives.

    Args:
        unsigned: Magnitude of speed or torque, (n,).
        other: The signed torque, or the signed speed, (n,).
        of_speed: Whether the unsigned one is the speed.
        where: Starts the message.
        interval: Between samples, s.

    Raises:
        InputError: The other has no sign either, or does not tell that of the first.
    """
    restored = _restored(unsigned, other, of_speed, interval) if _has_sign(other) else None
    if restored is None:
        raise InputError(
            f"{where}: {'speed' if of_speed else 'torque'} has no sign, and {'torque' if of_speed else 'speed'} does "
            "not tell it; export it with its sign, or leave the channel out"
        )
    return restored


def _has_sign(values: Array) -> bool:
    known = values[np.isfinite(values)]
    if known.size < _MIN_SAMPLES:
        return False
    return bool(np.mean(known < -0.02 * np.quantile(np.abs(known), 0.95)) > _MIN_NEGATIVE)


def _restored(unsigned: Array, other: Array, of_speed: bool, interval: float) -> Array | None:
    """The signal with its signs; None where they are not identified, or none was lost."""
    known = np.isfinite(unsigned) & np.isfinite(other)
    if np.count_nonzero(known) < _MIN_SAMPLES:
        return None
    size, signal = np.abs(unsigned[known]), other[known]
    top, scale = float(np.quantile(size, 0.95)), float(np.quantile(np.abs(signal), 0.95))
    if top <= 0.0 or scale <= 0.0:
        return None
    if of_speed:
        signs, ratio = _signs_of_speed(size / top, signal / scale, interval)
    else:
        signs, ratio = _signs_of_torque(size / top, signal / scale)
    large = size > _SMALL * top
    lost = float(np.mean(signs[large] < 0.0)) if large.any() else 0.0
    if ratio > _DISTINCT or lost < _MIN_LOST or np.count_nonzero(np.diff(signs)) < _MIN_FLIPS:
        return None
    result = np.full(unsigned.shape, np.nan)
    result[known] = signs * size
    return result


def _signs_of_speed(speed: Array, torque: Array, interval: float) -> tuple[Array, float]:
    """Signs of a speed (n,), and the ratio of their cost to that of the opposite ones; both relative to their size."""
    # Waves in the string take tenths of a second: the mean of a second does not show them.
    change = np.gradient(_mean_of(torque, max(round(1.0 / interval), 1)))
    jump = _JUMP / interval
    fast = speed > _LOW
    stiffness = float(np.sum(np.abs(change[fast]) * speed[fast]) / np.sum(speed[fast] ** 2))
    unit = float(np.median(np.abs(change[fast]))) ** 2 + 1e-12
    cost = np.stack([(change - sign * stiffness * speed) ** 2 / unit for sign in (1.0, -1.0)], axis=1)
    unlike = _UNLIKE * np.stack([(torque < 0.0) * speed, (torque > 0.0) * speed], axis=1)
    stay, flip = jump * np.diff(speed) ** 2, jump * (speed[1:] + speed[:-1]) ** 2
    signs = _likeliest(cost + unlike, np.stack([stay, stay], axis=1), np.stack([flip, flip], axis=1))
    chosen = np.where(signs > 0.0, 0, 1)
    rows = np.arange(speed.size)
    return signs, float(cost[rows, chosen].sum() / max(cost[rows, 1 - chosen].sum(), 1e-12))


def _mean_of(values: Array, count: int) -> Array:
    """Running mean of `count` samples."""
    padded = np.pad(values, (count // 2, count - 1 - count // 2), mode="edge")
    return np.convolve(padded, np.full(count, 1.0 / count), "valid")


def _signs_of_torque(torque: Array, speed: Array) -> tuple[Array, float]:
    """Signs of a torque (n,), and the ratio of their cost to that of the opposite ones; both relative to their size."""
    mean = 0.5 * (speed[1:] + speed[:-1])
    steps, fast = np.abs(np.diff(torque)), np.abs(mean) > _LOW
    stiffness = float(np.median(steps[fast]) / np.median(np.abs(mean[fast]))) if fast.any() else 0.0
    unit = float(np.median(steps[fast])) ** 2 + 1e-12 if fast.any() else 1.0
    before, after, wound = torque[:-1], torque[1:], stiffness * mean

    def winding(first: float, second: float) -> Array:
        """Cost of each step between samples of these signs."""
        return (second * after - first * before - wound) ** 2 / unit

    stay = np.stack([winding(1.0, 1.0), winding(-1.0, -1.0)], axis=1)
    flip = np.stack([winding(1.0, -1.0), winding(-1.0, 1.0)], axis=1)
    unlike = _UNLIKE * np.stack([(speed < 0.0) * torque, (speed > 0.0) * torque], axis=1)
    signs = _likeliest(unlike, stay, flip)
    best, opposite = (float(np.sum((np.diff(sign * signs * torque) - wound) ** 2)) for sign in (1.0, -1.0))
    return signs, best / max(opposite, 1e-12)


def _likeliest(cost: Array, stay: Array, flip: Array) -> Array:
    """The sequence of signs of the lowest cost.

    Args:
        cost: Of each sample with sign +1 and -1, (n, 2).
        stay, flip: Of keeping and of changing the sign after each sample, from +1 and from -1, (n - 1, 2).
    """
    plus, minus = cost[0].tolist()
    came_from = []
    for (own_plus, own_minus), (stay_plus, stay_minus), (to_minus, to_plus) in zip(
        cost[1:].tolist(), stay.tolist(), flip.tolist(), strict=True
    ):
        from_plus, from_minus = plus + stay_plus <= minus + to_plus, minus + stay_minus <= plus + to_minus
        came_from.append((1 if from_plus else -1, -1 if from_minus else 1))
        plus, minus = (
            own_plus + min(plus + stay_plus, minus + to_plus), own_minus + min(minus + stay_minus, plus + to_minus)
        )  # fmt: skip
    signs = [1 if plus <= minus else -1]
    for before_plus, before_minus in reversed(came_from):
        signs.append(before_plus if signs[-1] > 0 else before_minus)
    return np.array(signs[::-1], dtype=np.float64)


def _touches_zero_regularly(values: Array) -> bool:
    """Whether a signal is low for a moment again and again, at regular times, and high between."""
    top = float(np.quantile(values, 0.95))
    below = values < _LOW * top
    edges = np.flatnonzero(np.diff(np.r_[False, below, False].astype(np.int8)))
    lowest = [first + int(np.argmin(values[first:last])) for first, last in zip(edges[::2], edges[1::2], strict=True)]
    if len(lowest) < 2 * _MIN_LOBES:
        return False
    periods = np.diff(lowest)
    middle = float(np.median(periods))
    regular = float(np.mean(np.abs(periods - middle) <= max(0.35 * middle, 1.5)))
    return bool(regular > _REGULAR and np.median(values[lowest[0] : lowest[-1]]) > _HIGH * top)
