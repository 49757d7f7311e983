"""Spectral lines of a record: what has a period of its own is not noise, however fast it is."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array

# Share of records of white noise in which a line is found.
LINE_FALSE_ALARM = 1e-4
# Lowest frequency of a line, of the sampling rate. Slower ones hardly show in fourth differences, and are mixed with
# the signal itself.
_FAST = 0.2
# Longest record, in samples expected per sample received, in which lines are looked for.
_LARGEST_GAP_SHARE = 2.0
# Most lines that are removed; a line whose frequency wanders counts as several.
_MAX_LINES = 8
# Zero padding of the spectrum, in lengths of the record, so that a line between two bins is not missed.
_PADDING = 16


def remove_lines(time: Array, values: Array, level: float) -> Array:
    """The record without its significant fast sinusoids; the same array if it has none.

    Args:
        time: (n,) s.
        values: (n,).
        level: Share of records of white noise in which a line may be found.
    """
    rest = values
    for _ in range(_MAX_LINES):
        frequency = _strongest_line(time, rest, level)
        if frequency is None:
            break
        angle = 2.0 * np.pi * frequency * time
        shape = np.column_stack([np.cos(angle), np.sin(angle)])
        # Fourth differences remove the slow signal.
        amount = np.linalg.lstsq(np.diff(shape, n=4, axis=0), np.diff(rest, n=4), rcond=None)[0]
        rest = rest - shape @ amount
    return rest


def resample_evenly(time: Array, values: Array) -> tuple[float, Array, Array]:
    """The record (n,) at even times, lost samples interpolated: a spectrum by sample number would shift frequencies.

    Returns:
        Interval s, time (m,) s, and values (m,).
    """
    interval = float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1] + 0.5 * interval, interval)
    return interval, even, np.interp(even, time, values)


def peak_is_significant(power: Array, padding: int, level: float) -> bool:
    """Whether the highest peak of a spectrum is more than white noise shows.

    Args:
        power: (n,) power by frequency.
        padding: Zero padding, in lengths of the record.
        level: Share of records of white noise in which a peak may be found.
    """
    # The power of noise is exponentially distributed: its median is ln 2 of its mean.
    noise = float(np.median(power)) / np.log(2.0)
    return bool(np.max(power) > noise * np.log(power.size / padding / level))


def _strongest_line(time: Array, values: Array, level: float) -> float | None:
    """Frequency of the strongest fast line, Hz; None if none is significant."""
    if time[-1] - time[0] > _LARGEST_GAP_SHARE * float(np.median(np.diff(time))) * time.size:
        return None
    interval, _, even = resample_evenly(time, values)
    differences = np.diff(even, n=4)
    padded = _PADDING * differences.size
    power = np.abs(np.fft.rfft(differences * np.hanning(differences.size), padded)) ** 2
    cycles = np.fft.rfftfreq(padded)
    fast = cycles > _FAST
    # Divided by the response of fourth differences, so that white noise is flat again.
    power = power[fast] / (2.0 * np.sin(np.pi * cycles[fast])) ** 8
    if not peak_is_significant(power, _PADDING, level):
        return None
    return float(cycles[fast][np.argmax(power)]) / interval
