"""Checks that a table has the columns of its mapping."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.errors import InputError
from slider_drilling.table_import.mapping import TableMapping
from slider_drilling.table_import.source import TableSource


def check_columns(mapping: TableMapping, source: TableSource) -> TableMapping:
    """The mapping with the names of the table's columns: of equal heads, "HKLD (1)" is the first.

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
    columns = source.read(names, None).columns
    return all(list(columns[name]) == list(columns[names[0]]) for name in names[1:])
