"""The noise floor of a channel, from the log itself.

Where the excitation repeats, what differs from cycle to cycle is noise (per frequency bin, corrected for the
cycles that the mean and the drift were taken from); elsewhere robust high-order differences.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.gap.model import Array, Channel, Run

# A difference of order 4 of white noise has this many times its variance: sum of binomial(4, k)^2.
_FOURTH_DIFFERENCE = 70.0
_MAD = 1.4826
# A median of overlapping differences knows a variance as well as this many times fewer samples would.
_MEDIAN_COST = 8.0
_MIN_CYCLES = 3
_CYCLE_MATCH = 0.03
# Cycles must show this much more than the differences do before noise counts as coloured: below it is the
# spread of the two estimates themselves.
_COLOURED = 1.25
_AGREE = 1.3


@dataclass(frozen=True)
class NoiseFloor:
    """sigma in the channel's unit; method ``cycles``, ``differences``, ``declared`` or ``resolution``.

    lag_correlation: of neighbouring samples of the noise (0 for white); uncertainty: relative standard deviation of
    sigma^2; differences, cycles: the two estimates behind it, NaN where the log gives none.
    """

    sigma: float
    method: str
    lag_correlation: float = 0.0
    uncertainty: float = 0.0
    differences: float = float("nan")
    cycles: float = float("nan")


def difference_noise(values: Array) -> float:
    """Standard deviation of white noise on a smooth signal, values (n,): robust fourth differences."""
    if values.size < 8:
        return float("nan")
    difference = np.diff(values, n=4)
    return float(_MAD * np.median(np.abs(difference)) / np.sqrt(_FOURTH_DIFFERENCE))


def cycle_starts(time: Array, excitation: Array) -> list[Array]:
    """Groups of at least three like cycles: per group the start times (P + 1,) s of P cycles and their end.

    A cycle runs from one upward crossing of its group's middle to the next; two are alike when length and
    shape agree within 3 %.
    """
    peaks = _turning_points(excitation)
    if peaks.size < 2 * _MIN_CYCLES:
        return []
    crossings = _upward_crossings(time, excitation, peaks)
    groups: list[Array] = []
    current = [crossings[0]] if crossings.size else []
    for start, end in itertools.pairwise(crossings):
        if len(current) >= 2 and not _alike(time, excitation, current[-2], current[-1], start, end):
            groups.append(np.array(current))
            current = [start]
        current.append(end)
    groups.append(np.array(current))
    return [group for group in groups if group.size > _MIN_CYCLES]


def cycle_period(time: Array, excitation: Array) -> float | None:
    """Median length s of the excitation's cycles, None when there is no full one."""
    peaks = _turning_points(excitation)
    if peaks.size < 3:
        return None
    crossings = _upward_crossings(time, excitation, peaks)
    return float(np.median(np.diff(crossings))) if crossings.size > 1 else None


def cycle_noise(channel: Channel, groups: list[Array]) -> tuple[float, float, float]:
    """(sigma, lag correlation, uncertainty) of what does not repeat; NaN when too little repeats.

    Per group the P cycles are laid over each other, mean and linear drift over the cycles are removed (which
    takes two of P degrees of freedom: factor P / (P - 2), or P / (P - 1) for three cycles, where only the mean
    is). The quietest group counts, pooled with those that agree with it within 30 %, and only when one does:
    noise is the same in every group, while a run that settles or drifts differs from cycle to cycle by another
    amount in each. uncertainty is the relative standard deviation of sigma^2.
    """
    found = []
    for group in groups:
        spectrum = _cycle_spectrum(channel, group)
        if spectrum is not None:
            frequency, power, freedom = spectrum
            colour = float(np.sum(power * np.cos(2.0 * np.pi * frequency)) / np.sum(power))
            found.append((float(np.mean(power)), colour, freedom))
    found.sort()
    alike = np.array([entry for entry in found if entry[0] <= _AGREE**2 * found[0][0]])
    if len(alike) < 2:
        return float("nan"), 0.0, 0.0
    variance, colour = (float(np.average(alike[:, k], weights=alike[:, 2])) for k in (0, 1))
    # Coloured noise holds fewer independent samples than its number.
    independent = alike[:, 2].sum() * (1.0 - abs(colour)) / (1.0 + abs(colour))
    return float(np.sqrt(variance)), colour, float(np.sqrt(2.0 / independent))


