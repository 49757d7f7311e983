"""How far the centre of rocking may lead for a toolface error, limited by the stability of the loop.

The toolface follows the centre with the time constant ``response_time / (1 + gain)``. The loop has a dead time: the
mean torque is known one rocking cycle late, the centre follows within one cycle, and MWD arrives only now and then. A
gain whose time constant is shorter than the dead time overshoots and oscillates. So a string that responds quickly gets
a smaller gain, and a string held by friction gets all of it. A lead beyond a share of the breakover amplitude frees the
whole string suddenly: the bit then turns as far as the centre went, whatever the gain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

_DEAD_TIME_CYCLES = 1.5   # rocking periods: one to average the torque, half of one for the centre to follow
_DEAD_TIME_MWD = 0.2      # of MWD's delay: between samples the surface torque shows most of the motion
_MIN_GAIN = 0.5
_MAX_LEAD_SHARE = 0.3     # of the breakover amplitude


@dataclass(frozen=True)
class ToolFaceResponse:
    """How the toolface responds to the centre of rocking.

    Attributes:
        response_time: Time constant of the toolface, s.
        rocking_period: s.
        mwd_delay: Period plus latency of MWD, s.
        tool_face_sigma: Standard deviation of the toolface estimate, rad.
        breakover_amplitude: Rocking amplitude that frees the whole string, rad.
    """

    response_time: float
    rocking_period: float
    mwd_delay: float
    tool_face_sigma: float
    breakover_amplitude: float


def stable_gain(response: ToolFaceResponse) -> float:
    """Largest centre shift per toolface error that keeps the loop stable, at least 0.5."""
    dead_time = _DEAD_TIME_CYCLES * response.rocking_period + _DEAD_TIME_MWD * response.mwd_delay
    return max(response.response_time / dead_time - 1.0, _MIN_GAIN)


def centre_lead(error: float, gain: float, max_lead: float, response: ToolFaceResponse) -> float:
    """Lead of the centre for a toolface error.

    Args:
        error: Target minus toolface, rad.
        gain: Largest gain to use.
        max_lead: Largest lead to either side, rad.
        response: Response of the toolface.

    Returns:
        Lead, rad, to the side of the error.
    """
    # Mean of the sine of a normally distributed angle: the lead vanishes where the toolface is unknown.
    confidence = math.exp(-0.5 * min(response.tool_face_sigma, math.pi) ** 2)
    max_lead = min(max_lead, _MAX_LEAD_SHARE * response.breakover_amplitude)
    return min(max(confidence * min(gain, stable_gain(response)) * error, -max_lead), max_lead)
