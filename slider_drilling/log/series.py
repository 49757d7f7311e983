"""A log in memory: arrays of one topic, and all of a log's topics."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slider_drilling.columns import Columns, SampledQuantity, join_samples
from slider_drilling.errors import InputError
from slider_drilling.log.import_record import ImportRecord
from slider_drilling.messages.topics import TOPICS, Topic
from slider_drilling.rig import Rig, parse_rig

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointSeries:
    """A joint over time. Arrays have shape (n,); a value that the messages do not give is NaN.

    Attributes:
        time: When it was measured, s since the log's start, strictly increasing.
        arrival: When the log had it, s since the start.
        position: rad or m.
        velocity: rad/s or m/s.
        effort: N m or N.
    """

    time: Array
    arrival: Array
    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True)
class ScalarSeries:
    """A quantity over time. Arrays have shape (n,).

    Attributes:
        time: When it was measured, s since the log's start, strictly increasing.
        arrival: When the log had it, s since the start.
        value: In the quantity's SI unit.
        variance: In its square; NaN where unknown.
    """

    time: Array
    arrival: Array
    value: Array
    variance: Array


Series = JointSeries | ScalarSeries


def build_series(topic: Topic, time: Array, arrival: Array, arrays: dict[str, Array]) -> Series:
    """The series of a topic; arrays that are not given are NaN.

    Args:
        topic: From the registry.
        time: When each sample was measured, s since the log's start, (n,).
        arrival: When each arrived, s, (n,).
        arrays: By name, such as position, SI, each (n,).

    Raises:
        InputError: The topic is of a type whose numbers a log does not keep.
    """
    logged = {part.array for part in topic.message_type().logged}
    kind = JointSeries if "position" in logged else ScalarSeries
    names = [part.name for part in fields(kind)[2:]]
    return kind(time, arrival, *(arrays[name] if name in arrays else np.full(len(time), np.nan) for name in names))


@dataclass(frozen=True)
class LogContents:
    """What one log holds. A series that is not in it is None.

    Attributes:
        source: The file or folder, for messages.
        start_ns: t = 0 of every series, ns since the epoch of the rig's (or the simulation's) clock: the first sample
            of the top drive, or of the first channel there is. Samples measured before that have negative times.
        rig_text: The rig file's text.
        rig_source: Where that comes from.
        metadata: The record `slider_drilling` of the log.
        notes: What a reader should know of the log's state, one sentence each: damage, repeated stamps, topics left
            out.
        unreadable: Series -> why it, or an array of it, is missing although the log holds messages that could be its.
        imported: What an import did to the table that the log comes from; None for a recorded log.
        programme_text: The programme that was run, as its file's text; None where none was.
        replaced_rig_text: The text of the log's own rig file, where a given one replaces it.
    """

    source: str
    start_ns: int
    rig_text: str | None = None
    rig_source: str | None = None
    metadata: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    unreadable: dict[str, str] = field(default_factory=dict)
    imported: ImportRecord | None = None
    programme_text: str | None = None
    replaced_rig_text: str | None = None
    # One for each entry of the registry of topics.
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
    expected_top_drive: JointSeries | None = None
    expected_draw_works: JointSeries | None = None
    expected_standpipe_pressure: ScalarSeries | None = None
    expected_mwd_tool_face: JointSeries | None = None
    forecast_top_drive: JointSeries | None = None
    forecast_mwd_tool_face: JointSeries | None = None

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.source}: {self.end:.1f} s of {', '.join(self.series())})"

    @property
    def end(self) -> float:
        """s since its start, of the last sample; 0 without any."""
        return max((float(series.time[-1]) for series in self.series().values() if len(series.time)), default=0.0)

    @property
    def start(self) -> float:
        """Epoch seconds of t = 0."""
        return self.start_ns / 1e9

    def rig(self) -> Rig:
        """The rig that the log was recorded with. Raises InputError where there is none or it cannot be used."""
        if self.rig_text is None:
            raise InputError(f"{self.source}: has no rig.yaml attachment; give the rig file with --rig")
        return parse_rig(self.rig_text, self.rig_source or self.source)

    def lack_of_top_drive(self, use: str) -> str:
        """Why a log without a top drive cannot be used, in one line; `use`: what the top drive does, as a verb."""
        why = self.why_unreadable("top_drive")
        return f"{self.source}: holds no top_drive/joint_states; without it nothing {use}{why}"

    def why_unreadable(self, key: str) -> str:
        """The end of a sentence on a series, or an array of it, that is missing: why it could not be read."""
        return f"; {self.unreadable[key]}" if key in self.unreadable else ""

    def series(self) -> dict[str, Series]:
        """The series that the log holds, by their keys in the registry of topics and in its order."""
        every: dict[str, Any] = {key: getattr(self, key) for key in TOPICS}
        return {key: series for key, series in every.items() if series is not None}

    def columns(self) -> Columns:
        """Every quantity that the log holds over the union of its times, s since its start, when measured; SI."""
        return join_samples(
            SampledQuantity(quantity.column, quantity.unit, series.time, getattr(series, quantity.array))
            for key, series in self.series().items()
            for quantity in TOPICS[key].quantities
        )
