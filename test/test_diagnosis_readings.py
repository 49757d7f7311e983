"""How the hook load is read is calibrated on every rig, and costs no simulation."""

from __future__ import annotations

import numpy as np
import pytest

from slider_drilling.diagnosis.drill_string import READINGS, direction_of_block, read_hook_load
from slider_drilling.diagnosis.nuisance import nuisance_parameters, reading_parameters
from slider_drilling.drillstring import Commands
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import load_rig

LOAD = np.array([1e6, 1.2e6])


def test_neutral_readings_show_the_hook_load():
    neutral = {parameter.name: parameter.nominal for parameter in reading_parameters()}
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


def test_logs_without_hook_load_calibrate_no_reading():
    rig = load_rig(installed_file("config/rig.example.yaml"))
    names = {parameter.name for parameter in nuisance_parameters(rig, ["surface_torque", "standpipe_pressure"])}
    assert not names & READINGS
    assert {parameter.name for parameter in nuisance_parameters(rig, ["surface_torque", "hook_load"])} >= READINGS
