"""Values that no rig has are taken out of a log, so that no null, flipped bit or second sensor passes as a reading."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from slider_drilling.log.contents import shown_unit
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Array, ScalarSeries, Series
from slider_drilling.log.timestamps import Mask
from slider_drilling.messages.topics import TOPICS, TopicQuantity
from slider_drilling.null_values import null_in_some_unit
from slider_drilling.units import KINDS, format_number

# A channel with more of its values beyond the range is in another unit, unless these values are all the same.
_MAX_SHARE = 0.5


def mask_impossible_values(log: RigLog) -> RigLog:
    """The log with values outside their physical ranges as NaN; a note says how many of each array and the first.

    A channel that lies outside for the most part, with changing values, is kept: it is in another unit, which the log
    checks find. The note says this, too.
    """
    changes: dict[str, Series] = {}
    notes = []
    for key, series in log.series().items():
        masked = series
        for quantity in TOPICS[key].quantities:
            values = getattr(series, quantity.array)
            wrong, is_other_unit = outside_range(values, quantity)
            if not wrong.any():
                continue
            notes.append(_note(quantity, values, wrong, series.time, is_other_unit))
            if is_other_unit:
                wrong &= np.abs(values) > quantity.max_magnitude
            masked = dataclasses.replace(masked, **{quantity.array: np.where(wrong, np.nan, values)})  # type: ignore[arg-type]
            changes[key] = masked
        changes.update(_mask_variance(key, masked))
    return dataclasses.replace(log, notes=(*log.notes, *notes), **changes) if changes else log  # type: ignore[arg-type]


def outside_range(values: Array, quantity: TopicQuantity) -> tuple[Mask, bool]:
    """Which values no rig has, (n,), and whether the channel seems to be in another unit."""
    low, high = quantity.physical_range
    outside = (values < low) | (values > high) | (np.abs(values) > quantity.max_magnitude)  # false for NaN
    share = float(np.mean(outside[~np.isnan(values)])) if outside.any() else 0.0
    changes = len(np.unique(values[outside])) > max(2.0, 0.1 * np.count_nonzero(outside))
    return outside, bool(share > _MAX_SHARE and (changes or _is_constant_in_other_unit(values[outside], quantity)))


def _is_constant_in_other_unit(values: Array, quantity: TopicQuantity) -> bool:
    """Whether values that hardly change are a rig's in some unit, and in none a null: a pump that runs steadily."""
    if not values.size or null_in_some_unit(float(values[0]), quantity.unit):
        return False
    units = next((units for units in KINDS.values() if next(iter(units)) == quantity.unit), {})
    low, high = quantity.physical_range
    return any(low <= factor * values.min() and factor * values.max() <= high for factor in units.values())


def _note(quantity: TopicQuantity, values: Array, wrong: Mask, time: Array, is_other_unit: bool) -> str:
    first = int(wrong.argmax())
    unit, size = shown_unit(quantity)
    low, high = (limit / size for limit in quantity.physical_range)
    limits = f"outside {low:g} to {high:g} {unit}"
    if not math.isfinite(low):
        limits = f"beyond {quantity.max_magnitude / size:g} {unit}"
    done = "it seems to be in another unit" if is_other_unit else "left out"
    return (
        f"{quantity.column}: {np.count_nonzero(wrong)} of {values.size} values {limits}, which no rig has: {done}; "
        f"the first is {format_number(float(values[first]) / size, 5)} {unit} at {time[first]:.1f} s"
    )


def _mask_variance(key: str, series: Series) -> dict[str, Series]:
    """The series without variances that no sensor has; empty where there are none."""
    limit = max((part.max_magnitude for part in TOPICS[key].quantities if part.array == "value"), default=math.inf)
    if not isinstance(series, ScalarSeries) or not (series.variance > limit**2).any():
        return {}
    return {key: dataclasses.replace(series, variance=np.where(series.variance > limit**2, np.nan, series.variance))}
