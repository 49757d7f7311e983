"""Friction that depends on the pipe's own angle. It is not in the catalogue: a diagnosis should call it unknown."""

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
