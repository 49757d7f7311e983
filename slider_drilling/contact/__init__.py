"""The paper's multiscale friction model: a rigid asperity that wears the wall, on an elastic foot that deforms.

A friction history of any motion, in three lines::

    from slider_drilling.contact import PAPER, friction_history
    history = friction_history(time, axial, tangential, normal_force=1887.0, contact=PAPER, radius=0.0635)
    print(history.means(since=10.0))

Arrays are in s and m; see `friction_history`.
"""

from slider_drilling.asperity_friction import WearMode, friction_coefficient, wear_mode
from slider_drilling.contact.asperity import (
    PAPER,
    TABLE_SIZE,
    effective_attack_angle,
    friction_coefficient_of_direction,
    friction_table,
)
from slider_drilling.contact.friction_history import FrictionHistory, FrictionMeans, friction_history

__all__ = [
    "PAPER",
    "TABLE_SIZE",
    "FrictionHistory",
    "FrictionMeans",
    "WearMode",
    "effective_attack_angle",
    "friction_coefficient",
    "friction_coefficient_of_direction",
    "friction_history",
    "friction_table",
    "wear_mode",
]
