"""Checks that a table has the columns of its mapping."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.schema.rounding import equal_as_rounded
from slider_drilling.table_import.findings import Findings
from slider_drilling.table_import.mapping import TableMapping
from slider_drilling.table_import.numbers import numbers
from slider_drilling.table_import.source import Array, Table, TableSource
from slider_drilling.units import KINDS, unit_factor


def check_columns(mapping: TableMapping, source: TableSource, found: Findings, delimiter: str) -> TableMapping:
    """The mapping with the names of the table's columns: of equal heads, "HKLD (1)" is the first.

    Args:
        mapping: Of the table.
        source: The table.
        found: Gets a sentence where equal heads hold one quantity in two units.
        delimiter: Between the cells of a text; empty for other tables.

    Raises:
        InputError: A column is missing, or there twice with different values.
    """
    names = source.heads.names
    layout = mapping.layout.time
    entries: list[tuple[str, str]] = [("time", layout.column)]
    entries += [("time.date_column", layout.date_column)] if layout.date_column else []
    for key, channel in mapping.channels.items():
        entries += [(f"channels.{key}", name) for name in (channel.column, *channel.plus)]
    for where, name in entries:
        twins = [other for other in names if other == name or re.fullmatch(re.escape(name) + r" \(\d+\)", other)]
        if _first_of(name, names) != name:
            continue
        if name not in names or (len(twins) > 1 and f"{name} (2)" not in [entry for _, entry in entries]):
            if name in names and _equal_columns(source, twins):
                continue
            if name in names and _equal_quantities(source, twins, mapping, delimiter):
                units = dict(zip(names, source.heads.units, strict=True))
                others = " and ".join(units[other] for other in twins[1:])
                found.add("columns", f"{name!r} is there in {units[name]} and in {others} with equal values: "
                          f"that in {units[name]} is used")  # fmt: skip
                continue
            count = len(twins) if name in names else "no"
            columns = "column" if len(twins) < 2 else "columns"
            advice = (
                f"; in a mapping file, write '{name} (1)' for the first, {twins[1]!r} for the second" if len(twins) > 1
                else ""
            )
            raise InputError(
                f"{mapping.source}: {where}: column {name!r}: {count} such {columns} in the table, "
                f"which has {' '.join(', '.join(names).split())[:300]}{advice}"
            )
    channels = {
        key: replace(
            channel,
            column=_first_of(channel.column, names),
            plus=tuple(_first_of(name, names) for name in channel.plus),
        )
        for key, channel in mapping.channels.items()
    }
    time = replace(
        layout, column=_first_of(layout.column, names), date_column=_first_of(layout.date_column, names)
    )
    return replace(mapping, layout=replace(mapping.layout, time=time), channels=channels)


def _first_of(name: str, names: Sequence[str]) -> str:
    """The head that "HKLD (1)" means where there is "HKLD (2)" as well; any other name as it is."""
    bare = name.removesuffix(" (1)")
    return bare if name not in names and bare in names and f"{bare} (2)" in names else name


def _equal_columns(source: TableSource, names: list[str]) -> bool:
    """Whether columns hold the same cells, and the table gives them no two units."""
    units = dict(zip(source.heads.names, source.heads.units, strict=True))
    if len({units[name] for name in names} - {""}) > 1:
        return False
    columns = source.read(names, None).columns
    return all(list(columns[name]) == list(columns[names[0]]) for name in names[1:])


def _equal_quantities(source: TableSource, names: list[str], mapping: TableMapping, delimiter: str) -> bool:
    """Whether columns hold the same quantities, each in the unit that the table gives it."""
    units = dict(zip(source.heads.names, source.heads.units, strict=True))
    kind = next((kind for kind in KINDS if unit_factor(units[names[0]], kind) is not None), None)
    factors = [unit_factor(units[name], kind) if kind is not None else None for name in names]
    table = source.read(names, None)
    nulls = (*mapping.layout.null_values, *source.heads.nulls)
    columns = [_texts_and_numbers(table, name, nulls, mapping.layout.decimal, delimiter) for name in names]
    first = factors[0]
    return first is not None and all(
        factor is not None and equal_as_rounded(*columns[0], first, *column, factor)
        for column, factor in zip(columns[1:], factors[1:], strict=True)
    )


def _texts_and_numbers(
    table: Table, name: str, nulls: tuple[float, ...], decimal: str, delimiter: str
) -> tuple[list[str], Array]:
    """The cells of a column as they are written, and as numbers, (n,). Raises InputError."""
    cells = table.columns[name]
    texts = [f"{cell:.12g}" for cell in cells] if isinstance(cells, np.ndarray) else [str(cell) for cell in cells]
    return texts, numbers(table, name, nulls, decimal, delimiter=delimiter).values
