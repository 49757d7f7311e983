"""How features wander on rigs that do not change, learnt from plants of foreign structure, and a change's threshold.

The numbers are in noise levels of the channel. They say what a step has to stand out from; the threshold on the
evidence keeps false alarms below one in 24 h of slides with operations.
"""

from __future__ import annotations

from slider_drilling.twin.change_statistic import Wander

THRESHOLD = 14.0

# (channel, kind) -> short, slow, memory s, drift, jump, smallest change.
WANDERS = {
    ("surface_torque", "mean"): Wander(0.15, 0.25, 60.0, 0.3, 1.0, 0.7),
    ("surface_torque", "gain"): Wander(0.15, 0.25, 60.0, 0.3, 1.0, 0.7),
    ("surface_torque", "lag"): Wander(0.10, 0.15, 60.0, 0.2, 0.5, 0.5),
    ("surface_torque", "spread"): Wander(0.06, 0.06, 60.0, 0.1, 0.3, 0.2),
    ("hook_load", "mean"): Wander(0.10, 0.15, 60.0, 0.2, 1.0, 0.7),
    ("hook_load", "gain"): Wander(0.10, 0.10, 60.0, 0.2, 0.3, 0.7),
    ("hook_load", "lag"): Wander(0.10, 0.10, 60.0, 0.2, 0.3, 0.7),
    ("hook_load", "spread"): Wander(0.06, 0.05, 60.0, 0.1, 0.2, 0.2),
    ("standpipe_pressure", "mean"): Wander(0.15, 0.30, 60.0, 0.5, 1.0, 0.7),
    ("standpipe_pressure", "gain"): Wander(0.15, 0.25, 60.0, 0.3, 0.5, 0.7),
    ("standpipe_pressure", "lag"): Wander(0.15, 0.20, 60.0, 0.3, 0.5, 0.7),
    ("standpipe_pressure", "spread"): Wander(0.06, 0.06, 60.0, 0.1, 0.2, 0.2),
    ("tool_face", "mean"): Wander(2.0, 5.0, 100.0, 5.0, 20.0, 10.0),
}
