"""Colour names of all figures, and their values in light mode (and on paper) and in dark mode.

The palette of Okabe and Ito, which colour-blind readers can distinguish; brighter in dark mode. Lines that mean the
same on two pages have the same colour.
"""

from __future__ import annotations

INK = "ink"  # measured
BLUE = "blue"  # simulated, or under test
RED = "red"  # wrong, or a missed target
GREEN = "green"  # good, or accepted
PURPLE = "purple"
AMBER = "amber"  # setpoint or target
SKY = "sky"
GREY = "grey"  # for comparison

ORDER = (BLUE, RED, GREEN, PURPLE, AMBER, SKY, INK, GREY)
"""Order in which lines without a colour of their own take one."""

LIGHT = {INK: "#1c2733", BLUE: "#0072b2", RED: "#d55e00", GREEN: "#009e73", PURPLE: "#cc79a7", AMBER: "#e69f00",
         SKY: "#56b4e9", GREY: "#7b8794"}  # fmt: skip
DARK = {INK: "#e8edf2", BLUE: "#4fa9e2", RED: "#f3854a", GREEN: "#35c299", PURPLE: "#e2a3c8", AMBER: "#f2b845",
        SKY: "#93d0f5", GREY: "#96a2ae"}  # fmt: skip
