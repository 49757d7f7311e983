"""Results as named columns with units, and their export: pandas, CSV, Parquet."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import write_atomically

if TYPE_CHECKING:
    import pandas

NEEDS = "install it with `pip install 'slider_drilling[frames]'`"


class TableExport:
    """Mix-in for results that can be written as a table: needs `columns`, adds the formats."""

    def columns(self) -> Columns:
        """The result as named columns with units."""
        raise NotImplementedError

    def to_frame(self) -> pandas.DataFrame:
        """`columns` as a pandas DataFrame: the first column is its index, the units are in ``attrs["units"]``.

        Raises:
            InputError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise InputError(f"pandas is not installed; {NEEDS}") from None
        columns = self.columns()
        frame = pandas.DataFrame(dict(columns.values)).set_index(next(iter(columns.values)))
        frame.attrs["units"] = dict(columns.units)
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write `columns` as a CSV file whose headings carry the units, such as ``hook_load [N]``; NaN is left empty.

        Returns:
            The path.

        Raises:
            InputError: The file cannot be written.
        """
        columns = self.columns()
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        units = columns.units
        rows.writerow([f"{name} [{units[name]}]" if name in units else name for name in columns.values])
        rows.writerows(zip(*([_cell(value) for value in column] for column in columns.values.values()), strict=True))
        write_atomically(Path(path), text.getvalue().encode("utf-8"))
        return Path(path)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """Write `columns` as a Parquet file, the units in the frame's attributes.

        Returns:
            The path.

        Raises:
            InputError: pandas or pyarrow is not installed, or the file cannot be written.
        """
        content = io.BytesIO()
        try:
            self.to_frame().to_parquet(content)
        except ImportError:
            raise InputError(f"pyarrow is not installed; {NEEDS}") from None
        write_atomically(Path(path), content.getvalue())
        return Path(path)


@dataclass(frozen=True)
class Columns(TableExport):
    """Named arrays of one length; the first is the index.

    Attributes:
        values: Arrays, each (n,), by name.
        units: Unit of each column that has one.
    """

    values: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)

    def columns(self) -> Columns:
        """Itself."""
        return self


@dataclass(frozen=True)
class SampledQuantity:
    """One quantity at times of its own.

    Attributes:
        name: Its column.
        unit: Of the values.
        time: s, (n,).
        value: (n,).
    """

    name: str
    unit: str
    time: np.ndarray
    value: np.ndarray


def join_samples(quantities: Iterable[SampledQuantity]) -> Columns:
    """All quantities over the union of their times, NaN where one has no sample.

    Quantities without any value are left out.
    """
    kept = [quantity for quantity in quantities if len(quantity.time) and not np.isnan(quantity.value).all()]
    ticks = [np.round(quantity.time * 1e9).astype(np.int64) for quantity in kept]
    union = np.unique(np.concatenate(ticks)) if ticks else np.empty(0, dtype=np.int64)
    values, units = {"time": union / 1e9}, {"time": "s"}
    for quantity, tick in zip(kept, ticks, strict=True):
        column = np.full(len(union), np.nan)
        column[np.searchsorted(union, tick)] = quantity.value
        values[quantity.name], units[quantity.name] = column, quantity.unit
    return Columns(values, units)


def _cell(value: Any) -> Any:
    """A value as a CSV cell."""
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value:.10g}"
    return value
