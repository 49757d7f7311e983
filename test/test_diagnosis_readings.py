"""How hook load and torque are read is calibrated on every rig, and costs no simulation."""

from __future__ import annotations

import numpy as np
import pytest

from slider_drilling.diagnosis.nuisance import TOOL_FACE_OFFSET, hook_load_reading, nuisance_parameters, torque_reading
from slider_drilling.diagnosis.readings import READINGS, direction_of_block, read_hook_load, read_torque
from slider_drilling.drillstring import Commands
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import load_rig

LOAD = np.array([1e6, 1.2e6])


def test_neutral_readings_show_the_hook_load():
    neutral = {parameter.name: parameter.nominal for parameter in hook_load_reading()}
    assert np.array_equal(read_hook_load(LOAD, np.ones(2), neutral), LOAD)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"hook_load_offset": 5e3}, LOAD + 5e3),
        ({"hook_load_gain": 1.02}, 1.02 * LOAD),
        ({"sheave_friction": 3e3}, LOAD - np.array([3e3, -3e3])),
    ],
)
def test_each_reading_acts_as_named(values, expected):
    assert np.allclose(read_hook_load(LOAD, np.array([1.0, -1.0]), values), expected)


def test_direction_follows_the_block():
    time = np.arange(3.0)
    still = np.zeros(3)
    commands = Commands(time, still, still, still, np.array([-0.01, 0.0, 0.01]), still)
    assert np.allclose(direction_of_block(commands, time), [-1.0, 0.0, 1.0], atol=1e-6)


TIME = np.linspace(0.0, 60.0, 601)
TORQUE = 8e3 + 4e3 * np.sin(TIME / 3.0)


def test_neutral_readings_show_the_torque():
    neutral = {parameter.name: parameter.nominal for parameter in torque_reading()}
    assert np.array_equal(read_torque(TORQUE, TIME, neutral), TORQUE)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"torque_offset": 40.0}, TORQUE + 40.0),
        ({"torque_gain": 1.01}, 1.01 * TORQUE),
        ({"torque_delay": 0.3}, 8e3 + 4e3 * np.sin((TIME - 0.3) / 3.0)),
    ],
)
def test_each_torque_reading_acts_as_named(values, expected):
    assert np.allclose(read_torque(TORQUE, TIME, values)[5:], expected[5:])


def test_only_channels_of_the_log_have_readings():
    rig = load_rig(installed_file("config/rig.example.yaml"))

    def readings(*channels: str) -> set[str]:
        return {parameter.name for parameter in nuisance_parameters(rig, channels)} & READINGS

    of_torque = {parameter.name for parameter in torque_reading()}
    assert readings("surface_torque") == set(), "with torque alone its gain is friction"
    assert readings("surface_torque", "standpipe_pressure") == of_torque
    assert readings("surface_torque", "hook_load") == READINGS - {TOOL_FACE_OFFSET}
    assert readings("surface_torque", "hook_load", "tool_face") == READINGS
