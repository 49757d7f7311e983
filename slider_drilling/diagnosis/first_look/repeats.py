"""Values that were logged again and again before they were renewed: only what is new was measured."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.diagnosis.first_look.finding import Finding
from slider_drilling.log.series import Array, JointSeries, RigLog, ScalarSeries

# Renewals that say whether a column is held between them, and how many of these may follow upon one another at once.
_FEWEST, _AT_ONCE = 20, 0.02
_SOONEST = 0.05  # of the renewals: a drive that turns evenly has the same speed for many of them
_COLUMNS = (
    ("top_drive", "position", "top-drive angle"), ("top_drive", "velocity", "top-drive speed"),
    ("top_drive", "effort", "surface_torque"), ("draw_works", "position", "block position"),
    ("draw_works", "velocity", "block speed"), ("draw_works", "effort", "hook_load"),
    ("standpipe_pressure", "value", "standpipe_pressure"),
)  # fmt: skip


def without_repeats(log: RigLog) -> tuple[RigLog, list[Finding]]:
    """The log with NaN for every sample that repeats the one before in a column which is renewed more seldom than it
    is logged, as a bus or a historian holds it, and a note that names them.
    """
    held: dict[tuple[str, str], list[str]] = {}
    for name, column, words in _COLUMNS:
        series: JointSeries | ScalarSeries | None = getattr(log, name)
        if series is None:
            continue
        values = getattr(series, column)
        repeated, every = _repeats(values)
        if every == 1:
            continue
        interval = float(np.median(np.diff(series.time)))
        held.setdefault((f"{every * interval:.3g}", f"{interval:.3g}"), []).append(words)
        kept: dict[str, Any] = {column: np.where(repeated, np.nan, values)}
        changed: dict[str, Any] = {name: replace(series, **kept)}
        log = replace(log, **changed)
    return log, [
        Finding(
            "note", "clock",
            f"{', '.join(words)}: logged every {logged} s and renewed every {renewed} s: samples that only repeat the "
            "one before are left out",
        )
        for (renewed, logged), words in held.items()
    ]  # fmt: skip


def _repeats(values: Array) -> tuple[NDArray[np.bool_], int]:
    """Which samples (n,) repeat a value that is held, and for how many samples it is; none and 1 where values
    are renewed with every sample. Where nothing moves a sample is kept as often as values are renewed elsewhere.
    """
    nothing = np.zeros(values.shape, dtype=bool), 1
    known = np.flatnonzero(np.isfinite(values))
    renewed = np.flatnonzero(np.diff(values[known]) != 0.0) + 1
    gaps = np.diff(renewed)
    if gaps.size < _FEWEST or np.mean(gaps == 1) > _AT_ONCE:
        return nothing
    every = int(np.quantile(gaps, _SOONEST))
    first = np.concatenate([[0], renewed, [known.size]])
    count = np.arange(known.size)
    own = np.searchsorted(first, count, side="right") - 1
    since, left = count - first[own], first[own + 1] - count
    repeated, _ = nothing
    repeated[known[(since > 0) & ((since % every != 0) | (left < every))]] = True
    return repeated, every
