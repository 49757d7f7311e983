"""Settings of a twin."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.errors import InputError
from slider_drilling.schema.option_types import check_option_types

LIMITS: dict[str, tuple[float, float]] = {
    "elements": (20, 400), "interval": (0.02, 0.5), "observer_gain": (0.0, 1.0), "patience": (0.0, 60.0),
    "learning": (60.0, 3600.0), "forecast": (0.0, 300.0), "forecast_every": (1.0, 600.0), "kept": (600.0, 14400.0),
    "check_every": (0.0, 3600.0),
}  # fmt: skip
"""Lowest and highest value of each setting."""


@dataclass(frozen=True)
class TwinSettings:
    """How a twin follows its rig.

    Attributes:
        elements: Of the simulated string.
        interval: s between samples of the simulation.
        observer_gain: Of the weak observer, see `slider_drilling.drillstring.observer`.
        patience: s that the twin waits for samples of the drives that are late.
        learning: s of undisturbed work after which the twin is calibrated and watches.
        forecast: s that a forecast looks ahead; 0 for none.
        forecast_every: s between two forecasts.
        kept: s of samples that are kept for a diagnosis.
        check_every: s between two regular checks, where there are diagnoses; 0 for none.
    """

    elements: int = 60
    interval: float = 0.1
    observer_gain: float = 0.3
    patience: float = 2.0
    learning: float = 180.0
    forecast: float = 60.0
    forecast_every: float = 10.0
    kept: float = 3600.0
    check_every: float = 150.0

    def __post_init__(self) -> None:
        check_option_types(self, "twin")
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"twin: {name} = {value:g}: must be within {low:g} to {high:g}")
