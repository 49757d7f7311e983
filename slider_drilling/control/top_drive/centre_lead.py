"""How far the centre may lead for an error of the toolface: as far as the loop bears, and no further.

What pulls turns the bit within ``response time / (1 + gain)``. A loop that learns of it later than that turns too far,
pulls back too far, and goes round. How late it is, is known: rocking shows the mean torque a cycle late and the centre
follows within one, MWD comes now and then. So a string that answers quickly gets a smaller gain, one that friction
holds the whole of it. And more than a share of the amplitude that frees the whole string breaks it free all at once:
the bit then turns as far as the centre went, whatever the gain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

_CYCLES_LATE = 1.5     # of a cycle of rocking: the centre follows, the mean is taken
_MWD_LATE = 0.2        # of MWD's period and latency: between samples the string's torque tells
_LEAST_GAIN = 0.5
_LEAD_SHARE = 0.3      # of the amplitude that frees the whole string


@dataclass(frozen=True)
class ToolFaceResponse:
    """How the toolface answers. response_time: s, in which it follows what pulls; cycle: s, of rocking; mwd: s, the
    period and the latency of MWD together; spread: rad, one standard deviation of the toolface; freeing: rad, the
    amplitude that frees the whole string."""

    response_time: float
    rocking_period: float
    mwd_delay: float
    tool_face_sigma: float
    breakover_amplitude: float


def stable_gain(answer: ToolFaceResponse) -> float:
    """Centre shift per error that the loop bears."""
    late = _CYCLES_LATE * answer.rocking_period + _MWD_LATE * answer.mwd_delay
    return max(answer.response_time / late - 1.0, _LEAST_GAIN)


def centre_lead(error: float, gain: float, most: float, answer: ToolFaceResponse) -> float:
    """rad that the centre leads by for an error (rad): gain and most (rad) as wished."""
    # The mean of the sine of an angle that is normal about its estimate: one that may be any is worth no pull.
    certain = math.exp(-0.5 * min(answer.tool_face_sigma, math.pi) ** 2)
    most = min(most, _LEAD_SHARE * answer.breakover_amplitude)
    return min(max(certain * min(gain, stable_gain(answer)) * error, -most), most)
