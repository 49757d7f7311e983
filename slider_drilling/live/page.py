"""The page on NiceGUI: instruments, controls, and the health of the nodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

from nicegui import ui

from slider_drilling.control.tool_face_target import target_refusal
from slider_drilling.live.frame import (
    StringView,
    dial_json,
    drilling_figures,
    expected_json,
    labels_json,
    rocking_json,
    samples_json,
)
from slider_drilling.live.freshness import Freshness
from slider_drilling.live.instruments import Instruments
from slider_drilling.live.page_requests import (
    PageRequest,
    RequestQueue,
    SetParameter,
    SetRecording,
    SetRocking,
    SetTarget,
)
from slider_drilling.live.state import LiveParameter, LiveState, zero_meaning
from slider_drilling.live.twin_panel import TwinPanel
from slider_drilling.messages.health import Level
from slider_drilling.plain_names import plain_name
from slider_drilling.units import SI, Units, quantities_in

TITLE = "Slide drilling"
FRAME_PERIOD = 0.1  # s between frames of the instruments
UPDATE_PERIOD = 1.0  # s between updates of statuses and parameters
_MARKS = {Level.OK: ("check_circle", "sd-ok"), Level.WARN: ("warning", "sd-warn"), Level.ERROR: ("error", "sd-error")}
# Units that a rig uses for SI units: unit and how many of it make one SI unit.
_RIG_UNITS = {"Pa": ("bar", 1e-5), "N m": ("kN m", 1e-3), "N": ("kN", 1e-3)}
_LATE_MARK = ("schedule", "sd-late")
STYLE = Path(__file__).with_name("page.css")


def register_page(state: LiveState, requests: RequestQueue, units: Units = SI) -> None:
    """Serve the page at `/`; every browser gets its own view."""

    @ui.page("/", title=TITLE)
    def page() -> None:
        PageView(state, requests, units)


class PageView:
    """One browser's view. It keeps what it has shown last, and nothing that grows."""

    def __init__(self, state: LiveState, requests: RequestQueue, units: Units = SI) -> None:
        self._state, self._requests, self._units = state, requests, units
        self._sample_count = self._expected_count = 0
        self._string_view: StringView | None = None
        self._last_notice = state.last_notice
        self._shown_statuses: list[tuple[Any, ...]] = []
        self._lines: list[_StatusLine] = []
        self._inputs: dict[tuple[str, str], Any] = {}
        self._values: dict[tuple[str, str], float] = {}
        ui.add_css(STYLE)
        with ui.element("div").classes("sd-head"):
            ui.label(TITLE).classes("sd-title")
            self._facts = ui.label("waiting for the rig").classes("sd-fact").props("data-name=facts")
        with ui.element("div").classes("sd-figures").props("data-name=figures") as self._figure_row:
            self._figures = [_Figure(name) for name, _ in drilling_figures(state, units)]
        self._instruments = Instruments(labels_json(units))
        self._twin = TwinPanel(state, self._send, units, self._display)
        with ui.element("div").classes("sd-below"):
            self._make_controls()
            with ui.element("div").classes("sd-card"):
                ui.label("Interlocks and health").classes("sd-heading")
                self._status_rows = ui.element("div").props("data-name=statuses")
        ui.timer(FRAME_PERIOD, self._send_frame)
        ui.timer(UPDATE_PERIOD, self._update)

    def _make_controls(self) -> None:
        with ui.element("div").classes("sd-card"):
            ui.label("Controls").classes("sd-heading")
            with ui.element("div").classes("sd-row"):
                self._target = (
                    # Without min and max: NiceGUI would turn 900 into 180 without a word.
                    ui.number("new target, deg", step=5, format="%.1f", validation=target_refusal)
                    .props("dense outlined data-name=target")
                    .style("width: 9.5rem")
                )
                ui.button("Set target", on_click=self._set_target).props(
                    "dense no-caps unelevated data-name=set-target"
                )
            with ui.element("div").classes("sd-row"):
                ui.button("Start rocking", icon="play_arrow", on_click=lambda: self._send(SetRocking(True))).props(
                    "dense no-caps outline data-name=start"
                )
                ui.button("Stop rocking", icon="stop", on_click=lambda: self._send(SetRocking(False))).props(
                    "dense no-caps unelevated color=negative data-name=stop"
                )
                self._record = ui.button("Record", icon="fiber_manual_record", on_click=self._toggle_record).props(
                    "dense no-caps outline data-name=record"
                )
            with ui.expansion("Parameters").classes("full-width").props("dense"):
                self._parameter_inputs = ui.element("div").classes("sd-settings").props("data-name=settings")

    def _send(self, request: PageRequest) -> None:
        if not self._requests.put(request):
            ui.notify("the nodes take no requests", type="negative")

    def _set_target(self) -> None:
        if self._target.value is None:
            return
        if refusal := target_refusal(self._target.value):
            ui.notify(f"target = {refusal}", type="negative", timeout=6000)
        else:
            self._send(SetTarget(math.radians(self._target.value)))

    def _toggle_record(self) -> None:
        self._send(SetRecording(not self._state.recording))

    def _send_frame(self) -> None:
        rig = self._state.rig
        if self._string_view is None and rig is not None:
            self._string_view = StringView(rig, self._units)
            self._instruments.show_well_path(self._string_view.well_path_json())
        samples, self._sample_count = self._state.samples_after(self._sample_count)
        if not samples:
            return
        expected, self._expected_count = self._state.twin.expected_after(self._expected_count)
        rotation = self._string_view.rotation_json(self._state) if self._string_view is not None else {}
        self._instruments.draw(
            {
                "samples": samples_json(samples, self._units),
                "expected": expected_json(expected, self._units),
                "dial": dial_json(self._state),
                "rocking": rocking_json(self._state, self._units),
                "rotation": rotation,
            }
        )

    def _update(self) -> None:
        self._show_facts()
        for figure, (_, value) in zip(self._figures, drilling_figures(self._state, self._units), strict=True):
            figure.show(value)
        self._twin.update()
        self._show_statuses()
        self._show_parameters()
        self._instruments.keep_alive()
        for notice in self._state.notices_after(self._last_notice):
            self._last_notice = notice.number
            text = self._units.convert_text(quantities_in(notice.text))
            ui.notify(text, type="positive" if notice.success else "negative", timeout=6000)

    def _show_facts(self) -> None:
        state, latest = self._state, self._state.latest_sample()
        if latest is None:
            return
        age, freshness = state.samples_age()
        self._facts.classes(replace=f"sd-fact sd-{freshness.value}")
        self._instruments.classes(replace=f"sd-{freshness.value}")
        self._figure_row.classes(replace=f"sd-figures sd-{freshness.value}")
        silence = "" if freshness is Freshness.FRESH else f" (no sample since {age:.0f} s)"
        facts = [f"{latest.time:.0f} s{silence}"]
        rocking, turn = rocking_json(state, self._units), self._units.display_unit("rad")
        if rocking["centre"] is not None and rocking["amplitude"] is not None:
            facts.append(
                f"rocking ±{rocking['amplitude']:.1f} {turn} about {rocking['centre']:.1f} {turn}"
                + (f", {rocking['period']:.0f} s" if rocking["period"] is not None else "")
            )
        if math.isfinite(state.target):
            facts.append(f"target {math.degrees(state.target):.0f} deg")
        facts.append(self._recorder_fact())
        self._facts.set_text("  ·  ".join(facts))
        self._record.set_text("Pause recording" if state.recording else "Record")
        self._record.set_enabled(state.recording is not None)

    def _recorder_fact(self) -> str:
        lost = any(
            shown.status.name.endswith("recorder: log") and shown.freshness is Freshness.LOST
            for shown in self._state.statuses()
        )
        if lost:
            return "recorder silent"
        return {None: "no recorder", True: "recording", False: "recorder paused"}[self._state.recording]

    def _show_statuses(self) -> None:
        statuses = self._state.statuses()
        names = [shown.status.name for shown in statuses]
        wanted = [
            (shown.level, _title(shown.status.name, names), self._units.convert_text(quantities_in(shown.message)),
             shown.freshness)
            for shown in statuses
        ]
        if wanted == self._shown_statuses:
            return
        self._shown_statuses = wanted
        # Rows are reused, because browsers free removed elements late and these change every second.
        with self._status_rows:
            while len(self._lines) < len(wanted):
                self._lines.append(_StatusLine())
        while len(self._lines) > len(wanted):
            self._lines.pop().delete()
        for row, status in zip(self._lines, wanted, strict=True):
            row.show(*status)

    def _show_parameters(self) -> None:
        for parameter in self._state.parameters():
            key = (parameter.node, parameter.name)
            if key not in self._inputs:
                self._inputs[key] = self._make_input(parameter)
            elif self._values[key] != parameter.value:
                self._inputs[key].set_value(parameter.value * self._display(parameter)[1])
                self._inputs[key].props["suffix"] = zero_meaning(parameter)
            self._values[key] = parameter.value

    def _display(self, parameter: LiveParameter) -> tuple[str, float]:
        """The unit that a parameter is shown in, and what an SI value is multiplied with.

        A toolface is shown in degrees, a rate of penetration in an hour.
        """
        if parameter.unit == "rad" and "tool_face" in parameter.name:
            return "deg", 180.0 / math.pi
        unit, size = _RIG_UNITS.get(parameter.unit, (parameter.unit, 1.0))
        if parameter.name == "rate_of_penetration":
            unit, size = "m/h", 3600.0
        return self._units.display_unit(unit), self._units.convert(size, unit)

    def _make_input(self, parameter: LiveParameter) -> Any:
        key = (parameter.node, parameter.name)
        unit, size = self._display(parameter)

        def change() -> None:
            value = None if field.value is None else float(field.value) / size
            if value is not None and not math.isclose(value, self._values[key], rel_tol=1e-6):
                self._send(SetParameter(*key, value))
            # The value is unknown until the node confirms it.
            self._values[key] = math.nan

        label = plain_name(parameter.name) + ("" if unit == "-" else f", {unit}")
        with self._parameter_inputs, ui.element("div"):
            field = ui.number(label, value=parameter.value * size, format="%.6g").props("dense")
            # Set as values: the text of `props` is parsed, and a name such as "a :hint=..." would be run as a script.
            field.props["data-name"] = f"parameter-{parameter.name}"
            field.props["suffix"] = zero_meaning(parameter)
            limits = f"{_plain(parameter.low * size)} to {_plain(parameter.high * size)}"
            ui.label(f"{parameter.description}. {limits} ({parameter.node})").classes("sd-help")
            field.on("blur", change).on("keydown.enter", change)
        return field


