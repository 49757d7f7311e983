"""The pipe of the paper's simulations: Table 1."""

from __future__ import annotations

import math
from dataclasses import dataclass

GRAVITY = 9.81
"""m/s2."""


@dataclass(frozen=True)
class Pipe:
    """A length of drill pipe on the low side of a hole; the defaults are the paper's Table 1.

    Attributes:
        length, outer_diameter, inner_diameter, hole_diameter: m.
        density, mud_density: kg/m3.
        inclination: rad.
    """

    length: float = 10.0
    outer_diameter: float = 0.127
    inner_diameter: float = 0.1086
    hole_diameter: float = 0.2156
    density: float = 7850.0
    mud_density: float = 2200.0
    inclination: float = 0.5 * math.pi

    @property
    def radius(self) -> float:
        """Outer radius, m."""
        return 0.5 * self.outer_diameter

    @property
    def normal_force(self) -> float:
        """Buoyed weight that presses on the wall, N; 1887 N for Table 1."""
        steel = 0.25 * math.pi * (self.outer_diameter**2 - self.inner_diameter**2)
        return (self.density - self.mud_density) * steel * self.length * GRAVITY * math.sin(self.inclination)
