"""Checks that a table has the columns of its mapping."""

from __future__ import annotations

import re

from slider_drilling.errors import InputError
from slider_drilling.table_import.mapping import TableMapping
from slider_drilling.table_import.source import TableSource


def check_columns(mapping: TableMapping, source: TableSource) -> None:
    """Raise InputError for a column that is missing, or there twice with different values."""
    names = source.heads.names
    layout = mapping.layout.time
    entries: list[tuple[str, str]] = [("time", layout.column)]
    entries += [("time.date_column", layout.date_column)] if layout.date_column else []
    for key, channel in mapping.channels.items():
        entries += [(f"channels.{key}", name) for name in (channel.column, *channel.plus)]
    for where, name in entries:
        twins = [other for other in names if other == name or re.fullmatch(re.escape(name) + r" \(\d+\)", other)]
        if name not in names or (len(twins) > 1 and f"{name} (2)" not in [entry for _, entry in entries]):
            if name in names and _equal_columns(source, twins):
                continue
            count = len(twins) if name in names else "no"
            advice = f"; write {twins[1]!r} for the second" if len(twins) > 1 else ""
            raise InputError(
                f"{mapping.source}: {where}: column {name!r}: {count} such column in the table, "
                f"which has {' '.join(', '.join(names).split())[:300]}{advice}"
            )


def _equal_columns(source: TableSource, names: list[str]) -> bool:
    columns = source.read(names, None).columns
    return all(list(columns[name]) == list(columns[names[0]]) for name in names[1:])
