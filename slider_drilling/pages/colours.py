"""The colours of every figure: names, and what each is in light, in dark and on paper.

Okabe and Ito's, told apart by colour-blind readers too; in dark, the same hues brighter. Lines that mean the same on
two pages have the same colour.
"""

from __future__ import annotations

INK = "ink"  # what was measured
BLUE = "blue"  # what is simulated, or under test
RED = "red"  # what is wrong, or a target missed
GREEN = "green"  # what is good, or accepted
PURPLE = "purple"
AMBER = "amber"  # what was asked for
SKY = "sky"
GREY = "grey"  # what is only there to compare with

ORDER = (BLUE, RED, GREEN, PURPLE, AMBER, SKY, INK, GREY)
"""Of lines without a colour of their own."""

LIGHT = {INK: "#1c2733", BLUE: "#0072b2", RED: "#d55e00", GREEN: "#009e73", PURPLE: "#cc79a7", AMBER: "#e69f00",
         SKY: "#56b4e9", GREY: "#7b8794"}  # fmt: skip
DARK = {INK: "#e8edf2", BLUE: "#4fa9e2", RED: "#f3854a", GREEN: "#35c299", PURPLE: "#e2a3c8", AMBER: "#f2b845",
        SKY: "#93d0f5", GREY: "#96a2ae"}  # fmt: skip
