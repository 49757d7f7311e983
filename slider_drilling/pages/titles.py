"""Title of a page: well, time and target."""

from __future__ import annotations

import datetime
import math
from collections.abc import Sequence

from slider_drilling.clock_time import has_date
from slider_drilling.rig import Rig
from slider_drilling.units import Quantity, Text, sentence


def well_name(rig: Rig | None) -> Text:
    """The rig file's name for the well; otherwise its depth and inclination at the bit."""
    if rig is None:
        return "Well without a rig file"
    if rig.well.name:
        return rig.well.name
    depth = rig.string.length
    inclination = next((row[1] for row in rig.well.survey if row[0] >= depth - 1e-6), rig.well.survey[-1][1])
    return sentence("Well of ", Quantity(depth, "m", 4), f", {inclination:.0f} deg at the bit")


def utc_time(start: float, recorded: str = "") -> str:
    """Date and time in UTC.

    Args:
        start: Epoch seconds of the first sample.
        recorded: ISO 8601 time of the recording, used if ``start`` is a simulated clock.
    """
    if has_date(start):
        moment = datetime.datetime.fromtimestamp(start, datetime.timezone.utc)
    else:
        try:
            moment = datetime.datetime.fromisoformat(recorded).astimezone(datetime.timezone.utc)
        except ValueError:
            return ""
    return f"{moment:%-d %b %Y, %H:%M} UTC"


def target_text(angles: Sequence[float]) -> str:
    """"target 45 deg" for angles in rad; a count if there are more than four."""
    degrees = [f"{math.degrees(math.remainder(angle, 2.0 * math.pi)):.0f}" for angle in angles]
    if len(degrees) > 4:
        return f"{len(degrees)} targets"
    return f"target{'s' if len(degrees) > 1 else ''} {', '.join(degrees)} deg" if degrees else ""
