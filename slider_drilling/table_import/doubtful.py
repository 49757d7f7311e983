"""What a table and its mapping leave in doubt: points among decimal commas, units that contradict each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from slider_drilling.errors import InputError
from slider_drilling.schema.yaml_tree import shorten
from slider_drilling.table_import.delimited_text import split_head
from slider_drilling.table_import.mapping import TableMapping, kind_of_column
from slider_drilling.table_import.numbers import POINT_GROUPS
from slider_drilling.table_import.source import Heads, Table
from slider_drilling.units import KINDS, unit_factor


def check_points(table: Table, names: Sequence[str]) -> None:
    """Refuse cells such as 1.234 in a table with decimal commas: 1234 as well as 1.234.

    Args:
        table: The table, whose decimal mark nothing declares.
        names: Columns with numbers.

    Raises:
        InputError: A column holds points that are no doubtless decimal marks.
    """
    for name in names:
        cells = table.columns[name]
        pointed = [(index, str(cell)) for index, cell in enumerate(cells) if "." in str(cell) and "," not in str(cell)]
        if pointed and all(POINT_GROUPS.fullmatch(cell.strip()) for _, cell in pointed):
            index, cell = pointed[0]
            raise InputError(
                f"{table.where(index)}: column {name!r} = {shorten(cell)}: is its point a decimal mark or a mark of "
                "thousands? the table has decimal commas; set decimal in the mapping file (',' for thousands)"
            )


def contradicted_units(heads: Heads, mapping: TableMapping) -> Iterator[str]:
    """Yield a sentence for each column for which the table names another unit than the mapping."""
    named = dict(zip(heads.names, heads.units, strict=True))
    for channel, entry in mapping.channels.items():
        kind = kind_of_column(channel, entry, mapping.source)
        for name in (entry.column, *entry.plus):
            unit = named.get(name, "") or split_head(name)[1]
            size, wanted = unit_factor(unit, kind), abs(mapping.scale[channel])
            is_known = unit and any(unit_factor(unit, other) is not None for other in KINDS)
            if is_known and (size is None or not math.isclose(size, wanted, rel_tol=1e-6)):
                yield f"{name!r}: the table says {shorten(unit)}, the mapping {entry.unit}: read as the mapping has it"
