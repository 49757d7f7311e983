"""A plan's row against a full simulation of the slide: from rest, with a finer string, the hook load held.

The plan itself comes from steady rocking with the weight on bit held on a coarser string. Here reach and weight on bit
are what comes out when a driller rocks as planned and holds the planned hook load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.control.rocking import Rocking
from slider_drilling.drillstring import Plant
from slider_drilling.rig import Rig
from slider_drilling.rocking_design.plan import PlanRow
from slider_drilling.rocking_design.steady_rocking import SteadyRocking, measure, rock
from slider_drilling.wellbore.broomstick import with_bit_at

_ELEMENTS, _INTERVAL = 200, 0.1
_SETTLE, _PERIODS = 900.0, 9  # s and periods


@dataclass(frozen=True)
class PlanCheck:
    """What the full simulation shows.

    Attributes:
        rocked: With the planned rocking.
        weight_without_rocking: Weight on bit at the same hook load with the top drive held, N.
    """

    rocked: SteadyRocking
    weight_without_rocking: float


def check_row(rig: Rig, row: PlanRow) -> PlanCheck:
    """Simulate the slide of a row with and without rocking."""
    here = with_bit_at(rig, row.depth)
    rocked = _slide(here, row, row.drive, row.offset)
    still = _slide(here, row, Rocking(0.0, row.drive.period, row.drive.rounding), 0.0)
    return PlanCheck(rocked, still.weight_on_bit)


def _slide(rig: Rig, row: PlanRow, drive: Rocking, centre: float) -> SteadyRocking:
    plant = Plant(rig, _ELEMENTS, _INTERVAL)
    settle = math.ceil(_SETTLE / drive.period) * drive.period
    held = row.steady.hook_load
    run = rock(plant, drive, row.load, settle, _PERIODS * drive.period, centre, lambda hook_load, _: hook_load - held)
    return measure(run, plant, drive, row.load)
