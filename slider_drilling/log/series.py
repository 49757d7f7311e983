"""A log in memory: one series of arrays a topic."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from slider_drilling.errors import InputError
from slider_drilling.rig import Rig, parse_rig

if TYPE_CHECKING:
    import pandas
    import plotly

    from slider_drilling.columns import Columns

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointSeries:
    """A joint over time; every array has shape (n,), a value that the messages do not give is NaN.

    time: s since the log's start, strictly increasing, when it was measured; arrival: s since the start, when the
    log had it; position: rad or m; velocity: rad/s or m/s; effort: N m or N.
    """

    time: Array
    arrival: Array
    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True)
class ScalarSeries:
    """A quantity over time; every array has shape (n,).

    time and arrival as in JointSeries; value in the quantity's SI unit; variance in its square, NaN where unknown.
    """

    time: Array
    arrival: Array
    value: Array
    variance: Array


@dataclass(frozen=True)
class RigLog:
    """What one log holds. Series that are not in it are None.

    start_ns: ns since the epoch of the rig's (or the simulation's) clock, t = 0 of every series: the first sample of
    the top drive, or of the first channel there is. Samples measured before that have negative times.
    notes: what a reader should know of the log's state, one sentence each: damage, repeated stamps, topics ignored.
    """

    source: str
    start_ns: int
    rig_text: str | None = None
    rig_source: str | None = None
    metadata: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    top_drive: JointSeries | None = None
    top_drive_command: JointSeries | None = None
    draw_works: JointSeries | None = None
    draw_works_command: JointSeries | None = None
    standpipe_pressure: ScalarSeries | None = None
    mud_pump: JointSeries | None = None
    mwd_tool_face: JointSeries | None = None
    tool_face_target: JointSeries | None = None
    bit_depth: JointSeries | None = None
    truth_bit: JointSeries | None = None
    truth_weight_on_bit: ScalarSeries | None = None
    truth_depth: JointSeries | None = None

    def __repr__(self) -> str:
        there = [name for name, value in vars(self).items() if isinstance(value, (JointSeries, ScalarSeries))]
        ends = [float(getattr(self, name).time[-1]) for name in there if len(getattr(self, name).time)]
        return f"RigLog({self.source}: {max(ends, default=0.0):.1f} s of {', '.join(there)})"

    def to_frame(self) -> pandas.DataFrame:
        """Every quantity against time, s, NaN where it has no sample; SI units, in ``attrs["units"]``.

        Raises InputError where pandas is not installed.
        """
        return self._columns().to_frame()

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """The same as CSV, units in its heads. Raises InputError."""
        return self._columns().to_csv(path)

    def to_parquet(self, path: str | os.PathLike[str]) -> Path:
        """The same as Parquet. Raises InputError, where pandas or pyarrow is not installed too."""
        return self._columns().to_parquet(path)

    def plot(self) -> plotly.graph_objects.Figure:
        """Toolface, top drive, torque, pressure, hook load and weight on bit against time, in field units."""
        from slider_drilling.log.run_page import log_chart
        from slider_drilling.pages.notebook import plotly_figure

        return plotly_figure(log_chart(self))

    def _columns(self) -> Columns:
        from slider_drilling.log.columns import columns_of

        return columns_of(self)

    @property
    def start(self) -> float:
        """Epoch seconds of t = 0."""
        return self.start_ns / 1e9

    def rig(self) -> Rig:
        """The rig that the log was recorded with. Raises InputError where there is none or it cannot be used."""
        if self.rig_text is None:
            raise InputError(f"{self.source}: has no rig.yaml attachment; give the rig file beside it")
        return parse_rig(self.rig_text, self.rig_source or self.source)
