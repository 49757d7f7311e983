"""The unit in which a driller reads each SI unit: kN m for N m, bar for Pa, deg for rad."""

from __future__ import annotations

from slider_drilling.units import KINDS, Quantity

_DISPLAY_UNITS = {"N m": "kN m", "N": "kN", "Pa": "bar", "rad": "deg"}


def display_unit(unit: str) -> tuple[str, float]:
    """The unit shown for an SI unit, and the factor that converts a value to it."""
    shown = _DISPLAY_UNITS.get(unit, unit)
    factors = (units[unit] / units[shown] for units in KINDS.values() if unit in units and shown in units)
    return shown, next(factors, 1.0)


def displayed(value: float | None, unit: str, digits: int = 3) -> Quantity:
    """A value of an SI unit as the quantity that is shown; "-" is the unit of a plain number."""
    shown, factor = display_unit(unit)
    return Quantity(None if value is None else value * factor, "" if shown == "-" else shown, digits)
