"""How features wander on rigs that do not change, learnt from slides of plants of foreign structure.

The numbers are in noise levels of the channel: those of maximum likelihood, rounded, over slides with operations of 36
foreign rigs, as long as nothing had begun (`slider_drilling.benchmarks.twin_wander` fits them to any slides). Only what
a swing of the drive has of its own is set by hand, to what the largest changes of a swing have shown. The thresholds
extrapolate the largest evidence of these and 36 more slides, 34 h, to one false alarm in 24 h, all features and all
kinds of beginning together; none is below that evidence, nor below that of 12 slides scored afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.twin.activity import OFF_BOTTOM
from slider_drilling.twin.change_statistic import Thresholds, Wander
from slider_drilling.twin.samples import Array

# Standard deviations of the plant's numbers within an hour: friction of the whole hole; torque per pressure of the
# motor, which stands for that per weight of the bit too.
_PARAMETERS = {"friction_": 0.05, "motor_gain": 0.035}

# (channel, kind) -> short, brief s, slow, memory s, drift, jump, fresh, fade s, burst s, weighed, loaded, settling s,
# steered, swung, thresholds (sudden, gradual, long ago, after an operation), smallest change.
WANDERS = {
    ("surface_torque", "mean"): Wander(
        0.11, 4, 1.1, 2000, 1.6, 2.9, 4.9, 130, np.inf, 0.97, 1.1, 300, 0.22, 1,
        Thresholds(7.0, 78.0, 45.0, 50.0), 1.2,
    ),
    ("surface_torque", "gain"): Wander(
        0.13, 4, 0.012, 1100, 0.012, 0.02, 0.027, 19, np.inf, 0.59, 0.19, 22, 0.027, 1.3,
        Thresholds(12.5, 11.0, 14.5, 22.5), 0.3,
    ),
    ("surface_torque", "lag"): Wander(
        0.13, 4.1, 0.032, 1200, 0.02, 0.019, 0.28, 16, np.inf, 0.26, 0.11, 59, 0.011, 2,
        Thresholds(7.0, 12.5, 11.5, 17.0), 0.2,
    ),
    ("surface_torque", "spread"): Wander(
        0.099, 4.5, 0.024, 100, 0.005, 0.0066, 5.6, 8.9, np.inf, 0.1, 0.018, 46, 0.0082, 0.8,
        Thresholds(12.0, 7.0, 9.0, 34.5), 0.15,
    ),
    ("hook_load", "mean"): Wander(
        0.13, 4, 0.87, 2000, 0.99, 1.4, 2.1, 160, np.inf, 0.98, 0.27, 220, 0.02, 0.3,
        Thresholds(7.0, 52.0, 10.0, 75.0), 1,
    ),
    ("hook_load", "gain"): Wander(
        0.16, 4, 0.005, 83, 0.005, 0.005, 0.067, 15, np.inf, 0.0079, 0.011, 78, 0.002, 0.4,
        Thresholds(7.0, 7.0, 7.0, 10.0), 0.3,
    ),
    ("hook_load", "lag"): Wander(
        0.13, 4, 0.005, 170, 0.005, 0.005, 0.18, 13, np.inf, 0.012, 0.023, 47, 0.002, 0.4,
        Thresholds(7.0, 7.0, 7.0, 21.0), 0.3,
    ),
    ("hook_load", "spread"): Wander(
        0.095, 4, 0.005, 260, 0.005, 0.005, 0.041, 12, np.inf, 0.017, 0.033, 37, 0.002, 0.2,
        Thresholds(7.0, 7.0, 14.0, 12.0), 0.15,
    ),
    ("standpipe_pressure", "mean"): Wander(
        0.067, 18, 2.3, 370, 0.66, 2.1, 10, 23, 25, 7.7, 2.3, 300, 0.55, 1.6,
        Thresholds(30.0, 19.0, 43.0, 39.5), 2,
    ),
    ("standpipe_pressure", "spread"): Wander(
        0.12, 4, 0.016, 510, 0.0076, 0.038, 0.12, 140, 25, 0.13, 0.23, 5, 0.0036, 0.8,
        Thresholds(19.5, 14.0, 23.5, 36.5), 0.15,
    ),
}  # fmt: skip

# The same off bottom with the pump on, where pressure is circulation's alone. By hand, from 24 slides of foreign rigs
# without a change (`watch --campaign 12 --begins none`, seeds 5501 and 7771): between two such stretches the pressure
# moves by up to 4.9 noise levels, as mud warms up and flow changes. A slide has two or three: too few to fit numbers.
# Only stretches are compared with each other: within one the rig's bit may touch bottom before the twin's. That raises
# the pressure. Nothing lets it fall on a rig that does not change: within none of the stretches of 72 slides, 34 h, did
# it fall by one noise level, and from one to the next at most with an evidence of 7.1.
CIRCULATING = {
    ("hook_load", "spread"): Wander(
        0.1, 8, 0.05, 340, 0.05, 0.1, 0, 30, np.inf, 0, 0, 60, 0, 0,
        Thresholds(np.inf, np.inf, np.inf, 15.0), 0.3, 2, 15.0,
    ),
    ("standpipe_pressure", "mean"): Wander(
        0.2, 15, 1.5, 1000, 0.5, 1.4, 0, 30, np.inf, 0, 0, 60, 0, 0,
        Thresholds(np.inf, np.inf, np.inf, 10.0), 3, 2, 15.0, fall=Thresholds(10.0, 10.0, 10.0, 10.0),
    ),
    ("standpipe_pressure", "spread"): Wander(
        0.08, 8, 0.01, 340, 0.01, 0.06, 0, 30, np.inf, 0, 0, 60, 0, 0,
        Thresholds(np.inf, np.inf, np.inf, 15.0), 0.3, 2, 15.0,
    ),
}  # fmt: skip


def wander_of(mode: str, channel: str, kind: str) -> Wander | None:
    """How a feature moves in a mode of work (`activity.Activity.mode`); None where it is not watched there."""
    return (CIRCULATING if mode == OFF_BOTTOM else WANDERS).get((channel, kind))


def parameter_wanders(names: Sequence[str]) -> Array:
    """(p, k): ways in which tracked parameters of these names wander; parameters of one kind do so together."""
    columns = [[size if name.startswith(kind) else 0.0 for name in names] for kind, size in _PARAMETERS.items()]
    return np.array(columns).T
