"""The twin's part of the page: gap, changes, calibrated parameters, and two buttons."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui
from nicegui.element import Element

from slider_drilling.live.calibrated_parameters import CalibratedParameter, proposed_changes
from slider_drilling.live.freshness import Freshness
from slider_drilling.live.page_requests import DiagnoseNow, PageRequest, SetParameter
from slider_drilling.live.state import LiveParameter, LiveState, zero_meaning
from slider_drilling.live.twin_frame import answer_text, detection_label, twin_json
from slider_drilling.plain_names import plain_name
from slider_drilling.units import Units


class TwinCanvases(Element, component="twin_panel.js", esm={"slider-drilling-live": "script"}):
    """Drawn in the browser from `twin_frame.twin_json`."""

    def show(self, data: dict[str, Any]) -> None:
        """Draw it."""
        self.run_method("show", data)


class TwinPanel:
    """One browser's view of the twin.

    Args:
        state: What nodes say.
        send: Sends a request to the nodes.
        units: Of the page.
        display: Unit and factor in which the page shows a parameter.
    """

    def __init__(
        self, state: LiveState, send: Callable[[PageRequest], None], units: Units,
        display: Callable[[LiveParameter], tuple[str, float]],
    ) -> None:  # fmt: skip
        self._state, self._send, self._units, self._display = state, send, units, display
        self._shown = -1
        with ui.element("div").classes("sd-card"):
            with ui.element("div").classes("sd-row"):
                ui.label("Twin").classes("sd-heading").style("margin: 0")
                self._fact = ui.label("").classes("sd-fact").props("data-name=twin")
                self._diagnose = ui.button("Diagnose now", icon="troubleshoot", on_click=lambda: send(DiagnoseNow()))
                self._diagnose.props("dense no-caps outline data-name=diagnose").classes("sd-no-print")
                self._use = ui.button("Use calibrated rig", icon="tune", on_click=self._confirm)
                self._use.props("dense no-caps outline data-name=use-rig").classes("sd-no-print")
            self._answer = ui.label("").props("data-name=answer").style("margin-bottom: .5rem")
            self._canvases = TwinCanvases()
        self._dialog = ui.dialog().props("data-name=confirm")

    def update(self) -> None:
        """Show what is new."""
        twin, latest = self._state.twin, self._state.latest_sample()
        freshness = twin.freshness()
        self._fact.set_text(self._fact_text(freshness))
        shown = Freshness.FRESH if freshness is None else freshness
        self._fact.classes(replace=f"sd-fact sd-{shown.value}")
        # Not replaced: the class that hides it would go, too.
        self._canvases.classes(f"sd-{shown.value}", remove=" ".join(f"sd-{other.value}" for other in Freshness))
        # Without a twin nothing looks for a gap: an empty strip "no change detected" would say that none is there.
        for part in (self._diagnose, self._use, self._canvases):
            part.set_visibility(freshness is not None)
        self._answer.set_text(answer_text(twin, self._units))
        self._answer.set_visibility(twin.answer() is not None and freshness is not Freshness.LOST)
        if twin.revision != self._shown:
            self._shown = twin.revision
            self._canvases.show(twin_json(twin, 0.0 if latest is None else latest.time, self._units))

    def _fact_text(self, freshness: Freshness | None) -> str:
        """The twin's state in one line."""
        twin = self._state.twin
        if freshness is None:
            return "no twin runs beside this rig"
        if freshness is Freshness.LOST:
            return f"no status for {twin.age():.0f} s"
        said = twin.diagnosis()
        open_ones = [one for one in twin.detections() if not one.get("ended")]
        state = str(said.get("state", "watching")) + (f": {said['note']}" if said.get("note") else "")
        if not open_ones:
            return f"{state}; no change" if twin.compared else state
        many = f"{len(open_ones)} changes, the last" if len(open_ones) > 1 else "one change"
        return f"{state}; {many}: {detection_label(open_ones[-1], self._units)}"

    def _confirm(self) -> None:
        """Ask before the controller's parameters are changed."""
        changes, remarks = proposed_changes(self._state)
        self._dialog.clear()
        with self._dialog, ui.card():
            ui.label("Set the controller's parameters to what the twin has calibrated?").classes("sd-heading")
            for change in changes:
                ui.label(self._change_text(change)).props("data-name=change")
                ui.label(change.consequence).classes("sd-help")
            for remark in remarks:
                ui.label(remark).classes("sd-help")
            with ui.element("div").classes("sd-row"):
                use = ui.button("Use them", on_click=lambda: self._use_changes(changes))
                use.props("dense no-caps unelevated data-name=confirm-use").set_enabled(bool(changes))
                ui.button("Cancel", on_click=self._dialog.close).props("dense no-caps outline")
        self._dialog.open()

    def _change_text(self, change: CalibratedParameter) -> str:
        unit, size = self._display(change.parameter)
        suffix = "" if unit == "-" else f" {unit}"
        now = zero_meaning(change.parameter) or f"{change.parameter.value * size:.4g}{suffix}"
        return f"{plain_name(change.parameter.name)}: {now} becomes {change.value * size:.4g}{suffix}"

    def _use_changes(self, changes: list[CalibratedParameter]) -> None:
        self._dialog.close()
        for change in changes:
            self._send(SetParameter(change.parameter.node, change.parameter.name, change.value))
