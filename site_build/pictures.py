"""The site's pictures, made anew by every build: a slide over a cuttings bed that its rig file does not know."""

from __future__ import annotations

import slider_drilling as sd
from slider_drilling.analysis.torque_drag import hook_load_chart, torque_chart
from slider_drilling.diagnosis.replay import replay
from slider_drilling.diagnosis.replay_page import replay_page
from slider_drilling.log.run_page import log_chart
from slider_drilling.pages import Chart, Page
from slider_drilling.pages.png import render_png
from slider_drilling.paper_studies.catalogue import run_study
from slider_drilling.units import FIELD, SI
from slider_drilling.wellbore.broomstick import broomstick

BED = "cuttings_bed:factor=4,top=2700,bottom=3200"
CONTROLLER = "slider_drilling.control:SlideController"


def pictures() -> dict[str, bytes]:
    """Name -> PNG."""
    rig = sd.load_rig()
    planted = sd.with_effect(rig, BED)
    log = sd.simulate(planted, CONTROLLER, 300.0, nominal=rig).log
    sticks = [broomstick(rig, friction) for friction in (None, 0.2, 0.25, 0.3)]
    regimes = run_study("wear_modes")
    return {
        "slide.png": render_png((log_chart(log),), SI, "A slide over a bed of cuttings"),
        "replay_nominal.png": _overlay(replay_page(log, replay(log, rig), SI), "Simulated without the bed"),
        "replay_planted.png": _overlay(replay_page(log, replay(log, planted), SI), "Simulated with the bed"),
        "broomstick.png": render_png((hook_load_chart(sticks), torque_chart(sticks)), SI, "Example well"),
        "broomstick_field.png": render_png((hook_load_chart(sticks), torque_chart(sticks)), FIELD, "Example well"),
        "asperity.png": render_png((regimes.figures[0], regimes.figures[-1]), SI),
    }


def _overlay(page: Page, title: str) -> bytes:
    """Pressure and toolface of a replay: measured, simulated and what is between them."""
    (figure,) = (item for section in page.sections for item in section.items if isinstance(item, Chart))
    return render_png((Chart(figure.title, figure.x_label, (*figure.panels[2:4], *figure.panels[-2:])),), SI, title)
