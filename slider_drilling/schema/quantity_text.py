"""Numbers with a unit written beside them, such as ``9.6 ppg`` or ``0.28 rev/gal``."""

from __future__ import annotations

import re

from slider_drilling.errors import InputError
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.units import KINDS, unit_factor

_QUANTITY = re.compile(r"""\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z%°º"µμ].*?)\s*""")
_PERCENT = 0.01
# A motor's displacement is volume per turn; its sheet gives turns per volume.
_RECIPROCALS = {"volume per turn": "turns per volume"}


def split_quantity(text: str) -> tuple[float, str] | None:
    """Number and unit of a text like "9.6 ppg" or "14500ft"; None for another text, such as one with a comma."""
    match = _QUANTITY.fullmatch(text)
    return None if match is None else (float(match[1]), match[2])


def convert_quantity(number: float, unit: str, target: str, where: str) -> float:
    """A number in one unit, in another of the same kind.

    Args:
        number: In `unit`.
        unit: As written by a user.
        target: A unit of `KINDS`, or "-" for a pure number, whose unit is "%".
        where: Starts the error message.

    Raises:
        InputError: The unit is not of the target's kind.
    """
    if unit == target:
        return number
    if target == "-":
        if unit == "%":
            return number * _PERCENT
        raise InputError(f"{where}: unit = {unit!r}: this is a pure number; leave the unit out, or write %")
    kinds = [kind for kind, units in KINDS.items() if target in units]
    for kind in kinds:
        inverse = _RECIPROCALS.get(kind)
        if inverse is not None and number != 0.0 and (factor := unit_factor(unit, inverse)) is not None:
            return 1.0 / (number * factor) / KINDS[kind][target]
        if (factor := unit_factor(unit, kind)) is not None:
            return number * factor / KINDS[kind][target]
    known = ", ".join(dict.fromkeys(name for kind in kinds for name in KINDS[kind])) or target
    other = [kind for kind in KINDS if unit_factor(unit, kind) is not None]
    fault = f"is a unit of {other[0]}, not of {kinds[0]}" if other and kinds else "not a unit of this number"
    raise InputError(f"{where}: unit = {unit!r}: {fault}; use {known}")


def read_quantity(text: str, target: str, where: str) -> float:
    """A number in the target unit from a text with its unit. Raises InputError, also where the unit is missing."""
    found = split_quantity(text)
    if found is None:
        comma = "; write it without a comma" if "," in text else ""
        raise InputError(f"{where} = {shorten(text)}: expected a number and its unit, such as 9.6 {target}{comma}")
    return convert_quantity(*found, target, where)

