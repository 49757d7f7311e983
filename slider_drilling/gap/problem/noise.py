"""Noise floor of a channel: what residuals are counted in.

Noise is what differs from sample to sample and nothing else. It is estimated from trimmed fourth differences of the
record without its spectral lines, and later of what a fitted model leaves. What steps, drifts, or has a period of its
own counts as gap, however badly it repeats.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2, norm

from slider_drilling.gap.model import Array, Channel, LoggedRun
from slider_drilling.gap.problem.spectral_lines import LINE_FALSE_ALARM, remove_lines

# Variance of fourth differences of white noise, in its variance: sum of binomial(4, k)^2.
_FOURTH_DIFFERENCE = 70.0
# Share of a record that counts, the smallest squares of it: kinks, steps, spikes and single events are in the rest. A
# median alone would jump with the last digit of coarse readings.
TRIM_FRACTION = 0.8
# Samples below which no noise is estimated.
_MIN_SAMPLES = 100
# Relative standard deviation of that estimate for white noise, times the root of the number of samples.
DIFFERENCE_SPREAD = 1.34
# Share of the noise's variance that may be slow: differences show only the rest.
_SLOW_SHARE = 0.5
# Noise above this multiple of the declared noise is reported, and the excess counts as gap. The floor never falls below
# the declared noise divided by it: smaller differences are none that anybody asked for.
MAX_NOISE_RATIO = 2.0
# Lags and level of the test for whiteness.
_LAGS, _WHITENESS_LEVEL = 10, 0.01


@dataclass(frozen=True)
class NoiseFloor:
    """Noise floor of one channel.

    Attributes:
        sigma: Standard deviation in the channel's unit: what residuals are counted in.
        method: Where it comes from: ``differences``, ``colour`` (differences and the slow part that they do not show),
            ``declared``, ``resolution``, or ``replicates`` (what the model could not predict if it were the truth).
        declared: Declared noise, None if nobody declares any.
        observed: What the record shows, None where it was not estimated.
        excess: ``observed / declared`` where that exceeds `MAX_NOISE_RATIO`, else None.
        lower_limit: The floor never falls below it: the record's resolution, or the declared noise over
            `MAX_NOISE_RATIO`.
    """

    sigma: float
    method: str
    declared: float | None
    observed: float | None
    excess: float | None = None
    lower_limit: float = 0.0


def difference_noise(values: Array) -> float:
    """Standard deviation of white noise on a smooth signal (n,), from trimmed fourth differences; NaN if too short."""
    if values.size < 8:
        return float("nan")
    ordered = np.sort(np.diff(values, n=4) ** 2)
    mean = float(np.mean(ordered[: max(round(TRIM_FRACTION * ordered.size), 1)]))
    # Of a normal distribution trimmed alike, the variance is a known share.
    cut = float(norm.ppf(0.5 + 0.5 * TRIM_FRACTION))
    of_normal = 1.0 - 2.0 * cut * float(norm.pdf(cut)) / TRIM_FRACTION
    return float(np.sqrt(mean / of_normal / _FOURTH_DIFFERENCE))


def noise_floor(channel: Channel) -> NoiseFloor:
    """Noise floor of one channel, from its record alone.

    Raises:
        ValueError: There are too few samples, and no noise is declared.
    """
    quantum = channel.resolution / np.sqrt(12.0)
    declared = None if channel.declared_noise is None else float(np.hypot(channel.declared_noise, quantum))
    if channel.period is not None or channel.time.size < _MIN_SAMPLES:
        if not declared:
            raise ValueError(f"channel {channel.name}: too few samples to estimate its noise, and none is declared")
        return NoiseFloor(declared, "declared", declared, None)
    digits, of_declared = max(quantum, _rounding_noise(channel.measured)), (declared or 0.0) / MAX_NOISE_RATIO
    observed, limit = _observed_noise(channel), max(digits, of_declared)
    if _with_slow_part(observed, declared) <= limit:
        method = "resolution" if digits > of_declared else "declared"
        return NoiseFloor(limit, method, declared, observed, lower_limit=limit)
    return _floor_of_differences(NoiseFloor(observed, "differences", declared, observed, lower_limit=limit))


def noise_floors(runs: Sequence[LoggedRun]) -> list[dict[str, NoiseFloor]]:
    """Noise floors by run and channel, from the logs alone."""
    return [{channel.name: noise_floor(channel) for channel in run.channels} for run in runs]


def lower_floor(floor: NoiseFloor, residual: Array) -> NoiseFloor:
    """The floor from what a model leaves, where that is lower: the signal's own kinks are gone.

    Args:
        floor: The floor so far.
        residual: (n,) in the channel's unit.
    """
    if floor.method not in ("differences", "colour") or floor.observed is None:
        return floor
    observed = max(difference_noise(residual), floor.lower_limit)
    return _floor_of_differences(replace(floor, observed=observed)) if observed < floor.observed else floor


def raise_floor(floor: NoiseFloor, factor: float, method: str = "replicates") -> NoiseFloor:
    """The floor times a factor (1 or more): the model cannot predict the channel as well as its sensor measures it."""
    return replace(floor, sigma=factor * floor.sigma, method=method) if factor > 1.0 else floor


def is_white(residual: Array) -> bool | None:
    """Whether a residual (n,) is white noise (Ljung and Box, Biometrika 65, 1978); None if it is too short."""
    if residual.size < _MIN_SAMPLES or not np.any(residual):
        return None
    centred = residual - residual.mean()
    lags = np.arange(1, _LAGS + 1)
    correlation = np.array([centred[:-lag] @ centred[lag:] for lag in lags]) / float(centred @ centred)
    statistic = residual.size * (residual.size + 2.0) * float(np.sum(correlation**2 / (residual.size - lags)))
    return bool(chi2.sf(statistic, _LAGS) >= _WHITENESS_LEVEL)


def sigmas(floors: Mapping[str, NoiseFloor]) -> dict[str, float]:
    """Standard deviations by channel."""
    return {name: floor.sigma for name, floor in floors.items()}


def _observed_noise(channel: Channel) -> float:
    """Noise of a record with its spectral lines or without, whichever is less.

    Steps at regular intervals have lines too, and to remove their sinusoids would add noise everywhere else.
    """
    rest = remove_lines(channel.time, channel.measured, LINE_FALSE_ALARM)
    return min(difference_noise(channel.measured), difference_noise(rest))


def _floor_of_differences(floor: NoiseFloor) -> NoiseFloor:
    """The floor for the observed noise: with the slow part that differences miss, capped above the declared noise."""
    assert floor.observed is not None
    whole = _with_slow_part(floor.observed, floor.declared)
    method = "colour" if whole > floor.observed else "differences"
    if not floor.declared or whole <= MAX_NOISE_RATIO * floor.declared:
        return replace(floor, sigma=whole, method=method, excess=None)
    return replace(floor, sigma=MAX_NOISE_RATIO * floor.declared, method=method, excess=floor.observed / floor.declared)


def _with_slow_part(observed: float, declared: float | None) -> float:
    """Noise of which differences show so much, up to the declared noise, since sensors are seldom white."""
    if not declared or not observed < declared:
        return observed
    return min(observed / float(np.sqrt(1.0 - _SLOW_SHARE)), declared)


def _rounding_noise(values: Array) -> float:
    """Standard deviation of rounding: the smallest step between the record's values over sqrt(12)."""
    steps = np.diff(np.unique(values))
    least = 1e-6 * float(np.std(values)) or 1.0
    return max(float(np.min(steps)) / float(np.sqrt(12.0)), least) if steps.size else least
