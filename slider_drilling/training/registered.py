"""Registers `slider_drilling/Slide-v0` with gymnasium, one slide or many.

``gymnasium.make("slider_drilling.training.registered:slider_drilling/Slide-v0")`` imports this module by itself.
"""

from __future__ import annotations

from typing import Any

import gymnasium

from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import load_rig
from slider_drilling.slide_scenarios.drawn import draw_slide
from slider_drilling.training.draw import draw_rigs
from slider_drilling.training.slide_environment import SlideEnvironment
from slider_drilling.training.vector_environment import EpisodeOptions, VectorSlideEnvironment

ENVIRONMENT_ID = "slider_drilling/Slide-v0"


def make_slide(
    number: int = 0, seed: int = 0, elements: int = 40, duration: float = 900.0, render_mode: None = None
) -> SlideEnvironment:
    """Slide `number` of a campaign of this seed (`closed-loop --campaign`)."""
    base = load_rig(installed_file("config/rig.example.yaml"))
    return SlideEnvironment(draw_slide(number, seed, base, duration), elements)


def make_slides(
    num_envs: int = 1, seed: int = 0, elements: int = 40, duration: float = 900.0, **drawing: Any
) -> VectorSlideEnvironment:
    """As many slots as asked, on as many drawn rigs (at most 256); drawing: as in `draw_rigs`."""
    base = load_rig(installed_file("config/rig.example.yaml"))
    options = {"effects": True, "foreign": 0.0, **drawing}
    rigs = draw_rigs(min(num_envs, 256), base, seed, duration, **options)
    return VectorSlideEnvironment(num_envs, rigs, elements, EpisodeOptions(duration))


gymnasium.register(
    ENVIRONMENT_ID, entry_point=f"{__name__}:make_slide", vector_entry_point=f"{__name__}:make_slides",
    order_enforce=False, disable_env_checker=True,
)  # fmt: skip
