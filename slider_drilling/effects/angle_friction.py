"""Friction by the pipe's own angle or direction; not in the catalogue: a diagnosis should call it unknown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.float64])


@dataclass(frozen=True)
class AngleFriction:
    """Friction of a bent pipe that lies against the wall once a turn: ``mu (1 + amplitude wave(angle + phase))``.

    Attributes:
        amplitude: Share of the friction.
        phase: In rad.
        wave: `np.cos`, or `np.sin` where the phase counts from the angle of average friction.
    """

    amplitude: float
    phase: float = 0.0
    wave: np.ufunc = np.cos

    def __call__(self, angle: Angle) -> Angle:
        """Returns the factor on friction.

        Args:
            angle: Of the pipe in rad, one number or one for each element, (n,).
        """
        factor: Angle = 1.0 + self.amplitude * self.wave(angle + self.phase)
        return factor


@dataclass(frozen=True)
class DirectionFriction:
    """Friction that is larger while a pipe turns right than while it turns left.

    Attributes:
        excess: Share by which it is larger; negative where it is smaller.
    """

    excess: float

    def __call__(self, speed: Angle) -> Angle:
        """Returns the factor on friction.

        Args:
            speed: Of the pipe in rad/s, one number or one for each element, (n,).
        """
        turns_right = np.asarray(speed > 0.0, dtype=np.float64)
        factor: Angle = 1.0 + self.excess * turns_right  # type: ignore[assignment]
        return factor
