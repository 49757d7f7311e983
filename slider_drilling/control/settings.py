"""Settings of a controller: dataclass fields that know their unit, range and meaning.

One declaration serves the ROS parameters, the command line and the documentation. A value out of range is refused with
a reason, never clamped.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from slider_drilling.errors import InputError


@dataclasses.dataclass(frozen=True)
class Limits:
    """Range and meaning of a setting.

    Attributes:
        unit: As in the documentation; `-` where there is none.
        low: Smallest value allowed.
        high: Largest value allowed.
        description: One line.
    """

    unit: str
    low: float
    high: float
    description: str


def setting(default: float, unit: str, low: float, high: float, description: str) -> Any:
    """Return a float field of a settings dataclass, with its unit, inclusive range and meaning."""
    return dataclasses.field(default=default, metadata={"limits": Limits(unit, low, high, description)})


def limits_of(settings: Any) -> dict[str, Limits]:
    """Return the limits of every field that `setting` declared, in order.

    Args:
        settings: A settings dataclass or an instance of it.
    """
    return {field.name: field.metadata["limits"] for field in dataclasses.fields(settings)
            if "limits" in field.metadata}


def refusal(name: str, value: float, limits: Limits) -> str | None:
    """Return why `value` is refused for the setting `name`, or None where it is allowed."""
    if not math.isfinite(value):
        return f"{name} = {value}: must be a finite number"
    if not limits.low <= value <= limits.high:
        return (f"{name} = {value:g} {limits.unit}: must be within {limits.low:g} to {limits.high:g} "
                f"{limits.unit}")
    return None


def check(settings: Any) -> None:
    """Check every field of a settings dataclass.

    Raises:
        InputError: The first field that is out of its range.
    """
    for name, limits in limits_of(settings).items():
        reason = refusal(name, getattr(settings, name), limits)
        if reason is not None:
            raise InputError(f"{type(settings).__name__}: {reason}")
