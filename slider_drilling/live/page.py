"""The page itself: instruments, controls and interlocks, on NiceGUI."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nicegui import ui

from slider_drilling.live.frame import StringView, dial_json, rocking_json, samples_json
from slider_drilling.live.instruments import Instruments
from slider_drilling.live.page_requests import (
    PageRequest,
    RequestQueue,
    SetParameter,
    SetRecording,
    SetRocking,
    SetTarget,
)
from slider_drilling.live.state import LiveParameter, LiveState
from slider_drilling.messages.health import Level, Status

TITLE = "Slide drilling"
FRAME = 0.1  # s between frames
SLOW = 1.0  # s between looks at statuses and parameters
_MARKS = {Level.OK: ("check_circle", "sd-ok"), Level.WARN: ("warning", "sd-warn"), Level.ERROR: ("error", "sd-error")}
STYLE = Path(__file__).with_name("page.css")


def register_page(state: LiveState, desk: RequestQueue) -> None:
    """Serve the page at `/`; every browser that opens it gets a view of its own."""

    @ui.page("/", title=TITLE)
    def page() -> None:
        PageView(state, desk)


class PageView:
    """One browser's page. It holds how far it has been told, and nothing that grows."""

    def __init__(self, state: LiveState, desk: RequestQueue) -> None:
        self._state, self._desk = state, desk
        self._count = 0
        self._along: StringView | None = None
        self._told = state.last_notice
        self._shown_statuses: list[tuple[Any, ...]] = []
        self._lines: list[_StatusLine] = []
        self._inputs: dict[tuple[str, str], Any] = {}
        self._values: dict[tuple[str, str], float] = {}
        ui.add_css(STYLE)
        with ui.element("div").classes("sd-head"):
            ui.label(TITLE).classes("sd-title")
            self._facts = ui.label("waiting for the rig").classes("sd-fact").props("data-name=facts")
        self._instruments = Instruments()
        with ui.element("div").classes("sd-below"):
            self._make_controls()
            with ui.element("div").classes("sd-card"):
                ui.label("Interlocks and health").classes("sd-heading")
                self._status_rows = ui.element("div").props("data-name=statuses")
        ui.timer(FRAME, self._frame)
        ui.timer(SLOW, self._slow)

    def _make_controls(self) -> None:
        with ui.element("div").classes("sd-card"):
            ui.label("Controls").classes("sd-heading")
            with ui.element("div").classes("sd-row"):
                self._target = (
                    ui.number("new target, deg", min=-180, max=180, step=5, format="%.1f")
                    .props("dense outlined data-name=target")
                    .style("width: 9.5rem")
                )
                ui.button("Set target", on_click=self._set_target).props(
                    "dense no-caps unelevated data-name=set-target"
                )
            with ui.element("div").classes("sd-row"):
                ui.button("Start rocking", icon="play_arrow", on_click=lambda: self._ask(SetRocking(True))).props(
                    "dense no-caps outline data-name=start"
                )
                ui.button("Stop rocking", icon="stop", on_click=lambda: self._ask(SetRocking(False))).props(
                    "dense no-caps unelevated color=negative data-name=stop"
                )
                self._record = ui.button("Record", icon="fiber_manual_record", on_click=self._toggle_record).props(
                    "dense no-caps outline data-name=record"
                )
            with ui.expansion("Parameters, changed while the nodes run").classes("full-width").props("dense"):
                self._settings = ui.element("div").classes("sd-settings").props("data-name=settings")

    def _ask(self, wish: PageRequest) -> None:
        if not self._desk.put(wish):
            ui.notify("nobody takes what was asked for: the nodes do not answer", type="negative")

    def _set_target(self) -> None:
        if self._target.value is not None:
            self._ask(SetTarget(math.remainder(math.radians(self._target.value), 2.0 * math.pi)))

    def _toggle_record(self) -> None:
        self._ask(SetRecording(not self._state.recording))

    def _frame(self) -> None:
        rig = self._state.rig
        if self._along is None and rig is not None:
            self._along = StringView(rig)
            self._instruments.show_well_path(self._along.well_path_json())
        rows, self._count = self._state.samples_after(self._count)
        if not rows:
            return
        turning = self._along.rotation_json(self._state) if self._along is not None else {}
        self._instruments.draw(
            {
                "rows": samples_json(rows),
                "dial": dial_json(self._state),
                "rocking": rocking_json(self._state),
                "turning": turning,
            }
        )

    def _slow(self) -> None:
        self._show_facts()
        self._show_statuses()
        self._show_settings()
        for notice in self._state.notices_after(self._told):
            self._told = notice.number
            ui.notify(notice.text, type="positive" if notice.success else "negative", timeout=6000)

    def _show_facts(self) -> None:
        state, newest = self._state, self._state.latest_sample()
        if newest is None:
            return
        facts = [f"{newest.time:.0f} s"]
        rocking = rocking_json(state)
        if rocking["centre"] is not None and rocking["amplitude"] is not None:
            facts.append(
                f"rocking ±{rocking['amplitude']:.1f} rad about {rocking['centre']:.1f} rad"
                + (f", {rocking['period']:.0f} s" if rocking["period"] is not None else "")
            )
        if math.isfinite(state.target):
            facts.append(f"target {math.degrees(state.target):.0f} deg")
        facts.append({None: "no recorder", True: "recording", False: "recorder paused"}[state.recording])
        self._facts.set_text("  ·  ".join(facts))
        self._record.set_text("Pause recording" if state.recording else "Record")
        self._record.set_enabled(state.recording is not None)

    def _show_statuses(self) -> None:
        statuses = self._state.statuses()
        wanted = [(one.level, _title(one.name, statuses), one.message) for one in statuses]
        if wanted == self._shown_statuses:
            return
        self._shown_statuses = wanted
        # Rows are written over, not made anew: a browser lets go of elements late, and these change every second.
        with self._status_rows:
            while len(self._lines) < len(wanted):
                self._lines.append(_StatusLine())
        while len(self._lines) > len(wanted):
            self._lines.pop().delete()
        for row, (level, name, message) in zip(self._lines, wanted, strict=True):
            row.show(Level(level), name, message)

    def _show_settings(self) -> None:
        for one in self._state.parameters():
            key = (one.node, one.name)
            if key not in self._inputs:
                self._inputs[key] = self._make_input(one)
            elif self._values[key] != one.value:
                self._inputs[key].set_value(one.value)
            self._values[key] = one.value

    def _make_input(self, one: LiveParameter) -> Any:
        unit = "" if one.unit == "-" else f", {one.unit}"

        def change() -> None:
            value = field.value
            if value is not None and value != self._values[one.node, one.name]:
                self._ask(SetParameter(one.node, one.name, float(value)))
            # Until the node says otherwise, this is not its value.
            self._values[one.node, one.name] = math.nan

        with self._settings:
            field = ui.number(f"{one.name.replace('_', ' ')}{unit}", value=one.value, format="%.6g").props("dense")
            field.tooltip(f"{one.about}; {one.low:g} to {one.high:g} ({one.node})")
            field.props(f"data-name=parameter-{one.name}")
            field.on("blur", change).on("keydown.enter", change)
        return field


class _StatusLine:
    """One status: its mark, what it is about, what it says."""

    def __init__(self) -> None:
        with ui.element("div").classes("sd-status") as self._row:
            self._icon = ui.icon("").style("font-size: 1.15rem")
            self._name, self._message = ui.label(), ui.label()

    def show(self, level: Level, name: str, message: str) -> None:
        icon, colour = _MARKS[level]
        self._icon.name = icon
        self._icon.classes(replace=colour)
        self._name.set_text(name)
        self._message.set_text(message)
        self._message.classes(replace=colour if level else "")

    def delete(self) -> None:
        self._row.delete()


def _title(name: str, statuses: Sequence[Status]) -> str:
    """What a status is about, with its node where another node has one of the same."""
    node, _, what = name.partition(": ")
    alone = sum(one.name.endswith(f": {what}") for one in statuses) == 1
    return (what if what and alone else f"{what} ({node})" if what else name).replace("_", " ")
