"""Click option type: a number with its unit beside it, such as ``62klbf`` or ``"7000 ft lbf"``."""

from __future__ import annotations

import math
from collections.abc import Sequence

import click

from slider_drilling.errors import InputError
from slider_drilling.schema.quantity_text import read_quantity


class QuantityType(click.ParamType):
    """A number with its unit, converted to an SI unit.

    Args:
        unit: The SI unit.
        example: Shown in help.
    """

    def __init__(self, unit: str, example: str):
        self.unit, self.name = unit, example

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        number = read_quantity(str(value), self.unit, param.opts[0] if param is not None and param.opts else self.name)
        if not math.isfinite(number):
            raise InputError(f"{value}: must be a finite number")
        return number


def read_depths(text: str, where: str) -> Sequence[float]:
    """Depths (m) of a text "FROM:TO" or "FROM:TO:STEP", or of one depth."""
    parts = [read_quantity(part, "m", where) for part in text.split(":")]
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
