"""Angles of the same direction within one turn."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.float64])


def wrap_angle(angle: Angle) -> Angle:
    """The same direction, rad, in (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


def wrap_degrees(degrees: Angle) -> Angle:
    """The same direction, degrees, in (-180, 180]."""
    return 180.0 - (180.0 - degrees) % 360.0
