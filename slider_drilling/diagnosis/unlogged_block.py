"""A block whose motion nobody logged: how much faster it was lowered than standpipe pressure tells is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.log_inputs.reconstruct_block import rate_knots

_RATE = "block_rate_"
# m/s: what pressure tells of a rate is off by about as much, most of it while friction begins to hold the string back;
# at the most by what a driller lowers a block by.
_SPREAD, _MOST = 0.001, 0.02


def block_rates(runs: Sequence[Commands]) -> tuple[Parameter, ...]:
    """What is added to the block's rate in each stretch of a run, m/s; of the longest run where there are several."""
    count = max(rate_knots(run.time).size for run in runs) - 1
    return tuple(
        Parameter(f"{_RATE}{k + 1}", 0.0, -_MOST, _MOST, 0.1 * _SPREAD, "m/s", spread=_SPREAD, per_run=True)
        for k in range(count)
    )


def lowered_blocks(time: Array, sets: Sequence[Values], nuisance: Sequence[Parameter]) -> Array:
    """(K, n) m that the block of each set is lower at the times of its commands than these say; nuisance: with
    `block_rates`.
    """
    names = [parameter.name for parameter in nuisance if parameter.name.startswith(_RATE)]
    knots = np.linspace(time[0], time[-1], len(names) + 1)
    rates = np.array([[values.get(name, 0.0) for name in names] for values in sets])
    lowered = np.cumsum(rates * np.diff(knots), axis=1)
    return np.stack([np.interp(time, knots, [0.0, *row]) for row in lowered])
