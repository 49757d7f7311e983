"""The pressure of circulation that a log itself shows, and what it means for the wander of the motor's pressure."""

from __future__ import annotations

import numpy as np
import pytest
from short_well import short_rig

from slider_drilling.blind.recorder import write_sealed_log
from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.drillstring import Commands, simulate
from slider_drilling.log import read_log
from slider_drilling.log_inputs.off_bottom_pressure import off_bottom_factor, pump_runs


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
