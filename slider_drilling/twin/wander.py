"""How features wander on rigs that do not change, learnt from slides of plants of foreign structure.

The numbers are in noise levels of the channel: those of maximum likelihood, rounded, over slides with operations of 36
foreign rigs, as long as nothing had begun (`slider_drilling.benchmarks.twin_wander` fits them to any slides). Each
threshold lies above the evidence of all but the rarest of them: in 16.5 h without a change, tested every 20 s, one
false alarm is left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.twin.change_statistic import Wander
from slider_drilling.twin.samples import Array

# Standard deviations of the plant's numbers within an hour: friction of the whole hole; torque per pressure of the
# motor, which stands for that per weight of the bit too.
_PARAMETERS = {"friction_": 0.05, "motor_gain": 0.035}

# (channel, kind) -> short, brief s, slow, memory s, drift, jump, fresh, fade s, burst s, threshold, smallest change.
WANDERS = {
    ("surface_torque", "mean"): Wander(0.071, 4, 0.93, 1800, 0.25, 1.3, 2.9, 79, np.inf, 16.0, 1.2),
    ("surface_torque", "gain"): Wander(0.11, 4, 0.038, 680, 0.017, 0.03, 0.34, 49, np.inf, 14.5, 0.3),
    ("surface_torque", "lag"): Wander(0.11, 4, 0.17, 2000, 0.023, 0.075, 0.47, 29, np.inf, 11.5, 0.2),
    ("surface_torque", "spread"): Wander(0.083, 4, 0.038, 270, 0.0071, 0.035, 3.7, 8, np.inf, 14.5, 0.15),
    ("hook_load", "mean"): Wander(0.11, 4, 0.65, 2000, 0.80, 1.0, 1.7, 120, np.inf, 28.0, 1),
    ("hook_load", "gain"): Wander(0.12, 4, 0.0054, 68, 0.005, 0.005, 0.11, 32, np.inf, 11.0, 0.3),
    ("hook_load", "lag"): Wander(0.12, 4, 0.0058, 170, 0.005, 0.005, 0.13, 30, np.inf, 10.5, 0.3),
    ("hook_load", "spread"): Wander(0.091, 4, 0.0054, 250, 0.005, 0.005, 0.042, 13, np.inf, 10.5, 0.15),
    ("standpipe_pressure", "mean"): Wander(0.13, 6.3, 1.2, 280, 0.31, 1.6, 3.8, 38, 25, 22.0, 2),
    ("standpipe_pressure", "spread"): Wander(0.11, 4, 0.046, 370, 0.019, 0.063, 0.16, 120, 25, 19.0, 0.15),
}


def parameter_wanders(names: Sequence[str]) -> Array:
    """(p, k): ways in which tracked parameters of these names wander; parameters of one kind do so together."""
    columns = [[size if name.startswith(kind) else 0.0 for name in names] for kind, size in _PARAMETERS.items()]
    return np.array(columns).T
