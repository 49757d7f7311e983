"""Values far beyond any reading of a rig are taken out of a log, so that arithmetic stays finite."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import Series
from slider_drilling.messages.topics import TOPICS, TopicQuantity


def mask_impossible_values(log: RigLog) -> RigLog:
    """The log with values beyond their registered limits as NaN; a note tells how many and the first of each array."""
    changes: dict[str, Series] = {}
    notes = []
    for key, series in log.series().items():
        masked = series
        for name, limit in _limits(TOPICS[key].quantities).items():
            values = getattr(series, name)
            beyond = np.abs(values) > limit  # false for NaN
            if beyond.any():
                first = int(beyond.argmax())
                notes.append(
                    f"{key}.{name}: {np.count_nonzero(beyond)} of {values.size} values no rig has left out, the first "
                    f"{values[first]:g} at {series.time[first]:.1f} s"
                )
                masked = dataclasses.replace(masked, **{name: np.where(beyond, np.nan, values)})  # type: ignore[arg-type]
                changes[key] = masked
    return dataclasses.replace(log, notes=(*log.notes, *notes), **changes) if changes else log  # type: ignore[arg-type]


def _limits(quantities: tuple[TopicQuantity, ...]) -> dict[str, float]:
    """The largest magnitude of each array that has one; a variance has the square of its value's."""
    limits = {part.array: part.max_magnitude for part in quantities if math.isfinite(part.max_magnitude)}
    return {**limits, "variance": limits["value"] ** 2} if "value" in limits else limits
