"""`import_log`: a recorder's table as a log."""

from __future__ import annotations

import os
from collections.abc import Mapping

from slider_drilling.log import RigLog
from slider_drilling.table_import import import_table


def import_log(
    table: str | os.PathLike[str],
    *,
    mapping: str | os.PathLike[str] | None = None,
    rig: str | os.PathLike[str] | None = None,
    rows: tuple[int, int] | None = None,
    units: Mapping[str, str] | None = None,
    time_zone: str = "",
    wits_units: str = "",
) -> RigLog:
    """Read a table of a rig's recorder: CSV or other text, LAS, XLSX, Parquet, WITSML or WITS.

    Args:
        table: The file.
        mapping: Mapping file; columns are recognised by their heads if None.
        rig: Rig file to attach.
        rows: First and last data row to keep, counted from 0.
        units: Units of columns that the table does not give, by the columns' names, such as ``{"HKLD": "klbf"}``.
        time_zone: Zone of the table's clock, such as ``"Europe/Oslo"``.
        wits_units: Units of WITS, ``"field"`` or ``"metric"``.

    Returns:
        The log in SI units; its notes say what was assumed and repaired.

    Raises:
        InputError: A column is not recognised or cannot be read; the message names file, line and column.
    """
    return import_table(table, mapping, rig, rows, units=units, time_zone=time_zone, wits_units=wits_units).log
