"""Texts of nodes in the units of the page: nodes write SI, each number with its unit behind it."""

from __future__ import annotations

import re

from slider_drilling.units import FIELD_UNITS, Units, format_number

_LONGEST_FIRST = "|".join(re.escape(unit) for unit in sorted(FIELD_UNITS, key=len, reverse=True))
_QUANTITY = re.compile(rf"(?<![\w.])([+-]?)(\d+(?:\.\d+)?) ({_LONGEST_FIRST})(?![\w/]| m\b)")


def convert_status(text: str, units: Units) -> str:
    """A text with its quantities in other units, with as many digits as they had: "3240 m" -> "10630 ft"."""

    def converted(found: re.Match[str]) -> str:
        sign, number, unit = found.groups()
        shown = units.display_unit(unit)
        if shown == unit:
            return found[0]
        digits = max(len(number.replace(".", "").lstrip("0")), 1)
        return f"{sign}{format_number(units.convert(float(number), unit), digits)} {shown}"

    return _QUANTITY.sub(converted, text)
