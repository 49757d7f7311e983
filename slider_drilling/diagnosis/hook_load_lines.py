"""Lines in the spectrum of the hook load: where a vibrating tool or a wave may be searched for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from slider_drilling.diagnosis.catalogue import SEA_WAVE_PERIODS_S
from slider_drilling.gap.model import Array, LoggedRun
from slider_drilling.gap.problem.spectral_lines import LINE_FALSE_ALARM, peak_is_significant, resample_evenly

# Hz. Above this neither rocking nor the sea moves a hook load; vibrating tools are within the range.
_FAST_HZ, _TOOLS_HZ = 0.4, (5.0, 30.0)
# Hz, below which drilling and rocking themselves fill the spectrum.
_SLOWEST_HZ = 0.05
# Spectra are padded to this many times the log's length, for a finer grid of frequencies.
_PADDING = 8
_MIN_SPECTRUM = 400  # samples
# Hz either side, over which the median of the power is the level that a slow line stands out from.
_NEIGHBOURS_HZ = 0.05
# A slow line has this many times the power around it; rocking without a steady period leaves less than 50.
_STANDS_OUT = 200.0
# Hz: a stroke either way takes less than a minute. What is slower is the toolface's correction.
_SLOWEST_ROCKING_HZ = 1.0 / 60.0
# Harmonics of the rocking that are no lines of their own.
_HARMONICS = 60


def wave_periods(run: LoggedRun) -> tuple[float, ...]:
    """Periods, s, of the highest spectral peaks of hook load (else torque) between 4 and 40 s: where heave may be."""
    frequency, power = _spectrum(run)
    inside = np.flatnonzero((frequency > 1.0 / 40.0) & (frequency < 1.0 / 4.0))
    peaks = [i for i in inside[1:-1] if power[i] >= power[i - 1] and power[i] >= power[i + 1]]
    peaks.sort(key=lambda i: -power[i])
    return tuple(float(1.0 / frequency[i]) for i in peaks[:6]) if len(peaks) >= 2 else SEA_WAVE_PERIODS_S


def tool_frequencies(runs: Sequence[LoggedRun]) -> tuple[float, ...]:
    """Frequencies, Hz, that an axial oscillation tool may have by the strongest line of the first hook load.

    Hook loads are sampled more slowly than such a tool vibrates, so the line may be an alias, and a slow one: all
    frequencies that it can stand for are returned. Empty if no line is significant, or the log is sampled too slowly.
    """
    with_hook_load = _first_with_hook_load(runs)
    if with_hook_load is None or sampled_too_slowly(runs):
        return ()
    frequency, power = _spectrum(with_hook_load, np.blackman)
    if not frequency.size:
        return ()
    # Peaks alone: the flank of a harmonic of the rocking is no line.
    peaks = np.append(np.append(False, (power[1:-1] >= power[:-2]) & (power[1:-1] >= power[2:])), False)
    peaks &= ~_near_rocking(frequency, with_hook_load)
    line = _fast_line(frequency, power, peaks) or _slow_line(frequency, power, peaks)
    if line is None:
        return ()
    rate = _sampling_rate(with_hook_load)
    multiples = range(int(_TOOLS_HZ[1] / rate) + 2)
    aliases = {abs(multiple * rate + sign * line) for multiple in multiples for sign in (-1.0, 1.0)}
    return tuple(sorted(alias for alias in aliases if _TOOLS_HZ[0] < alias < _TOOLS_HZ[1]))


def sampled_too_slowly(runs: Sequence[LoggedRun]) -> bool:
    """Whether the first hook load has less than a sample a cycle of the slowest tool: its line could be any tool's."""
    with_hook_load = _first_with_hook_load(runs)
    return with_hook_load is not None and _sampling_rate(with_hook_load) < 0.99 * _TOOLS_HZ[0]


def _first_with_hook_load(runs: Sequence[LoggedRun]) -> LoggedRun | None:
    return next((run for run in runs if any(channel.name == "hook_load" for channel in run.channels)), None)


def _sampling_rate(run: LoggedRun) -> float:
    """Samples of hook load a second, Hz: the mean over the run without its gaps. Jitter does not move it."""
    steps = next(np.diff(channel.time) for channel in run.channels if channel.name == "hook_load")
    return 1.0 / float(np.mean(steps[steps < 1.5 * np.median(steps)]))


def _fast_line(frequency: Array, power: Array, peaks: NDArray[np.bool_]) -> float | None:
    """Hz of the strongest line that is faster than rocking and sea, None if it may be noise.

    Args:
        frequency, power: (n,) the spectrum.
        peaks: (n,) where a line may be.
    """
    fast = frequency > _FAST_HZ
    if not (peaks & fast).any():
        return None
    best = int(np.argmax(np.where(peaks & fast, power, 0.0)))
    with_best = np.append(power[fast & (power < power[best])], power[best])
    return float(frequency[best]) if peak_is_significant(with_best, _PADDING, LINE_FALSE_ALARM) else None


def _slow_line(frequency: Array, power: Array, peaks: NDArray[np.bool_]) -> float | None:
    """Hz of the slower line that stands out most from the power around it; arguments as of `_fast_line`."""
    width = 2 * round(_NEIGHBOURS_HZ / frequency[1]) + 1
    prominence = power / np.maximum(median_filter(power, width), np.finfo(float).tiny)
    usable = (frequency > _SLOWEST_HZ) & (frequency <= _FAST_HZ) & peaks
    if not usable.any():
        return None
    best = int(np.argmax(np.where(usable, prominence, 0.0)))
    return float(frequency[best]) if prominence[best] > _STANDS_OUT else None


def _near_rocking(frequency: Array, run: LoggedRun) -> NDArray[np.bool_]:
    """(n,) whether a frequency is within the resolution of a multiple of the rocking's own."""
    interval, time, angle = resample_evenly(run.time, run.excitation)
    padded = _PADDING * time.size
    trend = np.polynomial.Polynomial.fit(time, angle, 1)(time)
    power = np.abs(np.fft.rfft((angle - trend) * np.hanning(time.size), padded))
    hertz = np.fft.rfftfreq(padded, interval)
    fundamental = float(hertz[np.argmax(np.where(hertz > _SLOWEST_ROCKING_HZ, power, 0.0))])
    # A period is known to a fraction of a turn over the run: harmonics are known as many times less well.
    order = np.arange(1, _HARMONICS + 1)
    tolerance = (1.0 + 0.1 * order) / run.duration
    # Where half of all frequencies would be near one, that distinguishes none.
    distinct = tolerance < 0.25 * fundamental
    away = np.abs(frequency[:, None] - order[distinct] * fundamental)
    return np.asarray((away < tolerance[distinct]).any(axis=1))


def _spectrum(run: LoggedRun, window: Callable[[int], Array] = np.hanning) -> tuple[Array, Array]:
    """Frequencies, Hz, and power of the detrended hook load (else torque); empty if the record is too short."""
    by_name = {channel.name: channel for channel in run.channels}
    channel = by_name.get("hook_load") or by_name.get("surface_torque")
    if channel is None or channel.time.size < _MIN_SPECTRUM:
        return np.empty(0), np.empty(0)
    interval, time, measured = resample_evenly(channel.time, channel.measured)
    padded = _PADDING * time.size
    trend = np.polynomial.Polynomial.fit(time, measured, 5)(time)
    power = np.abs(np.fft.rfft((measured - trend) * window(time.size), padded)) ** 2
    return np.asarray(np.fft.rfftfreq(padded, interval), dtype=np.float64), np.asarray(power, dtype=np.float64)
