"""How far the rig file's circulating pressure is off: the lowest pressures of a log have the bit off bottom."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slider_drilling.drillstring.kernel_arrays import Array

_OFF_BOTTOM = 0.02  # fraction of a log in which its bit carries no weight


def pump_runs(circulation: Array) -> NDArray[np.bool_]:
    """Where (n,) the pump runs, by the pressure that circulation needs, Pa: half the log's highest or more."""
    return np.asarray(circulation > 0.5 * float(circulation.max(initial=0.0)))


def off_bottom_factor(pressure: Array, circulation: Array) -> float:
    """Pressure with the bit off bottom over that which circulation needs by the rig file.

    Args:
        pressure: (n,) Pa, measured while the pump runs; not empty.
        circulation: (n,) Pa, by the rig file at the flow of that time.
    """
    return float(np.quantile(pressure / circulation, _OFF_BOTTOM))
