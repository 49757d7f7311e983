"""`torque_drag`: hook load and torque over depth, and friction from the driller's weights."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling.analysis.calibrate_friction import FrictionCalibration, calibrated_broomstick
from slider_drilling.analysis.calibrate_log import calibrate_log
from slider_drilling.analysis.driller_weights import DrillerWeights
from slider_drilling.analysis.friction_tables import calibration_json
from slider_drilling.analysis.torque_drag import (
    LogPoints,
    hook_load_chart,
    log_points,
    torque_chart,
    torque_drag_page,
)
from slider_drilling.api.checks import check_elements, check_rig
from slider_drilling.api.replay import as_log
from slider_drilling.columns import Columns, TableExport
from slider_drilling.files.output_files import make_folder, write_atomically
from slider_drilling.pages import write_page
from slider_drilling.pages.png import render_png
from slider_drilling.rig import Rig, dump_rig
from slider_drilling.schema.option_types import check_argument
from slider_drilling.units import SI, Units
from slider_drilling.wellbore.broomstick import Broomstick, broomstick

if TYPE_CHECKING:
    import plotly

    from slider_drilling.api.diagnose import LogLike

FRICTIONS = (0.15, 0.2, 0.25, 0.3, 0.35)


@dataclass(frozen=True, repr=False)
class TorqueDragResult(TableExport):
    """Broomsticks of a well, and friction calibrated from the driller's weights.

    Attributes:
        rig: With the calibrated friction, if there is a calibration.
        sticks: Loads over bit depth: with the rig file's friction, calibrated, and with each given coefficient.
        points: Of the log.
        calibration: None without readings.
        notes: What a reader should know.
    """

    rig: Rig
    sticks: tuple[Broomstick, ...]
    points: LogPoints | None
    calibration: FrictionCalibration | None
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        friction = [f"{row.kind} {row.factor:.3f}" for row in (self.calibration.intervals if self.calibration else ())]
        return f"TorqueDragResult({len(self.sticks)} broomsticks; calibrated: {', '.join(friction) or 'no readings'})"

    def columns(self) -> Columns:
        """Every broomstick: friction (``contact``, ``calibrated`` or a coefficient), bit depth, loads and torque."""
        names = np.concatenate([np.full(len(s.depth), s.label, dtype=object) for s in self.sticks])
        values = {name: np.concatenate([getattr(s, attribute) for s in self.sticks])
                  for name, attribute in (("bit_depth", "depth"), ("slack_off", "slack_off"), ("turning", "rotating"),
                                          ("pick_up", "pick_up"), ("torque_to_turn", "torque"))}  # fmt: skip
        units = {"bit_depth": "m", "slack_off": "N", "turning": "N", "pick_up": "N", "torque_to_turn": "N m"}
        return Columns({"friction": names, **values}, units)

    def tree(self) -> dict[str, Any]:
        """What `slider-drilling torque-drag --json` prints, in SI units."""
        rows = [{"friction": s.friction, "calibrated": s.calibrated, "slack_off_n": s.slack_off[-1],
                 "turning_n": s.rotating[-1], "pick_up_n": s.pick_up[-1], "torque_to_turn_n_m": s.torque[-1]}
                for s in self.sticks]  # fmt: skip
        return {"at_total_depth": rows, "calibration": calibration_json(self.calibration), "notes": self.notes}

    def files(self, folder: str | os.PathLike[str], with_rig: bool = False) -> list[Path]:
        """The files that `save` writes."""
        suffixes = ("html", "png", "csv", *(["rig.yaml"] if with_rig or self.calibration is not None else []))
        return [Path(folder) / f"torque_drag.{suffix}" for suffix in suffixes]

    def save(self, folder: str | os.PathLike[str], units: Units = SI, with_rig: bool = False) -> list[Path]:
        """Write torque_drag.html, .png and .csv, and the calibrated rig file; returns their paths.

        Args:
            folder: Created if it does not exist.
            units: Of page and picture.
            with_rig: Write the rig file also without a calibration.

        Raises:
            InputError: A file cannot be written.
        """
        make_folder(Path(folder))
        page, image, table, *changed = self.files(folder, with_rig)
        weights = None if self.calibration is None else self.calibration.weights
        charts = (hook_load_chart(self.sticks, self.points, weights), torque_chart(self.sticks, self.points, weights))
        shown = torque_drag_page(self.rig, self.sticks, self.points, self.notes, units, self.calibration)
        write_page(page, shown, units)
        write_atomically(image, render_png(charts, units))
        write_atomically(table, _csv(self.sticks).encode())
        for path in changed:
            write_atomically(path, dump_rig(self.rig).encode())
        return [page, image, table, *changed]

    def plot(self, units: Units = SI) -> plotly.graph_objects.Figure:
        """Hook load over bit depth."""
        from slider_drilling.pages.notebook import plotly_figure

        weights = None if self.calibration is None else self.calibration.weights
        return plotly_figure(hook_load_chart(self.sticks, self.points, weights), units)


def torque_drag(
    rig: Rig,
    *,
    log: LogLike | None = None,
    weights: Sequence[DrillerWeights] = (),
    block_weight: float | None = None,
    frictions: Sequence[float] = FRICTIONS,
    elements: int = 200,
    units: Units = SI,
) -> TorqueDragResult:
    """Hook load and torque over bit depth, with friction calibrated from the driller's weights.

    Args:
        rig: The rig.
        log: Drawn on the chart, and searched for weights if none are given.
        weights: Readings off bottom, SI.
        block_weight: Of block, top drive and hoses in the hook loads, N; 0 if tared; None: found out where clear.
        frictions: Coefficients to draw beside the rig's own.
        elements: Of the string.
        units: Of messages.

    Raises:
        InputError: Something cannot be used.
    """
    check_rig(rig, "torque_drag")
    check_elements(elements, "torque_drag")
    check_argument(block_weight, float | None, "torque_drag: block_weight")
    check_argument(frictions, tuple[float, ...], "torque_drag: frictions")
    record = None if log is None else as_log(log)
    calibration, missing = calibrate_log(record, rig, weights, block_weight, units)
    notes = (*(() if record is None else record.notes), *([missing] if missing else []))
    sticks = [broomstick(rig, friction, elements=elements) for friction in (None, *frictions)]
    if calibration is not None:
        sticks.insert(1, calibrated_broomstick(calibration, elements))
    block = block_weight if calibration is None else calibration.block_weight
    points = None if record is None else log_points(record, rig, block or 0.0)
    final = rig if calibration is None else calibration.rig
    return TorqueDragResult(final, tuple(sticks), points, calibration, tuple(map(str, notes)))


def _csv(sticks: Sequence[Broomstick]) -> str:
    lines = ["friction,bit_depth_m,slack_off_n,turning_n,pick_up_n,torque_to_turn_n_m"]
    for stick in sticks:
        columns = zip(stick.depth, stick.slack_off, stick.rotating, stick.pick_up, stick.torque, strict=True)
        lines += [",".join([stick.label, *(f"{value:.8g}" for value in row)]) for row in columns]
    return "\n".join(lines) + "\n"
