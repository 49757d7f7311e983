"""Sizes as a rig floor writes them: ``8 1/2``, ``6-3/4 in``, ``5"``, ``19.50#``."""

from __future__ import annotations

import re

_FRACTION = r"(?:(\d+)[- ])?(\d+)/(2|4|8|16|32)(?!\d)"
_SIZE = re.compile(rf"(?<![\d.]){_FRACTION}|(?<![\d./])(\d+(?:\.\d+)?)\s*(?:in\b|inch\b|\")")
_POUNDS = re.compile(r"(\d+(?:\.\d+)?)\s*(?:#|ppf\b|lbs?/ft\b)")
_GRADE = re.compile(r"\b([EXGS])\s*-?\s*(?:75|95|105|135)\b", re.IGNORECASE)


def size_in_text(text: str) -> float | None:
    """The first size in a text, in; None without one."""
    for match in _SIZE.finditer(text):
        whole, over, under, decimal = match.groups()
        if decimal is not None:
            return float(decimal)
        value = int(whole or 0) + int(over) / int(under)
        # "7/8" alone is a pair of lobes.
        if whole is not None:
            return value
    return None


def pounds_in_text(text: str) -> float | None:
    """The nominal weight of pipe in a text, lb/ft; None without one."""
    match = _POUNDS.search(text)
    return None if match is None else float(match[1])


def grade_in_text(text: str) -> str | None:
    """The letter of the grade in a text, such as S for S-135; None without one."""
    match = _GRADE.search(text)
    return None if match is None else match[1].upper()
