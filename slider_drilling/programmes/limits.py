"""StepLimits of a step: torque, weight on bit, pressure, toolface, and whether the bit may be on bottom."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.schema.fields import quantity
from slider_drilling.units import SI, display_unit, displayed, sentence

_TORQUE: dict[str, Any] = {"at_least": 500.0, "at_most": 5e5, "usual": (500.0, 5e5), "mistaken_for": ("kN m",)}
_MAKE_UP, _BACK_OFF = 25e3, 15e3  # N m; those of the slide controller
_TORQUE_SHARE = 0.9  # of the weakest connection and of the top drive, for limits that the file leaves out
_WEIGHT_SHARE, _STALL_SHARE = 0.85, 0.85  # of the motor's largest pressure
_TOLERANCE = math.radians(30.0)
CIRCULATION_SHARE = 0.95
"""Share of a pressure limit that circulation alone must stay below."""

ON_BOTTOM, OFF_BOTTOM, EITHER = "on bottom", "off bottom", "either"


class LimitError(InputError):
    """A limit that cannot be used, or not on this rig.

    Args:
        name: Of the argument.
        value: SI unit.
        unit: The SI unit.
        reason: Why, and what to do.

    Attributes:
        name: Of the argument.
        reason: The value, why it cannot be used, and what to do.
    """

    def __init__(self, name: str, value: float, unit: str, reason: str) -> None:
        self.name, self.reason = name, f"{sentence(displayed(value, unit))}: {reason}"
        super().__init__(f"{name} = {self.reason}")


@dataclass(frozen=True)
class StepLimits:
    """What a step must not exceed; a step that is about to is aborted.

    What a step leaves out holds from the programme; what the programme leaves out, from the rig file.

    Attributes:
        right_torque: Surface torque to the right (make-up).
        left_torque: Surface torque to the left (back-off).
        weight_on_bit: Largest weight on bit.
        pressure: Largest standpipe pressure, gauge.
        tool_face_tolerance: Largest toolface error while a slide drills at its target.
        bit: "on bottom", "off bottom", or "either".
    """

    right_torque: float | None = quantity("N m", None, **_TORQUE)
    left_torque: float | None = quantity("N m", None, **_TORQUE)
    weight_on_bit: float | None = quantity("N", None, at_least=5e3, at_most=2e6, usual=(5e3, 2e6),
                                           mistaken_for=("kN",))  # fmt: skip
    pressure: float | None = quantity("Pa", None, at_least=1e5, at_most=1.5e8, usual=(1e6, 1.5e8),
                                      mistaken_for=("bar",))  # fmt: skip
    tool_face_tolerance: float | None = quantity("rad", None, at_least=0.26, at_most=math.pi,
                                                 why="15 to 180 deg: its estimate needs some")  # fmt: skip
    bit: str | None = None

    def over(self, wider: StepLimits) -> StepLimits:
        """These limits; where one is left out, the other's."""
        given = {field.name: value for field in fields(self) if (value := getattr(self, field.name)) is not None}
        return replace(wider, **given)


@dataclass(frozen=True)
class CompleteLimits:
    """StepLimits of which none is left out; attributes as in `StepLimits`."""

    right_torque: float
    left_torque: float
    weight_on_bit: float
    pressure: float
    tool_face_tolerance: float
    bit: str


def check_bit(limits: StepLimits, source: str, where: str) -> None:
    """Check the word for the bit. Raises InputError."""
    known = (ON_BOTTOM, OFF_BOTTOM, EITHER)
    if limits.bit is not None and limits.bit not in known:
        raise InputError(f"{source}: {where}.bit = {limits.bit[:60]!r}: must be {', '.join(known[:2])} or {known[2]}")


def check_ranges(limits: StepLimits) -> None:
    """Check each number against the range that a programme's file allows. Raises LimitError."""
    for field in fields(limits):
        value, range_ = getattr(limits, field.name), field.metadata.get("range")
        if value is None or range_ is None:
            continue
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"{field.name} = {str(value)[:60]!r}: expected a number in {range_.unit}")
        if range_.complaint(value) is not None:
            shown, factor = display_unit(range_.unit)
            ends = SI.format_range(factor * range_.at_least, factor * range_.at_most, shown)
            raise LimitError(field.name, value, range_.unit, f"must be {ends}")


def check_torque_limits(limits: StepLimits, rig: Rig) -> None:
    """Check that the top drive gives no torque limit less, nor a make-up torque of the weakest connection, if known.

    To the left a torque above that may open the connection, to the right it makes it up further.

    Raises:
        LimitError: One is too large.
    """
    weakest, most = rig.string.weakest_make_up_torque, rig.top_drive.max_torque
    for name, what in (("left_torque", "may back off"), ("right_torque", "makes up further")):
        torque = getattr(limits, name)
        if torque is None:
            continue
        if weakest is not None and torque > weakest:
            given = displayed(weakest, "N m")
            reason = sentence(f"{what} the weakest connection of the rig file, made up with ", given, "; give less")
            raise LimitError(name, torque, "N m", str(reason))
        if torque > most:
            given = displayed(most, "N m")
            reason = sentence("is more than the top drive of the rig file gives; give ", given, " at most")
            raise LimitError(name, torque, "N m", str(reason))


def check_on_rig(limits: StepLimits, rig: Rig) -> None:
    """Check that string and top drive take a torque limit, and that circulation leaves room below a pressure limit.

    Raises:
        LimitError: They do not, or it does not.
    """
    check_torque_limits(limits, rig)
    circulating = rig.circulating_pressure
    if limits.pressure is not None and circulating >= CIRCULATION_SHARE * limits.pressure:
        least = displayed(circulating / CIRCULATION_SHARE, "Pa")
        reason = sentence("circulation alone takes ", displayed(circulating, "Pa"), "; give more than ", least)
        raise LimitError("pressure", limits.pressure, "Pa", str(reason))


def rig_limits(rig: Rig) -> StepLimits:
    """StepLimits that a rig file implies.

    Torque: those of the slide controller, or less where a connection or the top drive takes less. Weight and pressure:
    the share of the motor's largest pressure that counts as stall.
    """
    weakest = rig.string.weakest_make_up_torque
    most = _TORQUE_SHARE * min(math.inf if weakest is None else weakest, rig.top_drive.max_torque)
    weight = _WEIGHT_SHARE * rig.motor.max_pressure * rig.motor.torque_per_pressure / rig.bit.lever
    pressure = rig.circulating_pressure + _STALL_SHARE * rig.motor.max_pressure
    return StepLimits(min(_MAKE_UP, most), min(_BACK_OFF, most), weight, pressure, _TOLERANCE, EITHER)


def complete(step: StepLimits, programme: StepLimits, rig: Rig) -> CompleteLimits:
    """The limits of a step on a rig: its own, else the programme's, else the rig's."""
    merged = step.over(programme).over(rig_limits(rig))
    return CompleteLimits(**{field.name: getattr(merged, field.name) for field in fields(merged)})
