"""A pump that was not logged: the change of circulating pressure at each step of standpipe pressure is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.gap.model import Array, Parameter, Values

_STEP = "circulation_step_"


def flow_step_parameters(runs: Sequence[tuple[float, ...]]) -> tuple[Parameter, ...]:
    """Changes, Pa, of circulating pressure at each step; runs: step times, s, of each run."""
    return tuple(
        Parameter(f"{_STEP}{k + 1}", 0.0, -3e7, 3e7, 1e5, "Pa", spread=2e6, per_run=True)
        for k in range(max(map(len, runs), default=0))
    )


def add_flow_steps(pressure: Array, time: Array, steps: Sequence[float], values: Values, lag: float) -> Array:
    """Add the fitted steps to a simulated standpipe pressure.

    Args:
        pressure: (n,) Pa.
        time: (n,) s.
        steps: s of each step.
        values: Fitted parameters.
        lag: s, first-order lag of the mud column.

    Returns:
        (n,) Pa.
    """
    sizes = [values.get(f"{_STEP}{k + 1}", 0.0) for k in range(len(steps))]
    for step, size in zip(steps, sizes, strict=True):
        if size != 0.0:
            elapsed = np.maximum(time - step, 0.0)
            pressure = pressure + size * (-np.expm1(-elapsed / lag) if lag > 0.0 else elapsed > 0.0)
    return pressure
