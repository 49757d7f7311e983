"""Lines in a record: what has a period of its own is no noise, however fast it is."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array

# How rarely noise alone has a line that is taken for one.
LINE_FALSE_ALARM = 1e-4
# Of the sampling rate: slower lines hardly show in fourth differences, and the signal's own course is there.
_FAST = 0.2
# A record of which less than one sample in so many is there shows no line.
_WHOLE = 2.0
# Lines of a record that are looked for; one whose frequency wanders is several.
_MOST = 8
# Spectra are taken this many times as fine as the record is long: within that a line keeps its phase.
_PADDING = 16


def remove_lines(time: Array, values: Array, level: float) -> Array:
    """A record, time s and values (n,), without the fast sinusoids that its noise does not explain; the same where it
    has none. level: how often noise alone may have one.
    """
    left = values
    for _ in range(_MOST):
        frequency = _strongest_line(time, left, level)
        if frequency is None:
            break
        angle = 2.0 * np.pi * frequency * time
        shape = np.column_stack([np.cos(angle), np.sin(angle)])
        # In differences the signal's own course weighs nothing.
        amount = np.linalg.lstsq(np.diff(shape, n=4, axis=0), np.diff(left, n=4), rcond=None)[0]
        left = left - shape @ amount
    return left


def resample_evenly(time: Array, values: Array) -> tuple[float, Array, Array]:
    """Interval s, time s and values (m,) of a record, evenly sampled whatever was lost: frequencies counted in samples
    that came are off by the share that did not.
    """
    interval = float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1] + 0.5 * interval, interval)
    return interval, even, np.interp(even, time, values)


def peak_is_significant(power: Array, padding: int, level: float) -> bool:
    """Whether the strongest of these powers (n,) of a spectrum is more than noise alone has, but for a share level of
    the records; padding: how many times as fine as the record is long the spectrum is.
    """
    # The power of noise is exponentially distributed: its median is ln 2 of its mean.
    noise = float(np.median(power)) / np.log(2.0)
    return bool(np.max(power) > noise * np.log(power.size / padding / level))


def _strongest_line(time: Array, values: Array, level: float) -> float | None:
    """Frequency Hz of the strongest of the fast lines, None where none stands out of the noise."""
    if time[-1] - time[0] > _WHOLE * float(np.median(np.diff(time))) * time.size:
        return None
    interval, _, even = resample_evenly(time, values)
    differences = np.diff(even, n=4)
    padded = _PADDING * differences.size
    power = np.abs(np.fft.rfft(differences * np.hanning(differences.size), padded)) ** 2
    cycles = np.fft.rfftfreq(padded)
    fast = cycles > _FAST
    # What differences make of white noise.
    power = power[fast] / (2.0 * np.sin(np.pi * cycles[fast])) ** 8
    if not peak_is_significant(power, _PADDING, level):
        return None
    return float(cycles[fast][np.argmax(power)]) / interval
