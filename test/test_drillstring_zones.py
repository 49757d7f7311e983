"""The three zones: the closed form against itself in the simplest hole, and against a rocked string."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from slider_drilling.drillstring import Commands, Plant
from slider_drilling.drillstring.zones_from_motion import friction_torque, zones_from_motion
from slider_drilling.rig import load_rig
from slider_drilling.wellbore.zones import zones_in_closed_form

RIG = load_rig(Path(__file__).parents[1] / "config" / "rig.example.yaml")


def rocked(amplitude: float, period: float, elements: int = 200):
    """Plant, rotation (m, n) and torque (m, n) of the third slow cycle off bottom, and its surface torques."""
    plant = Plant(RIG, elements, interval=period / 100.0)
    time = np.linspace(0.0, 3.0 * period, 301)
    rate = 2.0 * math.pi / period
    rise = np.minimum(time / period, 1.0)
    angle = amplitude * rise * np.sin(rate * time)
    still = np.zeros_like(time)
    commands = Commands(time, angle, np.gradient(angle, time), still, still, still)
    names = [field.name for field in dataclasses.fields(Commands)]
    rotation, torque, surface = [], [], []
    for k in range(len(time)):
        response = plant.advance(Commands(*(getattr(commands, name)[k : k + 1] for name in names)))
        if k >= 200:
            profile = plant.profile()
            rotation.append(profile.rotation)
            torque.append(profile.torque)
            surface.append(response.surface_torque[0])
    return plant, np.array(rotation), np.array(torque), np.array(surface)


def test_uniform_horizontal_pipe_by_hand():
    plant = Plant(RIG)
    plant.advance(Commands(*(np.zeros(1) for _ in range(6))))
    profile = plant.profile()
    per_metre = 2.0
    zones = zones_in_closed_form(profile.length, per_metre * profile.length, 1000.0, 300.0)
    assert zones.rocked_to == pytest.approx(500.0)
    assert zones.reactive_from == pytest.approx(4000.0 - 150.0)
    assert zones.static_length == pytest.approx(3350.0)


def test_excess_torque_leaves_no_static_zone():
    plant = Plant(RIG)
    plant.advance(Commands(*(np.zeros(1) for _ in range(6))))
    profile = plant.profile()
    zones = zones_in_closed_form(profile.length, 0.1 * profile.length, 1e4, 1e4)
    assert (zones.rocked_to, zones.reactive_from, zones.static_length) == (4000.0, 0.0, 0.0)


@pytest.mark.parametrize("amplitude", [6.0, 10.0, 14.0])
def test_slow_rocking_reaches_closed_form_depth(amplitude):
    plant, rotation, torque, surface = rocked(amplitude, period=120.0)
    profile = plant.profile()
    predicted = zones_in_closed_form(profile.length, friction_torque(plant, profile), 0.5 * np.ptp(surface), 1.0)
    measured = zones_from_motion(profile.measured_depth, rotation, torque, 1.0)
    assert measured.rocked_to == pytest.approx(predicted.rocked_to, rel=0.03)
