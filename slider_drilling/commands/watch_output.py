"""What `slider-drilling watch` prints: JSON, a line a second, or a table that grows."""

from __future__ import annotations

import json
import math

from slider_drilling.console.results import results_stream
from slider_drilling.console.streams import stderr, stdout
from slider_drilling.process.shutdown import defer_signals
from slider_drilling.twin import Detection, MotorStall, Twin, TwinReport
from slider_drilling.twin.report import Trend
from slider_drilling.units import Units

_EVERY_S = 30.0
_COLUMNS = ("time s", "state", "torque", "hook", "pressure", "toolface", "friction", "motor", "pressure x", "stiffness")
_WIDTHS = (7, 10, 8, 8, 9, 9, 14, 14, 14, 14)


def print_note(text: str) -> None:
    """Print a sentence that is no result."""
    stderr().print(f"note: {text}", highlight=False, markup=False, soft_wrap=True)


class Remarks:
    """Prints each remark of a twin once, to stderr, and why a diagnosis gave no answer.

    Args:
        twin: The twin.
    """

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._printed = 0
        self._failure = ""

    def show(self) -> None:
        """Print those that are new."""
        for remark in self._twin.remarks[self._printed :]:
            print_note(remark)
        self._printed = len(self._twin.remarks)
        if self._twin.failure != self._failure:
            self._failure = self._twin.failure
            if self._failure:
                print_note(f"the diagnosis gave no answer: {self._failure}")


class JsonLines:
    """One JSON object a line; an interrupt leaves whole lines. What is to be said goes to stderr.

    Args:
        twin: The twin, for its remarks.
    """

    def __init__(self, twin: Twin) -> None:
        self._twin = twin
        self._remarks = Remarks(twin)

    def show(self, report: TwinReport) -> None:
        """Print a report."""
        line = json.dumps(report.as_json(), allow_nan=False)
        with defer_signals():
            self._remarks.show()
            print(line, file=results_stream(), flush=True)

    def end(self) -> None:
        """Say why no change could show."""
        if self._twin.report is not None and self._twin.not_compared:
            print_note(self._twin.not_compared)


class TableLines:
    """A row every half minute, and a line for what was detected or answered.

    Args:
        twin: The twin, for its remarks.
        units: Display units.
    """

    def __init__(self, twin: Twin, units: Units) -> None:
        self._twin, self._units = twin, units
        self._remarks = Remarks(twin)
        self._next = -math.inf
        self._detections: dict[int, Detection] = {}
        self._stall: MotorStall | None = None
        self._last: TwinReport | None = None

    def show(self, report: TwinReport) -> None:
        """Print what is due."""
        with defer_signals():
            self._remarks.show()
            if self._last is None:
                self._line("gap over 60 s in noise levels (> over its threshold), trends over the rig file's values")
                self._line("".join(name.rjust(width) for name, width in zip(_COLUMNS, _WIDTHS, strict=True)))
            if report.time >= self._next:
                self._line(self._row(report))
                self._next = report.time + _EVERY_S
            for detection in report.detections:
                self._show_detection(detection)
            self._show_stall(report.stall)
        self._last = report

    def end(self) -> None:
        """Print a summary."""
        if self._last is None:
            return
        found = len(self._last.detections)
        changes = f"{found} change{'' if found == 1 else 's'} detected"
        self._line(f"watched {self._last.time:.0f} s: {self._twin.not_compared or changes}")
        if self._twin.learnt and "hook_load" in self._last.channels:
            self._line(self._hook_load_offset(self._last.trends["hook_load_offset"]))

    def _hook_load_offset(self, offset: Trend) -> str:
        """What the hook load reads too much, or too little."""
        sign = 1.0 if offset.value >= 0.0 else -1.0
        ends = sorted((sign * offset.low, sign * offset.high))
        value, low, high = (self._units.convert(each / 1e3, "kN") for each in (abs(offset.value), *ends))
        unit = self._units.display_unit("kN")
        return f"hook load reads {value:.1f} {unit} too {'much' if sign > 0.0 else 'little'} ({low:.1f} to {high:.1f})"

    def _row(self, report: TwinReport) -> str:
        gaps = []
        for name in ("surface_torque", "hook_load", "standpipe_pressure", "tool_face"):
            channel = report.channels.get(name)
            if channel is None or not math.isfinite(channel.gap_60):
                gaps.append("-")
            else:
                gaps.append(f"{'>' if channel.gap_60 > channel.threshold else ''}{channel.gap_60:.2f}")
        trends = []
        for name in ("friction", "motor_gain", "circulating_pressure", "string_stiffness"):
            trend = report.trends.get(name)
            trends.append("-" if trend is None else f"{trend.value:.3f}±{0.5 * (trend.high - trend.low):.3f}")
        cells = (f"{report.time:.0f}", report.state, *gaps, *trends)
        row = "".join(cell.rjust(width) for cell, width in zip(cells, _WIDTHS, strict=True))
        return f"{row}  {report.note}" if report.note and report.state != "watching" else row

    def _show_stall(self, stall: MotorStall | None) -> None:
        before, self._stall = self._stall, stall
        if stall is None or before == stall:
            return
        if before is None or before.since != stall.since:
            self._line(f"MOTOR stalls since {stall.since:.0f} s: {self._units.convert_message(stall.pressures())}")
        if stall.ended is not None:
            self._line(f"MOTOR turns again at {stall.ended:.0f} s")

    def _show_detection(self, detection: Detection) -> None:
        before = self._detections.get(detection.number)
        if before == detection:
            return
        self._detections[detection.number] = detection
        low, high = detection.interval
        since = f"since {detection.since:.0f} s ({low:.0f} to {high:.0f} s)"
        if before is None or (before.kind, before.channel) != (detection.kind, detection.channel):
            self._line(f"CHANGE {detection.number} detected at {detection.detected:.0f} s: {detection.what}, {since}, "
                       f"{detection.size:.1f} noise levels; {detection.kind}, site {detection.site}")  # fmt: skip
        if detection.answered is not None and (before is None or before.answered != detection.answered):
            named = ", ".join(detection.effects) or "no effect named"
            suspected = f"; suspected: {', '.join(detection.suspected)}" if detection.suspected else ""
            self._line(f"ANSWER {detection.number} at {detection.answered:.0f} s: {named} ({detection.verdict}, site "
                       f"{detection.site}), {since}{suspected}")  # fmt: skip
        if detection.ended is not None and (before is None or before.ended is None):
            self._line(f"CHANGE {detection.number} is over since {detection.ended:.0f} s")

    def _line(self, text: str) -> None:
        stdout().print(text, highlight=False, markup=False, soft_wrap=True)
