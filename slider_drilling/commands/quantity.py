"""Click option type: a number with its unit beside it, such as ``62klbf`` or ``"7000 ft lbf"``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import click

from slider_drilling.errors import InputError
from slider_drilling.units import KINDS, si_factor

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")


class QuantityType(click.ParamType):
    """A number with its unit, converted to the SI unit.

    Args:
        kind: A key of `slider_drilling.units.KINDS`.
        example: Shown in help and errors.
    """

    def __init__(self, kind: str, example: str):
        self.kind, self.name = kind, example

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        where = param.opts[0] if param is not None and param.opts else self.kind
        return read_quantity(str(value), self.kind, where, self.name)


def read_quantity(text: str, kind: str, where: str, example: str) -> float:
    """The SI value of a text like "62klbf". Raises InputError, also where the unit is missing."""
    match = _NUMBER.fullmatch(text)
    if match is None or not math.isfinite(float(match[1])):
        raise InputError(f"{where} = {text[:60]!r}: expected a number and its unit, such as {example}")
    if match[2] is None:
        raise InputError(f"{where} = {text[:60]!r}: has no unit; write it beside the number, such as {example} "
                         f"({', '.join(list(KINDS[kind])[:6])})")  # fmt: skip
    return float(match[1]) * si_factor(match[2], kind, where)


def read_depths(text: str, where: str) -> Sequence[float]:
    """Depths (m) of a text "FROM:TO" or "FROM:TO:STEP", or of one depth."""
    parts = [read_quantity(part, "length", where, "9000ft") for part in text.split(":")]
    if len(parts) == 1:
        return parts
    first, last = parts[:2]
    step = parts[2] if len(parts) == 3 else math.inf
    if len(parts) > 3 or not 0.0 < first < last or not step > 0.0:
        raise InputError(f"{where} = {text[:60]!r}: expected FROM:TO or FROM:TO:STEP with FROM below TO, such as "
                         "9000ft:14500ft:500ft")  # fmt: skip
    if math.isinf(step):
        count = 8
        return [first + (last - first) * k / (count - 1) for k in range(count)]
    depths = [first + step * k for k in range(int((last - first) / step + 1e-9) + 1)]
    return depths if last - depths[-1] < 1e-6 * last else [*depths, last]
