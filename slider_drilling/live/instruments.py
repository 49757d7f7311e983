"""The instruments of the page as one element: dial, strips, and the string along its hole."""

from __future__ import annotations

from typing import Any

from nicegui.element import Element

from slider_drilling.live.state import MAX_SAMPLES, WINDOW


class Instruments(Element, component="instruments.js", esm={"slider-drilling-live": "script"}):
    """Drawn in the browser from the frames that it is given."""

    def __init__(self) -> None:
        super().__init__()
        self._props["window"] = WINDOW
        self._props["most"] = MAX_SAMPLES

    def show_well_path(self, hole: dict[str, Any]) -> None:
        """The hole's course; see `frame.Along.hole_json`."""
        self.run_method("begin", hole)

    def draw(self, data: dict[str, Any]) -> None:
        """One frame: rows, dial, rocking and turning."""
        self.run_method("frame", data)
