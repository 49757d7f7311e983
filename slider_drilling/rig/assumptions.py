"""Numbers of a rig file that stand on no paper: defaults, each with its spread and the reason.

In the file such a number is written as keys and values::

    axial_damping: {value: 0.15, spread: 0.1, assumed: true, why: mud gives 0.1 to 1}
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.schema.changes import key_steps
from slider_drilling.schema.fields import NumberField
from slider_drilling.schema.quantity_text import convert_quantity, split_quantity
from slider_drilling.schema.yaml_tree import shorten

_KEYS = ("value", "spread", "assumed", "why")


@dataclass(frozen=True)
class Assumption:
    """A number of a rig file that was assumed.

    Attributes:
        key: From the top, such as ``string.axial_damping``.
        spread: One standard deviation of what such rigs have, in the key's unit.
        why: Where default and spread come from.
    """

    key: str
    spread: float
    why: str = ""


def take_assumptions(tree: Any, numbers: Sequence[NumberField], source: str) -> tuple[Any, tuple[Assumption, ...]]:
    """A rig file's tree with plain numbers, and its assumptions.

    Args:
        tree: As YAML gives it; it is not changed.
        numbers: The numbers of a rig file.
        source: Names the file in errors.

    Raises:
        InputError: An assumed number lacks its value or spread, or has another key.
    """
    units = {number.key: number.range.unit for number in numbers}
    found: list[Assumption] = []

    def plain(node: Any, key: str) -> Any:
        if isinstance(node, list):
            return [plain(item, f"{key}[{index}]") for index, item in enumerate(node)]
        if not isinstance(node, dict):
            return node
        unit = units.get(re.sub(r"\[\d+\]", "[]", key))
        if unit is not None and "value" in node:
            found.append(_assumption(node, key, unit, source))
            return node["value"]
        return {name: plain(item, f"{key}.{name}" if key else str(name)) for name, item in node.items()}

    return plain(tree, ""), tuple(item for item in found if item.spread > 0.0)


def put_assumptions(tree: dict[str, Any], assumptions: Sequence[Assumption]) -> dict[str, Any]:
    """A tree of plain numbers with its assumed ones as keys and values; the inverse of `take_assumptions`."""
    for item in assumptions:
        *above, last = key_steps(item.key)
        node: Any = tree
        for step in above:
            node = node[step]
        entry = {"value": node[last], "spread": item.spread, "assumed": True}
        node[last] = entry | ({"why": item.why} if item.why else {})
    return tree


def _assumption(node: dict[str, Any], key: str, unit: str, source: str) -> Assumption:
    for name in node:
        if name not in _KEYS:
            raise InputError(f"{source}: {key}.{name}: unknown key; an assumed number has {', '.join(_KEYS)}")
    if not isinstance(node.get("assumed", True), bool):
        raise InputError(f"{source}: {key}.assumed = {shorten(node['assumed'])}: expected true or false")
    why = node.get("why", "")
    if not isinstance(why, str):
        raise InputError(f"{source}: {key}.why = {shorten(why)}: expected text")
    return Assumption(key, _spread(node, f"{source}: {key}", unit) if node.get("assumed", True) else 0.0, why)


def _spread(node: dict[str, Any], where: str, unit: str) -> float:
    raw, value = node.get("spread"), node["value"]
    shown = f"{where}.spread = {shorten(raw)}"
    found = split_quantity(raw) if isinstance(raw, str) else None
    if found is not None and found[1] == "%" and isinstance(value, (int, float)):
        spread = 0.01 * found[0] * abs(value)
    elif found is not None:
        spread = convert_quantity(*found, unit, shown)
    elif isinstance(raw, (int, float)) and not isinstance(raw, bool):
        spread = float(raw)
    else:
        raise InputError(f"{shown}: expected a number in {unit}: how far such rigs commonly lie from the value")
    if not 0.0 < spread < 1e15:
        raise InputError(f"{shown}: must be above 0")
    return spread
