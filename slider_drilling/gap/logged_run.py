"""Logs to explain: what was commanded and what the sensors measured."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.gap.effect import Array


@dataclass(frozen=True)
class Channel:
    """What one sensor measured.

    Attributes:
        name: Its name.
        time: (n,) s, ascending.
        measured: (n,) values, in ``unit``.
        unit: Unit of the values.
        period: Period of a wrapped angle, else None.
        declared_noise: Standard deviation that somebody declares for the sensor, None if nobody does.
        resolution: Smallest step of the sensor, 0 if there is none.
        accumulates: Whether an error that a simulation makes once stays in every later sample, as in an angle that is
            integrated (`slider_drilling.gap.problem.step_loss`).
        model_error: Share of what the channel moves by which the model as such may be wrong, whatever its parameters.
        wander: RMS, in ``unit``, by which it may wander slowly, as any real system does. What is left within it is no
            gap.
        tolerance: RMS error, in ``unit``, that nobody would act upon. It counts as no gap where nothing else shows one.
    """

    name: str
    time: Array
    measured: Array
    unit: str = "-"
    period: float | None = None
    declared_noise: float | None = None
    resolution: float = 0.0
    accumulates: bool = False
    model_error: float = 0.0
    wander: float = 0.0
    tolerance: float = 0.0

    def residual(self, simulated: Array) -> Array:
        """measured - simulated, (..., n), wrapped to half a period either way where the channel wraps."""
        difference = self.measured - simulated
        if self.period is None:
            return difference
        return (difference + 0.5 * self.period) % self.period - 0.5 * self.period


@dataclass(frozen=True)
class LoggedRun:
    """One log: a main command and the measured channels.

    Attributes:
        name: Its name.
        time: (m,) s, ascending.
        excitation: (m,) the main command over ``time``.
        channels: What was measured.
        bands: Named frequency bands (name, from Hz, to Hz) to split the gap by, besides those of the excitation.
        command: What the excitation is, in words.
        command_unit: Its unit.
        cycle: What its cycles are called, in words.
        counts_from: s, from which on samples count in the reported errors; the likelihood counts all.
    """

    name: str
    time: Array
    excitation: Array
    channels: tuple[Channel, ...]
    bands: tuple[tuple[str, float, float], ...] = ()
    command: str = "the excitation"
    command_unit: str = "-"
    cycle: str = "cycle"
    counts_from: float = -math.inf

    @property
    def duration(self) -> float:
        """Length of the run, s."""
        return float(self.time[-1] - self.time[0])
