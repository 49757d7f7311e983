"""`rocking_plan`: how to rock at each depth."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling.api.checks import check_rig
from slider_drilling.columns import Columns, TableExport
from slider_drilling.control.fixed_rocking import FixedRockingSettings
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.files.output_files import make_folder, write_atomically
from slider_drilling.pages import write_page
from slider_drilling.rig import Rig
from slider_drilling.rocking_design.controller_settings import (
    fixed_rocking_settings,
    parameters_file,
    slide_settings,
)
from slider_drilling.rocking_design.page import plan_charts, plan_page
from slider_drilling.rocking_design.plan import Plan, PlanOptions, PlanRow, make_plan
from slider_drilling.rocking_design.plan_table import plan_json
from slider_drilling.rocking_design.sheet import plan_sheet
from slider_drilling.schema.option_types import check_argument
from slider_drilling.units import FIELD, Units

if TYPE_CHECKING:
    import plotly

DEFAULT_DEPTHS = 8
"""Depths of a plan without given ones: from half of the string's length to all of it."""
_UNITS = {
    "depth": "m", "right": "rad", "left": "rad", "offset": "rad", "amplitude": "rad", "period": "s", "speed": "rad/s",
    "torque_right": "N m", "torque_left": "N m", "rocked_to": "m", "tool_face_swing": "rad", "rotating_weight": "N",
    "hook_load": "N", "weight_let_down": "N", "weight_on_bit": "N", "weight_on_bit_without_rocking": "N",
    "reactive_torque": "N m", "differential_pressure": "Pa", "rate_of_penetration": "m/s", "make_up_torque": "N m",
    "back_off_torque": "N m", "make_up_share": "-", "back_off_share": "-", "buckling_share": "-",
    "buckling_depth": "m",
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class RockingPlanResult(TableExport):
    """How to rock at each depth.

    Attributes:
        plan: All of it.
        tree: The content of rocking_plan.json.
    """

    plan: Plan
    tree: dict[str, Any]

    def __repr__(self) -> str:
        rows = self.plan.rows
        return f"RockingPlanResult({len(rows)} depths, {rows[0].depth:g} to {rows[-1].depth:g} m)"

    @property
    def rows(self) -> tuple[PlanRow, ...]:
        """One for each depth."""
        return self.plan.rows

    def columns(self) -> Columns:
        """A row for each depth, SI units and radians; NaN where a torque is not known."""
        values: dict[str, np.ndarray] = {
            name: np.array([np.nan if row[name] is None else row[name] for row in self.tree["rows"]])
            for name in _UNITS
        }
        values["limited_by"] = np.array([row["limited_by"] for row in self.tree["rows"]], dtype=object)
        return Columns(values, {name: unit for name, unit in _UNITS.items() if unit != "-"})

    def fixed_rocking(self, row: int = -1) -> FixedRockingSettings:
        """Settings of `slider_drilling.control.FixedRocking` for a row, by default the last."""
        return fixed_rocking_settings(self.plan.rig, self.plan.rows[row])

    def slide_controller(self, row: int = -1) -> SlideSettings:
        """Settings of `slider_drilling.control.SlideController` for a row, by default the last."""
        return slide_settings(self.plan.rows[row])

    def save(self, folder: str | os.PathLike[str], units: Units = FIELD, block_weight: float = 0.0) -> list[Path]:
        """Write the page, the sheet, JSON, and the controllers' settings for the last depth; returns their paths.

        Args:
            folder: Created if it does not exist.
            units: Of page and sheet.
            block_weight: Added to the hook loads of page and sheet, N.

        Raises:
            InputError: A file cannot be written.
        """
        make_folder(Path(folder))
        page, sheet, tree, fixed, slide = paths = plan_files(folder)
        depth = f"rocking plan with the bit at {self.plan.rows[-1].depth:.1f} m"
        write_page(page, plan_page(self.plan, units, block_weight), units)
        write_atomically(sheet, plan_sheet(self.plan, units, block_weight))
        write_atomically(tree, f"{json.dumps(self.tree, indent=1, allow_nan=False)}\n".encode())
        write_atomically(fixed, parameters_file("slider_drilling.control:FixedRocking", self.fixed_rocking(),
                                                depth).encode())  # fmt: skip
        write_atomically(slide, parameters_file("slider_drilling.control:SlideController", self.slide_controller(),
                                                depth).encode())  # fmt: skip
        return paths

    def plot(self, index: int = 0) -> plotly.graph_objects.Figure:
        """A chart over depth: turning points, torque, weight on bit, or the depth that rocking frees."""
        from slider_drilling.pages.notebook import plotly_figure

        return plotly_figure(plan_charts(self.plan)[index])


def plan_files(folder: str | os.PathLike[str]) -> list[Path]:
    """The files that `RockingPlanResult.save` writes."""
    names = ("html", "pdf", "json", "fixed_rocking.yaml", "slide_controller.yaml")
    return [Path(folder) / f"rocking_plan.{name}" for name in names]


def default_depths(rig: Rig) -> list[float]:
    """Depths (m) from half of the string's length to all of it."""
    return [float(depth) for depth in np.linspace(0.5 * rig.string.length, rig.string.length, DEFAULT_DEPTHS)]


def rocking_plan(
    rig: Rig,
    depths: Sequence[float] | None = None,
    *,
    options: PlanOptions | None = None,
    progress: Callable[[float], None] | None = None,
) -> RockingPlanResult:
    """Plan how to rock at each depth.

    Args:
        rig: The rig.
        depths: Of the bit, m; None for eight depths from half of the string's length to all of it.
        options: Rate of penetration or differential pressure, limits of torque and toolface swing, period.
        progress: Called with the share of depths that are done.

    Raises:
        InputError: Something cannot be used.
    """
    check_rig(rig, "rocking_plan")
    check_argument(options, PlanOptions | None, "rocking_plan: options")
    check_argument(depths, tuple[float, ...] | None, "rocking_plan: depths")
    given = default_depths(rig) if depths is None else [float(depth) for depth in depths]
    plan = make_plan(rig, given, options or PlanOptions(), progress)
    return RockingPlanResult(plan, plan_json(plan))
