"""Pick-up, slack-off and rotating weights and free torque, as drillers write them down: by hand or from a table.

The hook loads of a reading include the block, top drive and hoses unless the weight indicator is tared.
"""

from __future__ import annotations

import csv
import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text
from slider_drilling.units import FIELD, SI, Units, si_factor

# Quantity of a column: how its head may begin, and the kind of its unit.
_COLUMNS = {
    "depth": (("bit", "measured", "md", "depth"), "length"),
    "torque": (("torque", "free torque", "rotating torque", "off bottom torque", "tq"), "torque"),
    "pick_up": (("pick", "pu"), "force"),
    "slack_off": (("slack", "so"), "force"),
    "rotating": (("rot",), "force"),
}
_UNIT = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$|_([A-Za-z]+)$")
MOTIONS = ("pick_up", "slack_off", "rotating")


@dataclass(frozen=True)
class DrillerWeights:
    """Readings off bottom at one bit depth; one that was not taken is None.

    Attributes:
        depth: Measured depth of the bit, m.
        pick_up, slack_off: Hook load while the string is raised and lowered without rotation, N.
        rotating: Hook load while it rotates at a constant depth, N.
        torque: Surface torque of that rotation, N m.
    """

    depth: float
    pick_up: float | None = None
    slack_off: float | None = None
    rotating: float | None = None
    torque: float | None = None

    def hook_loads(self) -> dict[str, float]:
        """The hook loads that were read, N, by motion."""
        loads = {motion: getattr(self, motion) for motion in MOTIONS}
        return {motion: load for motion, load in loads.items() if load is not None}

    def without(self, block_weight: float) -> DrillerWeights:
        """The weights of the string alone: `block_weight` (N) taken off every hook load."""
        return replace(self, **{motion: load - block_weight for motion, load in self.hook_loads().items()})


def check_weights(weights: DrillerWeights, where: str, units: Units = SI) -> DrillerWeights:
    """The readings, if they are possible.

    Raises:
        InputError: There is no reading, one is not positive, or pick-up, rotating and slack-off are not in this order.
    """
    loads = weights.hook_loads()
    if not loads and weights.torque is None:
        raise InputError(f"{where}: no reading; give a pick-up, slack-off or rotating weight, or a free torque")
    given = {**loads, **({} if weights.torque is None else {"torque": weights.torque})}
    for name, value in {"depth": weights.depth, **given}.items():
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{where}: {_words(name)} = {value:g}: must be a number above 0")
    ordered = [motion for motion in ("pick_up", "rotating", "slack_off") if motion in loads]
    for high, low in itertools.pairwise(ordered):
        if loads[high] < loads[low]:
            values = [units.format(loads[motion] / 1e3, "kN", 4) for motion in (high, low)]
            raise InputError(
                f"{where}: {_words(high)} weight {values[0]} is below {_words(low)} weight {values[1]}; "
                "are they swapped?"
            )
    return weights


def read_driller_weights(path: Path) -> tuple[DrillerWeights, ...]:
    """Readings from a CSV table: one line for each bit depth.

    The first line names the columns with their units, such as ``Bit depth [ft], Pick-up [klbf], Slack-off [klbf],
    Rotating [klbf], Torque [ft lbf]``. The depth and one other column are needed; an empty cell is a reading that was
    not taken.

    Raises:
        InputError: Naming file and line of what cannot be read.
    """
    lines = read_text(path, "table of weights").splitlines()
    if not lines:
        raise InputError(f"{path}: empty; give a table of bit depth and weights with a header line")
    delimiter = max(",;\t", key=lines[0].count)
    heads = [head.strip() for head in next(csv.reader([lines[0]], delimiter=delimiter))]
    factors = _factors(heads, path)
    if "depth" not in factors or len(factors) < 2:
        raise InputError(
            f"{path}: columns {', '.join(heads)}: need the bit depth and at least one of pick-up, slack-off, rotating "
            "and torque, each with its unit, such as Pick-up [klbf]"
        )
    rows = []
    for number, cells in enumerate(csv.reader(lines[1:], delimiter=delimiter), start=2):
        if any(cell.strip() for cell in cells):
            where = f"{path}: line {number}"
            values = {name: _value(cells, place, heads[place], factor, where)
                      for name, (place, factor) in factors.items()}  # fmt: skip
            depth = values.pop("depth")
            if depth is None:
                raise InputError(f"{where}: no bit depth; fill it in")
            rows.append(check_weights(DrillerWeights(depth, **values), where, FIELD))
    if not rows:
        raise InputError(f"{path}: no line with readings below the header")
    return tuple(rows)


def _factors(heads: Sequence[str], path: Path) -> dict[str, tuple[int, float]]:
    """Place of each known column and the SI value of its unit."""
    factors: dict[str, tuple[int, float]] = {}
    for place, head in enumerate(heads):
        for name, (beginnings, kind) in _COLUMNS.items():
            if not re.sub("[-_]", " ", head.lower()).startswith(beginnings):
                continue
            if name in factors:
                raise InputError(f"{path}: columns {heads[factors[name][0]]!r} and {head!r}: both are the "
                                 f"{_words(name)}; keep one")  # fmt: skip
            unit = _UNIT.search(head)
            if unit is None:
                raise InputError(f"{path}: column {head!r}: has no unit; write it in brackets, such as {head} [klbf]")
            factors[name] = (place, si_factor(unit[1] or unit[2], kind, f"{path}: column {head!r}"))
            break
    return factors


def _value(cells: Sequence[str], place: int, head: str, factor: float, where: str) -> float | None:
    text = cells[place].strip() if place < len(cells) else ""
    if not text:
        return None
    try:
        return float(text) * factor
    except ValueError:
        raise InputError(f"{where}: {head} = {text!r}: not a number; leave the cell empty if it was not read") from None


def _words(name: str) -> str:
    return name.replace("_", "-") if name in MOTIONS else name
