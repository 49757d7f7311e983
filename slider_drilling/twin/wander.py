"""How features wander on rigs that do not change, learnt from slides of plants of foreign structure.

The numbers are in noise levels of the channel: those of maximum likelihood, rounded, over slides with operations of 32
foreign rigs in which nothing begins, 14 by the controller and 18 by a crew that rocks by hand
(`slider_drilling.benchmarks.twin_wander` fits them to any slides). What a slipping string brings is the likeliest on
three slides of an independent rig and four of crews. What a mean has of its own is set by hand: less of it makes a
small move within a stretch look like a change. So are the thresholds: a quarter above what these slides, 16
more and 10 of an independent rig show, but for what single slides show; on two of 8 fresh slides without a change a
feature went beyond a tenth. What is smaller is left to the regular checks.
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
        white=0.3, slow=1.0, memory=1100, drift=0.12, jump=0.65, fresh=0.22,
        weighed=0.89, steered=0.22, swung=0.17, threshold=22.0, smallest=1.2,
    ),
    ("surface_torque", "gain"): Wander(
        white=0.05, slow=0.14, memory=160, drift=0.017, jump=0.022, fresh=0.12,
        weighed=0.43, steered=0.0052, swung=0.15, threshold=18.5, smallest=0.3,
        values=4, before=9,
    ),
    ("surface_torque", "lag"): Wander(
        white=0.06, slow=0.071, memory=490, drift=0.019, jump=0.007, fresh=0.013,
        weighed=0.45, steered=0.01, swung=0.2, threshold=19.5, smallest=0.2,
    ),
    ("surface_torque", "spread"): Wander(
        white=0.06, slow=0.038, memory=61, drift=0.005, jump=0.005, fresh=0.063,
        weighed=0.19, steered=0.0054, swung=0.13, threshold=32.0, smallest=0.15,
        values=4, before=9,
    ),
    ("hook_load", "mean"): Wander(
        white=0.2, slow=0.95, memory=3000, drift=0.38, jump=0.38, fresh=0.047,
        weighed=0.9, steered=0.083, swung=0.17, threshold=20.0, smallest=1.0,
    ),
    ("hook_load", "gain"): Wander(
        white=0.06, slow=0.016, memory=92, drift=0.005, jump=0.005, fresh=0.0054,
        weighed=0.0078, steered=0.002, swung=0.023, threshold=11.0, smallest=0.3,
        values=4, before=9,
    ),
    ("hook_load", "lag"): Wander(
        white=0.1, slow=0.0056, memory=2900, drift=0.005, jump=0.005, fresh=0.0085,
        weighed=0.012, steered=0.002, swung=0.007, threshold=8.5, smallest=0.3,
    ),
    ("hook_load", "spread"): Wander(
        white=0.06, slow=0.0066, memory=2500, drift=0.005, jump=0.005, fresh=0.005,
        weighed=0.0051, steered=0.002, swung=0.01, threshold=7.5, smallest=0.15,
        values=4, before=9,
    ),
    ("standpipe_pressure", "mean"): Wander(
        white=0.5, slow=0.93, memory=250, drift=0.12, jump=0.53, fresh=0.88,
        weighed=2.0, steered=0.033, swung=1.1, threshold=12.5, smallest=2.0, slipped=2.0,
    ),
    ("standpipe_pressure", "spread"): Wander(
        white=0.08, slow=0.032, memory=760, drift=0.005, jump=0.011, fresh=0.027,
        weighed=0.12, steered=0.002, swung=0.16, threshold=14.5, smallest=0.15,
    ),
}  # fmt: skip

# The same off bottom with the pump on, where pressure is circulation's alone. By hand: a slide has two or three such
# stretches, too few to fit numbers. Between two of them the pressure of 24 foreign slides without a change moves by up
# to 4.9 noise levels, as mud warms up and flow changes. Only stretches are compared with each other: within one the
# rig's bit may touch bottom before the twin's. That raises the pressure. Nothing lets it fall on a rig that does not
# change: within no stretch of 72 slides did it fall by one noise level.
CIRCULATING = {
    ("hook_load", "spread"): Wander(
        white=0.1, slow=0.05, memory=340, drift=0.05, jump=0.1, fresh=0.0, weighed=0.0, steered=0.0, swung=0.0,
        threshold=8.0, smallest=0.3, values=3, before=1, freedom=20.0, within=False,
    ),
    ("standpipe_pressure", "mean"): Wander(
        white=0.2, slow=1.5, memory=1000, drift=0.5, jump=1.4, fresh=0.0, weighed=0.0, steered=0.0, swung=0.0,
        threshold=7.5, smallest=3.0, values=3, before=1, freedom=20.0,
    ),
    ("standpipe_pressure", "spread"): Wander(
        white=0.08, slow=0.01, memory=340, drift=0.01, jump=0.06, fresh=0.0, weighed=0.0, steered=0.0, swung=0.0,
        threshold=15.0, smallest=0.3, values=3, before=1, freedom=20.0, within=False,
    ),
}  # fmt: skip


ROCKING_OR_OFF_BOTTOM = "rocking or off bottom"
"""Name of the work through which the mean pressure is compared; a string that turns loads the bit in another way."""


def comparisons(mode: str, channel: str, kind: str) -> tuple[str, ...]:
    """Names of the kinds of work whose values of a feature are compared with those of a mode (`activity.Activity`)."""
    if (channel, kind) == ("standpipe_pressure", "mean"):
        return {"rocking": (ROCKING_OR_OFF_BOTTOM,), OFF_BOTTOM: (OFF_BOTTOM, ROCKING_OR_OFF_BOTTOM)}.get(mode, (mode,))
    return (mode,)


def wander_of(work: str, channel: str, kind: str) -> Wander | None:
    """How a feature moves in a kind of work (`comparisons`); None where it is not watched there."""
    return (CIRCULATING if work == OFF_BOTTOM else WANDERS).get((channel, kind))


def parameter_wanders(names: Sequence[str]) -> Array:
    """(p, k): ways in which tracked parameters of these names wander; parameters of one kind do so together."""
    columns = [[size if name.startswith(kind) else 0.0 for name in names] for kind, size in _PARAMETERS.items()]
    return np.array(columns).T
