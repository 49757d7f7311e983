"""Results as named columns with units, and the ways out of the program: pandas, CSV, Parquet."""

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


@dataclass(frozen=True)
class Columns:
    """Arrays of one length by name, and the unit of each that has one; the first column is the index."""

    values: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)

    def to_frame(self) -> pandas.DataFrame:
        """A pandas DataFrame, its units in ``attrs["units"]``. Raises InputError where pandas is not installed."""
        try:
            import pandas
        except ImportError:
            raise InputError(f"pandas is not installed; {NEEDS}") from None
        index = next(iter(self.values))
        frame = pandas.DataFrame(dict(self.values)).set_index(index)
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write a CSV file whose heads carry the units, such as ``hook_load [N]``; NaN is left empty. The path.

        Raises InputError where it cannot be written.
        """
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow([f"{name} [{self.units[name]}]" if name in self.units else name for name in self.values])
        rows.writerows(zip(*([_cell(value) for value in column] for column in self.values.values()), strict=True))
        write_atomically(Path(path), text.getvalue().encode("utf-8"))
        return Path(path)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """Write a Parquet file, the units in the frame's attributes. The path.

        Raises InputError where pandas or pyarrow is not installed, or the file cannot be written.
        """
        held = io.BytesIO()
        try:
            self.to_frame().to_parquet(held)
        except ImportError:
            raise InputError(f"pyarrow is not installed; {NEEDS}") from None
        write_atomically(Path(path), held.getvalue())
        return Path(path)


@dataclass(frozen=True)
class SampledQuantity:
    """One quantity at times of its own: time (n,) s and value (n,) in unit."""

    name: str
    unit: str
    time: np.ndarray
    value: np.ndarray


def join_samples(quantities: Iterable[SampledQuantity]) -> Columns:
    """All quantities over the union of their times, NaN where one has no sample; columns that are all NaN go."""
    kept = [one for one in quantities if len(one.time) and not np.isnan(one.value).all()]
    ticks = [np.round(one.time * 1e9).astype(np.int64) for one in kept]
    union = np.unique(np.concatenate(ticks)) if ticks else np.empty(0, dtype=np.int64)
    values, units = {"time": union / 1e9}, {"time": "s"}
    for one, tick in zip(kept, ticks, strict=True):
        column = np.full(len(union), np.nan)
        column[np.searchsorted(union, tick)] = one.value
        values[one.name], units[one.name] = column, one.unit
    return Columns(values, units)


def _cell(value: Any) -> Any:
    if isinstance(value, (float, np.floating)):
        return "" if np.isnan(value) else f"{value:.10g}"
    return value