def noise_floor(channel: Channel, run: Run) -> NoiseFloor:
    """The noise of one channel of a run. Raises ValueError when the log has too little and nothing is declared."""
    quantum = channel.resolution / np.sqrt(12.0)
    if channel.period is not None or channel.time.size < 100:
        if channel.declared_noise is None:
            raise ValueError(f"channel {channel.name}: too few samples to tell its noise, and none is declared")
        return NoiseFloor(float(np.hypot(channel.declared_noise, quantum)), "declared")
    differences = difference_noise(channel.measured)
    cycles, colour, uncertainty = cycle_noise(channel, cycle_starts(run.time, run.excitation))
    # Differences also see the signal's own kinks, cycles also what drifts: the lower one is nearer the noise, unless
    # the cycles show clearly more, and agree on it.
    if cycles > _COLOURED * differences or 0.0 < cycles < differences:
        return NoiseFloor(max(cycles, quantum), "cycles", max(colour, 0.0), uncertainty, differences, cycles)
    if max(differences, quantum) > 0.0:
        uncertainty = float(np.sqrt(2.0 * _MEDIAN_COST / channel.measured.size))
        return NoiseFloor(max(differences, quantum), "differences", 0.0, uncertainty, differences, cycles)
    return NoiseFloor(_smallest_step(channel.measured), "resolution", 0.0, 0.0, differences, cycles)


def lowered(floor: NoiseFloor, reached: float) -> NoiseFloor:
    """The floor after a model came within ``reached`` (RMS, the channel's unit) of the channel.

    What a fitted model explains is no noise: cycles that differed because the run was still settling had been
    counted as such. Never below what the differences show.
    """
    if floor.method != "cycles" or not reached < floor.sigma or not floor.differences < floor.sigma:
        return floor
    return replace(floor, sigma=max(reached, floor.differences), method="cycles, lowered", lag_correlation=0.0)


def _smallest_step(values: Array) -> float:
    """Noise-free records still have a last digit: the smallest step between distinct values over sqrt(12)."""
    steps = np.diff(np.unique(values))
    return float(max(np.min(steps) / np.sqrt(12.0), 1e-6 * np.std(values))) if steps.size else float("nan")


def _turning_points(excitation: Array) -> Array:
    """Indices where the excitation turns by more than a tenth of its range (noise and ripple do not count)."""
    threshold = 0.05 * float(np.ptp(excitation))
    if threshold == 0.0:
        return np.empty(0, dtype=int)
    turns: list[int] = []
    direction, extreme = 0, 0
    for index, value in enumerate(excitation):
        change = value - excitation[extreme]
        if direction == 0 and abs(change) > threshold:
            direction, extreme = int(np.sign(change)), index
        elif direction * change > 0.0:
            extreme = index
        elif direction * change < -threshold:
            turns.append(extreme)
            direction, extreme = -direction, index
    return np.array(turns, dtype=int)


def _upward_crossings(time: Array, excitation: Array, turns: Array) -> Array:
    """Times when the excitation passes half-way up from a low turning point to the next high one."""
    crossings = []
    for low, high in itertools.pairwise(turns):
        if excitation[high] <= excitation[low]:
            continue
        middle = 0.5 * (excitation[low] + excitation[high])
        index = low + int(np.argmax(excitation[low : high + 1] >= middle))
        fraction = (middle - excitation[index - 1]) / max(excitation[index] - excitation[index - 1], 1e-300)
        crossings.append(time[index - 1] + fraction * (time[index] - time[index - 1]))
    return np.array(crossings)


def _alike(time: Array, excitation: Array, start: float, end: float, other: float, other_end: float) -> bool:
    length, other_length = end - start, other_end - other
    if abs(length - other_length) > _CYCLE_MATCH * length:
        return False
    phase = np.linspace(0.0, 1.0, 100)
    first = np.interp(start + phase * length, time, excitation)
    second = np.interp(other + phase * other_length, time, excitation)
    return bool(np.std(first - second) <= _CYCLE_MATCH * np.ptp(first))


def _cycle_spectrum(channel: Channel, group: Array) -> tuple[Array, Array, int] | None:
    """(cycles per sample, power, degrees of freedom) of the cycle-to-cycle differences.

    Cycles are shifted by whole samples: interpolation would take power from white noise.
    """
    interval = float(np.median(np.diff(channel.time)))
    samples = int(np.floor(np.min(np.diff(group)) / interval))
    starts = np.searchsorted(channel.time, group[:-1])
    if samples < 16 or (starts[0] == 0 and channel.time[0] > group[0]) or starts[-1] + samples > channel.time.size:
        return None
    cycles = np.stack([channel.measured[start : start + samples] for start in starts])
    count = cycles.shape[0]
    order = np.arange(count) - 0.5 * (count - 1)
    rest = cycles - cycles.mean(axis=0)
    lost = 1
    if count > _MIN_CYCLES:
        rest = rest - np.outer(order, order @ rest) / (order @ order)
        lost = 2
    transformed = np.fft.rfft(rest, axis=1) / np.sqrt(samples)
    power: Array = np.mean(np.abs(transformed) ** 2, axis=0) * count / (count - lost)
    return np.asarray(np.fft.rfftfreq(samples)), power, samples * (count - lost)
