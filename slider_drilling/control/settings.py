"""Settings of a controller: dataclass fields that know their unit, range and meaning.

One declaration serves the ROS parameters, the command line and the documentation; a value out of range is
refused with a reason, never clamped.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from slider_drilling.errors import InputError


@dataclasses.dataclass(frozen=True)
class Limits:
    """What a setting may be. low, high: inclusive; unit: as in documentation, `-` where there is none."""

    unit: str
    low: float
    high: float
    description: str


def setting(default: float, unit: str, low: float, high: float, description: str) -> Any:
    """A float field of a settings dataclass with its unit, inclusive range and meaning."""
    return dataclasses.field(default=default, metadata={"limits": Limits(unit, low, high, description)})


def limits_of(settings: Any) -> dict[str, Limits]:
    """Name -> Limits of every field that `setting` declared, in order; settings: an instance or its class."""
    return {field.name: field.metadata["limits"] for field in dataclasses.fields(settings)
            if "limits" in field.metadata}


def refusal(name: str, value: float, limits: Limits) -> str | None:
    """Why `value` cannot be used for setting `name`, or None where it can."""
    if not math.isfinite(value):
        return f"{name} = {value}: must be a finite number"
    if not limits.low <= value <= limits.high:
        return (f"{name} = {value:g} {limits.unit}: must be within {limits.low:g} to {limits.high:g} "
                f"{limits.unit}")
    return None


def check(settings: Any) -> None:
    """Raise InputError for the first field of a settings dataclass that is out of its range."""
    for name, limits in limits_of(settings).items():
        reason = refusal(name, getattr(settings, name), limits)
        if reason is not None:
            raise InputError(f"{type(settings).__name__}: {reason}")
