"""The pressure of circulation that a log itself shows, and what it means for the wander of the motor's pressure."""

from __future__ import annotations

import numpy as np
import pytest
from short_well import short_rig

from slider_drilling.blind.recorder import write_sealed_log
from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.channel_wander import BIT_TORQUE_WANDER, FRICTION_WANDER, channel_wander
from slider_drilling.drillstring import Commands, simulate
from slider_drilling.files.installed_files import installed_file
from slider_drilling.gap.model import Channel
from slider_drilling.log import read_log
from slider_drilling.log_inputs.off_bottom_pressure import off_bottom_factor, pump_runs
from slider_drilling.rig import load_rig
from slider_drilling.wellbore.static_loads import static_loads


def test_lowest_pressures_are_those_off_bottom():
    circulation = np.full(1000, 2e7)
    pressure = 0.95 * circulation + np.where(np.arange(1000) < 100, 0.0, 1e6)
    assert off_bottom_factor(pressure, circulation) == pytest.approx(0.95)


def test_stopped_pump_does_not_run():
    assert pump_runs(np.array([2e7, 1.5e7, 5e6, 0.0])).tolist() == [True, True, False, False]
    assert not pump_runs(np.zeros(3)).any()


@pytest.mark.parametrize("stopped", [False, True])
def test_circulation_alone_does_not_wander(tmp_path, stopped):
    """A pump that stops leaves no pressure of the motor behind."""
    rig, time = short_rig(), np.arange(0.0, 60.0, 0.1)
    still, pump = np.zeros_like(time), np.where(stopped & (time > 40.0), 0.0, 12.3)
    turning = Commands(time, 5.0 * (1.0 - np.cos(time)), 5.0 * np.sin(time), still, still, pump)
    path = tmp_path / "run.mcap"
    write_sealed_log(path, rig, turning, simulate(rig, turning, 30), np.random.default_rng(4))
    (run,) = build_model([read_log(path)], rig).model.runs
    pressure = next(channel for channel in run.channels if channel.name == "standpipe_pressure")
    assert pressure.wander < 2e-4 * rig.circulating_pressure


def test_pressure_wanders_with_friction_along_a_string_that_slides():
    """A string that rotates one way brings its weight to the bit."""
    rig, time = load_rig(installed_file("config/rig.example.yaml")), np.arange(0.0, 200.0, 0.1)
    lowered = -0.003 * time
    pump, still = np.full_like(time, 12.3), np.zeros_like(time)
    wander = {}
    for name, speed in (("slides", still), ("rotates", still + 5.0)):
        commands = Commands(time, speed * time, speed, lowered, still - 0.003, pump)
        measured = np.where(time < 10.0, 0.0, 1.5e6) + rig.circulation_at(pump)
        channel = Channel("standpipe_pressure", time, measured, "Pa", declared_noise=4e4)
        wander[name] = channel_wander(channel, rig, commands)
    drag = static_loads(rig).hook_load - static_loads(rig, axial_speed=1.0).hook_load
    of_weight = FRICTION_WANDER * drag * rig.bit.lever / rig.motor.torque_per_pressure
    of_bit = BIT_TORQUE_WANDER * 1.5e6
    assert wander["slides"] == pytest.approx(np.hypot(of_bit, of_weight), rel=0.05)
    assert wander["rotates"] == pytest.approx(np.hypot(of_bit, np.sqrt(0.1) * of_weight), rel=0.05)