def _plain(number: float) -> str:
    """A number of at most six digits, without an exponent."""
    return format(Decimal(f"{number:.6g}"), "f")


class _Figure:
    """One number of the drilling with its name."""

    def __init__(self, name: str) -> None:
        with ui.element("div").classes("sd-figure"):
            ui.label(name).classes("sd-figure-name")
            self._value = ui.label("-").classes("sd-figure-value")

    def show(self, value: str) -> None:
        self._value.set_text(value)


class _StatusLine:
    """One status: its mark, its subject and its message."""

    def __init__(self) -> None:
        with ui.element("div").classes("sd-status") as self._row:
            self._icon = ui.icon("").style("font-size: 1.15rem")
            self._name, self._message = ui.label(), ui.label()

    def show(self, level: Level, name: str, message: str, freshness: Freshness) -> None:
        icon, colour = _MARKS[level] if freshness is not Freshness.LATE else _LATE_MARK
        self._row.classes(replace=f"sd-status sd-{freshness.value}")
        self._icon.name = icon
        self._icon.classes(replace=colour)
        self._name.set_text(name)
        self._message.set_text(message)
        self._message.classes(replace=colour if level else "")

    def delete(self) -> None:
        self._row.delete()


def _title(name: str, names: Sequence[str]) -> str:
    """The subject of a status, with its node if another node has one of the same subject, and if it is a twin's."""
    node, _, subject = name.partition(": ")
    is_unique = sum(other.endswith(f": {subject}") for other in names) == 1 and node.rpartition("/")[2] != "twin"
    return plain_name(subject if subject and is_unique else f"{subject} ({node})" if subject else name)
