"""The noise of a channel, which has to earn its name.

Noise is what differs from sample to sample and nothing else: the trimmed fourth difference of a record without its
lines, and of what a fitted model leaves of it. What steps, drifts, or has a period of its own is gap, however badly it
repeats.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2, norm

from slider_drilling.gap.model import Array, Channel
from slider_drilling.gap.problem.spectral_lines import LINE_FALSE_ALARM, remove_lines

# A difference of order 4 of white noise has this many times its variance: sum of binomial(4, k)^2.
_FOURTH_DIFFERENCE = 70.0
# Share of a record that counts, the smallest of it: kinks, steps, spikes and single events are in the rest. A median
# alone would jump with the last digit of coarse readings.
TRIM_FRACTION = 0.8
_FEWEST = 100
# By how much that estimate scatters for white noise, of itself times the root of the number of samples.
DIFFERENCE_SPREAD = 1.34
# Share of a sensor's noise that may be slow, of its variance: differences show only the rest.
_SLOW = 0.5
# Noise this many times what is declared is reported, and what is above counts as gap; where a record scatters less than
# the declared by as much, what so good a sensor would show besides is no gap that anybody asked for.
MAX_NOISE_RATIO = 2.0
_LAGS, _UNLIKELY = 10, 0.01


@dataclass(frozen=True)
class NoiseFloor:
    """sigma in the channel's unit: what residuals are counted in.

    method: ``differences``, ``colour`` (with the slow part that those do not show), ``declared``, ``resolution`` or
    ``foretelling`` (what the model itself could not foretell if it were the truth);
    declared: what somebody states, None if nobody does; seen: what the record shows; excess: seen over declared where
    that is more than is believed, else None; least: what the record's own digits scatter, or half the declared noise,
    below which no floor falls.
    """

    sigma: float
    method: str
    declared: float | None
    observed: float | None
    excess: float | None = None
    lower_limit: float = 0.0


def difference_noise(values: Array) -> float:
    """Standard deviation of white noise on a smooth signal, values (n,): trimmed fourth differences; NaN if too few."""
    if values.size < 8:
        return float("nan")
    ordered = np.sort(np.diff(values, n=4) ** 2)
    mean = float(np.mean(ordered[: max(round(TRIM_FRACTION * ordered.size), 1)]))
    cut = float(norm.ppf(0.5 + 0.5 * TRIM_FRACTION))
    of_normal = 1.0 - 2.0 * cut * float(norm.pdf(cut)) / TRIM_FRACTION
    return float(np.sqrt(mean / of_normal / _FOURTH_DIFFERENCE))


def noise_floor(channel: Channel) -> NoiseFloor:
    """The noise of one channel. Raises ValueError when the log has too little and nothing is declared."""
    quantum = channel.resolution / np.sqrt(12.0)
    declared = None if channel.declared_noise is None else float(np.hypot(channel.declared_noise, quantum))
    if channel.period is not None or channel.time.size < _FEWEST:
        if not declared:
            raise ValueError(f"channel {channel.name}: too few samples to tell its noise, and none is declared")
        return NoiseFloor(declared, "declared", declared, None)
    digits, stated = max(quantum, _smallest_step(channel.measured)), (declared or 0.0) / MAX_NOISE_RATIO
    seen, least = _seen(channel), max(digits, stated)
    if _whole(seen, declared) <= least:
        return NoiseFloor(least, "resolution" if digits > stated else "declared", declared, seen, lower_limit=least)
    return _of_differences(NoiseFloor(seen, "differences", declared, seen, lower_limit=least))


def _seen(channel: Channel) -> float:
    """What a record shows, with its lines or without: steps that come again and again are lines too, and each sinusoid
    taken from those would be noise everywhere else.
    """
    rest = remove_lines(channel.time, channel.measured, LINE_FALSE_ALARM)
    return min(difference_noise(channel.measured), difference_noise(rest))


def lower_floor(floor: NoiseFloor, left: Array) -> NoiseFloor:
    """The floor once a model has taken the signal's own kinks away; left (n,): residual in the channel's unit."""
    if floor.method not in ("differences", "colour") or floor.observed is None:
        return floor
    reached = max(difference_noise(left), floor.lower_limit)
    return _of_differences(replace(floor, observed=reached)) if reached < floor.observed else floor


def _of_differences(floor: NoiseFloor) -> NoiseFloor:
    """The floor of what differences show: with the slow part that they do not, and not far above the declared noise."""
    assert floor.observed is not None
    whole = _whole(floor.observed, floor.declared)
    method = "colour" if whole > floor.observed else "differences"
    if not floor.declared or whole <= MAX_NOISE_RATIO * floor.declared:
        return replace(floor, sigma=whole, method=method, excess=None)
    return replace(floor, sigma=MAX_NOISE_RATIO * floor.declared, method=method, excess=floor.observed / floor.declared)


def _whole(seen: float, declared: float | None) -> float:
    """Noise of which differences show so much, up to what is declared: sensors are seldom white."""
    if not declared or not seen < declared:
        return seen
    return min(seen / float(np.sqrt(1.0 - _SLOW)), declared)


def raise_floor(floor: NoiseFloor, factor: float) -> NoiseFloor:
    """The floor of a channel that cannot be foretold as well as its sensor measures it; factor: 1 or more."""
    return replace(floor, sigma=factor * floor.sigma, method="foretelling") if factor > 1.0 else floor


def is_white(left: Array) -> bool | None:
    """Whether what is left (n,) of a channel is white by the test of Ljung and Box (Biometrika 65, 1978), None if too
    short to tell.
    """
    if left.size < _FEWEST or not np.any(left):
        return None
    centred = left - left.mean()
    lags = np.arange(1, _LAGS + 1)
    correlation = np.array([centred[:-lag] @ centred[lag:] for lag in lags]) / float(centred @ centred)
    statistic = left.size * (left.size + 2.0) * float(np.sum(correlation**2 / (left.size - lags)))
    return bool(chi2.sf(statistic, _LAGS) >= _UNLIKELY)


def sigmas(floors: Mapping[str, NoiseFloor]) -> dict[str, float]:
    """Standard deviations by channel."""
    return {name: floor.sigma for name, floor in floors.items()}


def _smallest_step(values: Array) -> float:
    """What the last digit of a record scatters: the smallest step between its values over sqrt(12)."""
    steps = np.diff(np.unique(values))
    least = 1e-6 * float(np.std(values)) or 1.0
    return max(float(np.min(steps)) / float(np.sqrt(12.0)), least) if steps.size else least
