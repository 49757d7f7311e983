"""How features wander on rigs that do not change, learnt from plants of foreign structure, and a change's threshold.

The numbers are in noise levels of the channel. They say what a step has to stand out from; the threshold on the
evidence keeps false alarms below one in 24 h of slides with operations.
"""

from __future__ import annotations

from slider_drilling.twin.change_statistic import Wander

THRESHOLD = 14.0

# (channel, kind) -> short, slow, memory s, drift, jump, smallest change.
WANDERS = {
    ("surface_torque", "mean"): Wander(0.10, 0.25, 150.0, 1.0, 2.0, 1.2),
    ("surface_torque", "gain"): Wander(0.10, 0.12, 80.0, 0.15, 0.3, 0.4),
    ("surface_torque", "lag"): Wander(0.10, 0.10, 80.0, 0.15, 0.3, 0.4),
    ("surface_torque", "spread"): Wander(0.08, 0.05, 80.0, 0.08, 0.15, 0.15),
    ("hook_load", "mean"): Wander(0.12, 0.40, 120.0, 0.8, 2.0, 1.0),
    ("hook_load", "gain"): Wander(0.12, 0.05, 80.0, 0.1, 0.2, 0.4),
    ("hook_load", "lag"): Wander(0.12, 0.05, 80.0, 0.1, 0.2, 0.4),
    ("hook_load", "spread"): Wander(0.08, 0.03, 80.0, 0.05, 0.1, 0.15),
    ("standpipe_pressure", "mean"): Wander(0.50, 1.50, 80.0, 1.0, 4.0, 2.0),
    ("standpipe_pressure", "gain"): Wander(0.30, 0.20, 80.0, 0.2, 0.5, 0.7),
    ("standpipe_pressure", "lag"): Wander(0.20, 0.10, 80.0, 0.2, 0.4, 0.7),
    ("standpipe_pressure", "spread"): Wander(0.08, 0.06, 80.0, 0.08, 0.15, 0.15),
}
