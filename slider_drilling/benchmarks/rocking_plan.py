"""Rocking plans of random wells against full simulations of the slides.

`python -m slider_drilling.benchmarks.rocking_plan [WELLS [SEED]]`; another seed draws other wells.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from slider_drilling.api.rigs import load_rig
from slider_drilling.blind.wells import DEFAULT_WELLS, WELLS
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.rig import Rig
from slider_drilling.rocking_design.check import PlanCheck, check_row
from slider_drilling.rocking_design.closed_forms import friction_around
from slider_drilling.rocking_design.plan import MAKE_UP_SHARE, PlanOptions, PlanRow, bit_load, plan_depth

COUNT = 12
_FIRST_SEED = 1000
_WEAK_SHARE = 0.5  # of the torque that turns the whole string


@dataclass(frozen=True)
class CheckedPlan:
    """A well's plan with the bit at total depth, and its full simulation; processor time of each, s."""

    well: str
    row: PlanRow
    check: PlanCheck
    plan_seconds: float
    check_seconds: float

    @property
    def reach_error(self) -> float:
        """Of the planned reach, over the simulated one."""
        return self.row.steady.rocked_to / self.check.rocked.rocked_to - 1.0

    @property
    def closed_form_error(self) -> float:
        """Of the closed form's reach, over the simulated one."""
        return self.row.closed_form_reach / self.check.rocked.rocked_to - 1.0

    @property
    def weight_error(self) -> float:
        """Of the planned weight on bit, over the simulated one."""
        return self.row.steady.weight_on_bit / self.check.rocked.weight_on_bit - 1.0

    @property
    def still_error(self) -> float:
        """Of the weight on bit without rocking, over the planned weight."""
        return (self.row.weight_without_rocking - self.check.weight_without_rocking) / self.row.load.weight_on_bit


def checked_plans(count: int = COUNT, first_seed: int = _FIRST_SEED) -> Iterator[CheckedPlan]:
    """Plans of wells drawn as those of the blind test are, one of each kind in turn; every other has weak connections.
    """
    base = load_rig()
    for number in range(count):
        kind = DEFAULT_WELLS[number % len(DEFAULT_WELLS)]
        rig = WELLS[kind](np.random.default_rng(first_seed + number), base)
        options = _options(rig, weak=number % 2 == 1)
        start = time.process_time()
        row = plan_depth(rig, rig.string.length, options)
        planned = time.process_time()
        check = check_row(rig, row)
        yield CheckedPlan(kind, row, check, planned - start, time.process_time() - planned)


def _options(rig: Rig, weak: bool) -> PlanOptions:
    """Options of a plan; of weak connections, which let rocking free only a part of the string."""
    if not weak:
        return PlanOptions()
    load = bit_load(rig, PlanOptions())
    model = TorqueAndDrag(rig, friction_around(rig), load.weight_on_bit)
    whole = model.breakover_torque(model.full_amplitude(1.0), 1.0)
    return PlanOptions(make_up_torque=(_WEAK_SHARE * whole + load.torque) / MAKE_UP_SHARE, back_off_torque=whole)


def table(plans: Iterator[CheckedPlan]) -> Iterator[str]:
    """The lines of a Markdown table."""
    yield ("| well | limited by | depth m | amplitude rad | period s | reach m | simulated | error % | closed form % "
           "| weight on bit kN | simulated | error % | without rocking kN | simulated |")  # fmt: skip
    yield "|---" * 14 + "|"
    seconds = []
    for plan in plans:
        seconds.append((plan.plan_seconds, plan.check_seconds))
        row, check = plan.row, plan.check
        yield (
            f"| {plan.well} | {row.limited_by} | {row.depth:.0f} | {row.amplitude:.2f} | {row.drive.period:.1f} | "
            f"{row.steady.rocked_to:.0f} | {check.rocked.rocked_to:.0f} | {100 * plan.reach_error:+.1f} | "
            f"{100 * plan.closed_form_error:+.1f} | {row.steady.weight_on_bit / 1e3:.1f} | "
            f"{check.rocked.weight_on_bit / 1e3:.1f} | {100 * plan.weight_error:+.1f} | "
            f"{row.weight_without_rocking / 1e3:.1f} | {check.weight_without_rocking / 1e3:.1f} |"
        )
    planned, checked = np.mean(seconds, axis=0)
    yield f"processor time of a depth, on average: plan {planned:.1f} s, full simulation {checked:.1f} s"


if __name__ == "__main__":
    for line in table(checked_plans(*map(int, sys.argv[1:3]))):
        print(line, flush=True)
