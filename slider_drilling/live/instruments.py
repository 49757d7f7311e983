"""The page's instruments as one element: toolface dial, strip charts, and the string along its well."""

from __future__ import annotations

from typing import Any

from nicegui.element import Element

from slider_drilling.live.state import MAX_SAMPLES, WINDOW


class Instruments(Element, component="instruments.js", esm={"slider-drilling-live": "script"}):
    """Drawn in the browser from the frames that it gets."""

    def __init__(self, labels: dict[str, Any]) -> None:
        """Labels: of `frame.labels_json`."""
        super().__init__()
        self._props["labels"] = labels
        self._props["window"] = WINDOW
        self._props["maxSamples"] = MAX_SAMPLES

    def show_well_path(self, well_path: dict[str, Any]) -> None:
        """Draw the well path of `frame.StringView.well_path_json`."""
        self.run_method("showWellPath", well_path)

    def keep_alive(self) -> None:
        """Show the browser that the server lives, also while there is nothing to draw."""
        self.run_method("keepAlive")

    def draw(self, data: dict[str, Any]) -> None:
        """Draw one frame: samples, what a twin expects, dial, rocking and rotation."""
        self.run_method("drawFrame", data)
