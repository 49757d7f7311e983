"""A pump that nobody logged: by how much its flow changed where standpipe pressure steps is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.gap.model import Array, Parameter, Values

_STEP = "circulation_step_"


def step_parameters(runs: Sequence[tuple[float, ...]]) -> tuple[Parameter, ...]:
    """Pa by which circulation needs more from each step of a run on."""
    return tuple(
        Parameter(f"{_STEP}{k + 1}", 0.0, -3e7, 3e7, 1e5, "Pa", spread=2e6, per_run=True)
        for k in range(max(map(len, runs), default=0))
    )


def with_steps(pressure: Array, time: Array, steps: Sequence[float], values: Values, lag: float) -> Array:
    """Standpipe pressure (n,) Pa at its times s, with what the steps add to it behind its lag s."""
    sizes = [values.get(f"{_STEP}{k + 1}", 0.0) for k in range(len(steps))]
    for step, size in zip(steps, sizes, strict=True):
        if size != 0.0:
            passed = np.maximum(time - step, 0.0)
            pressure = pressure + size * (-np.expm1(-passed / lag) if lag > 0.0 else passed > 0.0)
    return pressure
