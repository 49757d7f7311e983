"""A crew that rocks by hand: fixed settings, which it changes from time to time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.control.fixed_rocking import FixedRockingSettings, rounding_for, settings_for
from slider_drilling.rig import Rig

_HELD_S = (80.0, 250.0, 800.0, 1e9)  # s, from one change of the rocking to the next; a crew keeps to one of these
_HELD_SPREAD = (0.8, 1.3)
_AMPLITUDES = (0.5, 1.8)  # of the one that suits the well
_SPEEDS = (1.8, 5.0)  # rad/s, mean of a stroke
_BLOCK_SPEEDS = (0.0015, 0.003)  # m/s
_SHIFT_GAINS = (0.0, 0.1)  # a crew that does not steer, and one that does


@dataclass(frozen=True)
class RockingChange:
    """From a time of the slide on, s, the crew rocks with these settings; the pump stays as it is."""

    start: float
    settings: FixedRockingSettings


def draw_rocking(generator: np.random.Generator, rig: Rig, duration: float) -> tuple[RockingChange, ...]:
    """What a crew does in a slide of this duration, s: the first settings from the start on, then every change."""
    held, gain = float(generator.choice(_HELD_S)), float(generator.choice(_SHIFT_GAINS))
    suited, start = settings_for(rig), 0.0
    changes: list[RockingChange] = []
    while start < duration:
        amplitude = suited.amplitude * float(generator.uniform(*_AMPLITUDES))
        period = 4.0 * amplitude / float(generator.uniform(*_SPEEDS))
        settings = replace(
            suited, amplitude=amplitude, period=period, rounding=rounding_for(rig, amplitude, period), shift_gain=gain,
            block_speed=float(generator.uniform(*_BLOCK_SPEEDS)),
        )  # fmt: skip
        changes.append(RockingChange(start, settings))
        start += held * float(generator.uniform(*_HELD_SPREAD))
    return tuple(changes)


def settings_at(changes: Sequence[RockingChange], time: float) -> FixedRockingSettings:
    """The settings at a time of the slide, s."""
    return [each.settings for each in changes if each.start <= time][-1]
