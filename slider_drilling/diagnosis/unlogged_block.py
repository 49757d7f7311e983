"""A block that was not logged: a correction of its rate, which standpipe pressure gives, is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.log_inputs.reconstruct_block import rate_knots

_RATE = "block_rate_"
# m/s. Error of a rate from standpipe pressure, mostly while friction begins to hold the string; and the largest rate at
# which a driller lowers a block.
_SPREAD, _MAX_RATE = 0.001, 0.02


def block_rate_parameters(runs: Sequence[Commands]) -> tuple[Parameter, ...]:
    """Corrections, m/s, of the block's rate in each stretch of a run; as many as the longest run has."""
    count = max(rate_knots(run.time).size for run in runs) - 1
    return tuple(
        Parameter(f"{_RATE}{k + 1}", 0.0, -_MAX_RATE, _MAX_RATE, 0.1 * _SPREAD, "m/s", spread=_SPREAD, per_run=True)
        for k in range(count)
    )


def block_offsets(time: Array, sets: Sequence[Values], nuisance: Sequence[Parameter]) -> Array:
    """How much lower the block is than the commands say.

    Args:
        time: (n,) s of the commands.
        sets: K parameter sets.
        nuisance: All nuisance parameters, among them `block_rate_parameters`.

    Returns:
        (K, n) m.
    """
    names = [parameter.name for parameter in nuisance if parameter.name.startswith(_RATE)]
    knots = np.linspace(time[0], time[-1], len(names) + 1)
    rates = np.array([[values.get(name, 0.0) for name in names] for values in sets])
    offsets = np.cumsum(rates * np.diff(knots), axis=1)
    return np.stack([np.interp(time, knots, [0.0, *row]) for row in offsets])
