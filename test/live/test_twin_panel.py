"""The twin's part of the live page, without a browser."""

from __future__ import annotations

import pytest

from slider_drilling.live.state import LiveState
from slider_drilling.units import SI

pytest.importorskip("nicegui", reason="no NiceGUI: pip install '.[live]'")


def test_without_a_twin_its_pictures_stay_hidden() -> None:
    from nicegui import Client
    from nicegui.page import page

    from slider_drilling.live.twin_panel import TwinPanel

    with Client(page("/")):
        panel = TwinPanel(LiveState(), lambda request: None, SI, lambda parameter: ("-", 1.0))
        for _ in range(2):
            panel.update()
    assert "hidden" in panel._canvases.classes
