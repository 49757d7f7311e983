"""Toolface targets that an operator gives in degrees: half a turn to either side, refused beyond, never wrapped."""

from __future__ import annotations

import math

from slider_drilling.errors import InputError

MAX_TARGET_DEG = 180.0


def target_refusal(degrees: float | None) -> str | None:
    """Return why a toolface target (deg) is refused, or None where it can be held; None is no target yet."""
    if degrees is None or abs(degrees) <= MAX_TARGET_DEG:
        return None
    if not math.isfinite(degrees):
        return f"{degrees}: must be a finite number of degrees"
    same = math.remainder(degrees, 360.0)
    return f"{degrees:g} deg: must be within -{MAX_TARGET_DEG:g} to {MAX_TARGET_DEG:g}; the same direction is {same:g}"


def target_in_rad(degrees: float, name: str) -> float:
    """Return a toolface target in rad.

    Args:
        degrees: The target, deg.
        name: Of the option or argument, for the message.

    Raises:
        InputError: It is beyond half a turn, or not finite.
    """
    if refusal := target_refusal(degrees):
        raise InputError(f"{name} = {refusal}")
    return math.radians(degrees)
