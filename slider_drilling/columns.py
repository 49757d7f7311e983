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
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import pandas

NEEDS = "install it with `pip install 'slider_drilling[frames]'`"


class TableExport:
    """Mix-in for results that can be written as a table: needs `columns`, adds the formats."""

    def columns(self) -> Columns:
        """The result as named columns with units."""
        raise NotImplementedError

    def to_frame(self, units: Units = SI, *, degrees: bool = False) -> pandas.DataFrame:
        """`columns` as a pandas DataFrame: the first column is its index, the units are in ``attrs["units"]``.

        Args:
            units: `slider_drilling.units.SI` or `FIELD`; toolfaces of the latter are in degrees.
            degrees: Every angle in degrees.

        Raises:
            InputError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise InputError(f"pandas is not installed; {NEEDS}") from None
        columns = self.columns().converted(units, degrees)
        frame = pandas.DataFrame(dict(columns.values)).set_index(next(iter(columns.values)))
        frame.attrs["units"] = dict(columns.units)
        return frame

    def to_csv(self, path: str | os.PathLike[str], units: Units = SI, *, degrees: bool = False) -> Path:
        """Write `columns` as a CSV file whose headings carry the units, such as ``hook_load [N]``; NaN is left empty.

        Args:
            path: The file.
            units: As for `to_frame`.
            degrees: Every angle in degrees.

        Returns:
            The path.

        Raises:
            InputError: The file cannot be written.
        """
        columns = self.columns().converted(units, degrees)
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        written = columns.units
        rows.writerow([f"{name} [{written[name]}]" if name in written else name for name in columns.values])
        rows.writerows(zip(*([_cell(value) for value in column] for column in columns.values.values()), strict=True))
        write_atomically(Path(path), text.getvalue().encode("utf-8"))
        return Path(path)

    def to_parquet(self, path: str | os.PathLike[str], units: Units = SI, *, degrees: bool = False) -> Path:
        """Write `columns` as a Parquet file, the units in the frame's attributes; arguments as for `to_csv`.

        Returns:
            The path.

        Raises:
            InputError: pandas or pyarrow is not installed, or the file cannot be written.
        """
        content = io.BytesIO()
        try:
            self.to_frame(units, degrees=degrees).to_parquet(content)
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

    def converted(self, units: Units, degrees: bool = False) -> Columns:
        """The columns in display units: those of `units`, but degrees for toolfaces in field units."""
        values, shown = dict(self.values), dict(self.units)
        for name, unit in self.units.items():
            in_degrees = unit == "rad" and (degrees or (units != SI and "tool_face" in name))
            shown[name] = "deg" if in_degrees else units.display_unit(unit)
            values[name] = np.degrees(values[name]) if in_degrees else units.convert(values[name], unit)
        return Columns(values, shown)


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
