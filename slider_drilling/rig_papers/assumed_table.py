"""The assumed numbers of a rig as one table."""

from __future__ import annotations

import math
import operator
import re
from functools import reduce
from typing import Any

from slider_drilling.rig import Rig
from slider_drilling.schema.changes import key_steps
from slider_drilling.schema.fields import number_fields, to_tree
from slider_drilling.units import SI, Units, format_number

_SMALL = 1e-3  # m; shorter lengths and contact stiffness have no field unit


def assumed_rows(rig: Rig, units: Units) -> list[tuple[str, str, str]]:
    """(key, "value +/- spread unit", why) of every number of the rig that stands on no paper.

    Args:
        rig: The rig.
        units: For display.
    """
    of_key = {number.key: number.range.unit for number in number_fields(Rig)}
    tree: Any = to_tree(rig)
    rows = []
    for item in rig.assumed:
        unit = of_key[re.sub(r"\[\d+\]", "[]", item.key)]
        value = float(reduce(operator.getitem, key_steps(item.key), tree))
        rows.append((item.key, _shown(value, item.spread, unit, units), item.why))
    return rows


def _shown(value: float, spread: float, unit: str, units: Units) -> str:
    if unit == "rad":
        value, spread, unit = math.degrees(value), math.degrees(spread), "deg"
    own = SI if unit == "N/m" or (unit == "m" and abs(value) < _SMALL) else units
    number, sigma = (format_number(own.convert(item, unit)) for item in (value, spread))
    return f"{number} +/- {sigma} {'' if unit == '-' else own.display_unit(unit)}".rstrip()
