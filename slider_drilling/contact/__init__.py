"""The paper's multiscale friction model: rigid asperities that wear, on elastic ones that deform.

from slider_drilling.contact import PAPER, friction_history
history = friction_history(time, axial, tangential, normal_force=1887.0, contact=PAPER, radius=0.0635)
print(history.means(since=10.0))
"""

from slider_drilling.contact.asperity import (
    PAPER,
    TABLE_SIZE,
    WearMode,
    effective_attack_angle,
    friction_coefficient,
    friction_coefficient_of_direction,
    friction_table,
    wear_mode,
)

__all__ = [
    "PAPER",
    "TABLE_SIZE",
    "WearMode",
    "effective_attack_angle",
    "friction_coefficient",
    "friction_coefficient_of_direction",
    "friction_table",
    "wear_mode",
]
