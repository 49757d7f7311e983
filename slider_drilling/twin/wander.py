"""How features wander on rigs that do not change, learnt from slides of plants of foreign structure.

The numbers are in noise levels of the channel: those of maximum likelihood, rounded, over slides with operations of 36
foreign rigs, before anything begins (`slider_drilling.benchmarks.twin_wander` fits them to any slides). What a
mean has of its own is set by hand: less of it makes a small move within a stretch look like a change. A threshold is a
little above the largest evidence of these slides, each half tested with the numbers of the other, of 24 more, and of
what 42 more show before something begins in them: 47 h.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slider_drilling.twin.activity import OFF_BOTTOM
from slider_drilling.twin.change_statistic import Wander
from slider_drilling.twin.samples import Array

# Standard deviations of the plant's numbers within an hour: friction of the whole hole; torque per pressure of the
# motor, which stands for that per weight of the bit too.
_PARAMETERS = {"friction_": 0.05, "motor_gain": 0.035}

WANDERS = {
    ("surface_torque", "mean"): Wander(
        white=0.3, slow=0.85, memory=2000, drift=0.68, jump=0.53, fresh=0.16,
        weighed=1.1, steered=0.19, swung=0.76, threshold=12.5, smallest=1.2,
    ),
    ("surface_torque", "gain"): Wander(
        white=0.05, slow=0.12, memory=340, drift=0.03, jump=0.036, fresh=0.054,
        weighed=0.37, steered=0.008, swung=0.16, threshold=12.3, smallest=0.3,
        values=4, before=9,
    ),
    ("surface_torque", "lag"): Wander(
        white=0.06, slow=0.042, memory=200, drift=0.008, jump=0.02, fresh=0.033,
        weighed=0.21, steered=0.003, swung=0.12, threshold=15.5, smallest=0.2,
    ),
    ("surface_torque", "spread"): Wander(
        white=0.06, slow=0.01, memory=300, drift=0.006, jump=0.014, fresh=0.017,
        weighed=0.14, steered=0.004, swung=0.13, threshold=21.7, smallest=0.15,
        values=4, before=9,
    ),
    ("hook_load", "mean"): Wander(
        white=0.2, slow=0.92, memory=2400, drift=0.8, jump=0.38, fresh=0.06,
        weighed=0.85, steered=0.09, swung=0.6, threshold=14.5, smallest=1.0,
    ),
    ("hook_load", "gain"): Wander(
        white=0.06, slow=0.009, memory=2400, drift=0.01, jump=0.005, fresh=0.007,
        weighed=0.016, steered=0.002, swung=0.01, threshold=6.0, smallest=0.3,
        values=4, before=9,
    ),
    ("hook_load", "lag"): Wander(
        white=0.1, slow=0.008, memory=2500, drift=0.005, jump=0.005, fresh=0.013,
        weighed=0.017, steered=0.002, swung=0.007, threshold=7.5, smallest=0.3,
    ),
    ("hook_load", "spread"): Wander(
        white=0.06, slow=0.005, memory=3000, drift=0.005, jump=0.005, fresh=0.008,
        weighed=0.009, steered=0.002, swung=0.005, threshold=8.0, smallest=0.15,
        values=4, before=9,
    ),
    ("standpipe_pressure", "mean"): Wander(
        white=0.5, slow=1.7, memory=840, drift=0.3, jump=0.9, fresh=1.7,
        weighed=2.9, steered=0.07, swung=2.5, threshold=10.5, smallest=2.0,
    ),
    ("standpipe_pressure", "spread"): Wander(
        white=0.08, slow=0.016, memory=1600, drift=0.005, jump=0.008, fresh=0.046,
        weighed=0.19, steered=0.002, swung=0.14, threshold=9.5, smallest=0.15,
    ),
}  # fmt: skip

# The same off bottom with the pump on, where pressure is circulation's alone. By hand: a slide has two or three such
# stretches, too few to fit numbers. Between two of them the pressure of 102 foreign slides without a change moves by up
# to 4.9 noise levels, as mud warms up and flow changes. Only stretches are compared with each other: within one the
# rig's bit may touch bottom before the twin's. That raises the pressure. Nothing lets it fall on a rig that does not
# change: within no stretch did it fall by one noise level.
CIRCULATING = {
    ("hook_load", "spread"): Wander(
        white=0.1, slow=0.05, memory=340, drift=0.05, jump=0.1, fresh=0.0, weighed=0.0, steered=0.0, swung=0.0,
        threshold=8.0, smallest=0.3, values=3, before=1, freedom=20.0, within="none",
    ),
    ("standpipe_pressure", "mean"): Wander(
        white=0.2, slow=1.5, memory=1000, drift=0.5, jump=1.4, fresh=0.0, weighed=0.0, steered=0.0, swung=0.0,
        threshold=7.5, smallest=3.0, values=3, before=1, freedom=20.0, within="fall",
    ),
    ("standpipe_pressure", "spread"): Wander(
        white=0.08, slow=0.01, memory=340, drift=0.01, jump=0.06, fresh=0.0, weighed=0.0, steered=0.0, swung=0.0,
        threshold=15.0, smallest=0.3, values=3, before=1, freedom=20.0, within="none",
    ),
}  # fmt: skip


def wander_of(mode: str, channel: str, kind: str) -> Wander | None:
    """How a feature moves in a mode of work (`activity.Activity.mode`); None where it is not watched there."""
    return (CIRCULATING if mode == OFF_BOTTOM else WANDERS).get((channel, kind))


def parameter_wanders(names: Sequence[str]) -> Array:
    """(p, k): ways in which tracked parameters of these names wander; parameters of one kind do so together."""
    columns = [[size if name.startswith(kind) else 0.0 for name in names] for kind, size in _PARAMETERS.items()]
    return np.array(columns).T
