"""Scores controllers on drawn rigs, many at once: the slides and scores of a campaign, also on foreign plants."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from slider_drilling.control.controller_loader import checked_step, set_tool_face_target
from slider_drilling.control.interface import Controller
from slider_drilling.drillstring.kernel_arrays import CHANNELS, Array
from slider_drilling.rig import Rig
from slider_drilling.slide_scenarios.campaign import noise_seed
from slider_drilling.slide_scenarios.score import SlideScore, score_slide
from slider_drilling.slide_scenarios.trace import SlideTrace
from slider_drilling.training.drawn_rigs import DrawnRig, assemble_rigs
from slider_drilling.training.slots import RigSlots

_TRUE = ("tool_face", "surface_torque", "weight_on_bit", "rate_of_penetration", "bit_depth", "differential_pressure")


def score_controller(
    build: Callable[[Rig], Controller], slides: Sequence[DrawnRig], seed: int = 0, elements: int = 60
) -> list[SlideScore]:
    """Scores of one controller, a slide each.

    Slide k has target, start and noise of slide k of a campaign of this seed: without foreign structure its score is
    that of ``closed-loop --campaign``.

    Args:
        build: Makes the controller from a rig file.
        slides: Of one duration and rate of the sensors, each with one toolface target (`draw.draw_rigs`).
        seed: Of the campaign.
        elements: Of each string.

    Raises:
        InputError: The controller fails, or the rigs' sensors differ in rate.
    """
    scenarios = [slide.scenario for slide in slides]
    duration = scenarios[0].duration
    slots = RigSlots(assemble_rigs(slides, elements, duration), len(slides), duration, 1, None)
    every = np.arange(len(slides))
    noise = np.array([noise_seed(seed, number) for number in range(len(slides))])
    slots.start(every, every, np.array([scenario.start_twist for scenario in scenarios]), noise)
    controllers = [build(scenario.assumed_rig()) for scenario in scenarios]
    targets = [math.radians(scenario.target_at(0.0)) for scenario in scenarios]
    for controller, target in zip(controllers, targets, strict=True):
        set_tool_face_target(controller, target)
    steps = round(duration / slots.rigs.interval)
    truth, angles = np.empty((steps, len(slides), len(CHANNELS))), np.empty((steps, len(slides)))
    moving = np.ones(len(slides), dtype=bool)
    for step in range(steps):
        slots.step(moving, _commands(controllers, slots), 1, absolute=True)
        truth[step], angles[step] = slots.records.truth, slots.records.readings[:, 3]
    time: Array = np.asarray(slots.rigs.interval * np.arange(1, steps + 1))
    return [
        score_slide(scenario, _trace(time, targets[k], truth[:, k], angles[:, k]))
        for k, scenario in enumerate(scenarios)
    ]


def _commands(controllers: Sequence[Controller], slots: RigSlots) -> Array:
    given = (checked_step(controller, slots.measurements(k)) for k, controller in enumerate(controllers))
    return np.array([(c.top_drive_angle, c.top_drive_speed, c.block_speed, c.pump_speed) for c in given])


def _trace(time: Array, target: float, truth: Array, angle: Array) -> SlideTrace:
    true = {name: truth[:, CHANNELS.index(name)] for name in _TRUE}
    return SlideTrace(time=time, target=np.full_like(time, target), top_drive_angle=angle, events=(), **true)
