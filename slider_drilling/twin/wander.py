"""How features wander on rigs that do not change, learnt from slides of plants of foreign structure.

The numbers are in noise levels of the channel: those of maximum likelihood, rounded, over slides with operations of 28
foreign rigs, as long as nothing had begun (`slider_drilling.benchmarks.twin_wander` fits them to any slides). Only what
a swing of the drive has of its own is set by hand, to what the largest changes of a swing have shown. The thresholds
extrapolate the largest evidence of these slides, 13 h, to one false alarm in 24 h, all features together.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.twin.change_statistic import Wander
from slider_drilling.twin.samples import Array

# Standard deviations of the plant's numbers within an hour: friction of the whole hole; torque per pressure of the
# motor, which stands for that per weight of the bit too.
_PARAMETERS = {"friction_": 0.05, "motor_gain": 0.035}

# (channel, kind) -> short, brief s, slow, memory s, drift, jump, fresh, fade s, burst s, weighed, loaded, settling s,
# steered, swung, threshold, smallest change.
WANDERS = {
    ("surface_torque", "mean"): Wander(
        0.069, 4, 0.18, 2000, 0.7, 0.92, 1.6, 83, np.inf, 1.3, 1, 300, 0.18, 1, 22.0, 1.2,
    ),
    ("surface_torque", "gain"): Wander(
        0.13, 4, 0.025, 2000, 0.015, 0.02, 0.16, 31, np.inf, 0.029, 0.057, 64, 0.0098, 1.3, 10.0, 0.3,
    ),
    ("surface_torque", "lag"): Wander(
        0.11, 4, 0.046, 380, 0.034, 0.024, 0.53, 20, np.inf, 0.24, 0.076, 80, 0.0084, 2, 11.5, 0.2,
    ),
    ("surface_torque", "spread"): Wander(
        0.093, 4, 0.045, 330, 0.005, 0.01, 2.7, 8, np.inf, 0.056, 0.088, 22, 0.002, 0.8, 18.0, 0.15,
    ),
    ("hook_load", "mean"): Wander(
        0.068, 4, 1.1, 2000, 0.81, 0.3, 0.81, 110, np.inf, 0.44, 0.45, 150, 0.028, 0.3, 20.0, 1,
    ),
    ("hook_load", "gain"): Wander(
        0.13, 4, 0.0051, 58, 0.005, 0.005, 0.15, 35, np.inf, 0.016, 0.049, 57, 0.002, 0.4, 9.0, 0.3,
    ),
    ("hook_load", "lag"): Wander(
        0.13, 6.1, 0.0052, 140, 0.005, 0.005, 0.48, 30, np.inf, 0.015, 0.065, 55, 0.002, 0.4, 13.5, 0.3,
    ),
    ("hook_load", "spread"): Wander(
        0.096, 4, 0.005, 260, 0.005, 0.005, 0.041, 12, np.inf, 0.017, 0.033, 37, 0.002, 0.2, 9.0, 0.15,
    ),
    ("standpipe_pressure", "mean"): Wander(
        0.38, 4, 0.88, 270, 0.32, 1.1, 11, 22, 25, 4.7, 4.5, 150, 0.12, 1.6, 18.5, 2,
    ),
    ("standpipe_pressure", "spread"): Wander(
        0.11, 4.3, 0.019, 340, 0.0062, 0.016, 0.19, 70, 25, 0.033, 0.3, 21, 0.0023, 0.8, 18.0, 0.15,
    ),
}  # fmt: skip


def parameter_wanders(names: Sequence[str]) -> Array:
    """(p, k): ways in which tracked parameters of these names wander; parameters of one kind do so together."""
    columns = [[size if name.startswith(kind) else 0.0 for name in names] for kind, size in _PARAMETERS.items()]
    return np.array(columns).T
