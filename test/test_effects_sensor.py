"""Effects on the reading of the surface torque: the law of each, and what it leaves unchanged."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from steady import EXAMPLE, PUMP, commands, with_effect

from slider_drilling.diagnosis.replay import replay
from slider_drilling.drillstring import Commands, InitialState, simulate
from slider_drilling.drillstring.simulated_log import write_simulated
from slider_drilling.effects import TorqueAtMotor, TorqueSensorBias, TorqueSensorGain, TorqueSensorLag
from slider_drilling.log import read_log


def test_torque_sensor_lag_is_first_order():
    run = commands(30.0, speed=1.0, rise=0.5)
    lag = 0.8
    fine = dataclasses.replace(EXAMPLE, sensors=dataclasses.replace(EXAMPLE.sensors, rate=100.0))
    dense = run.resampled(np.arange(0.0, 30.0, 0.01))
    true = simulate(fine, dense, 40)
    sensed = simulate(with_effect(fine, torque_sensor_lag=TorqueSensorLag(lag)), dense, 40)
    gain = 1.0 - math.exp(-0.01 / lag)
    filtered = np.zeros_like(true.surface_torque)
    for k in range(1, len(filtered)):
        middle = 0.5 * (true.surface_torque[k] + true.surface_torque[k - 1])
        filtered[k] = filtered[k - 1] + gain * (middle - filtered[k - 1])
    assert np.sqrt(np.mean((sensed.surface_torque - filtered) ** 2)) < 0.01 * np.std(true.surface_torque)
    assert np.array_equal(sensed.tool_face, true.tool_face)


def test_torque_sensor_bias_changes_nothing_else():
    run = commands(10.0, speed=1.0, block_speed=0.003)
    true = simulate(EXAMPLE, run, 40)
    biased = simulate(with_effect(EXAMPLE, torque_sensor_bias=TorqueSensorBias(250.0)), run, 40)
    assert biased.surface_torque - true.surface_torque == pytest.approx(250.0)
    assert np.array_equal(biased.hook_load, true.hook_load)


def test_torque_sensor_gain_changes_nothing_else():
    run = commands(10.0, speed=1.0, block_speed=0.003)
    true = simulate(EXAMPLE, run, 40)
    read = simulate(with_effect(EXAMPLE, torque_sensor_gain=TorqueSensorGain(-0.2)), run, 40)
    assert read.surface_torque == pytest.approx(0.8 * true.surface_torque, rel=1e-12, abs=1e-9)
    assert np.ptp(true.surface_torque) > 1000.0
    for name in ("hook_load", "tool_face", "standpipe_pressure"):
        assert np.array_equal(getattr(read, name), getattr(true, name))


def test_torque_reading_order_is_gain_bias_lag():
    """Of a wound string: the first reading is settled, so the lag must begin at the scaled torque."""
    run, start = commands(10.0, speed=1.0), InitialState(twist=-3.0)
    lagging = with_effect(EXAMPLE, torque_sensor_lag=TorqueSensorLag(0.7))
    gain, bias = 0.25, 300.0
    all_three = with_effect(
        lagging, torque_sensor_gain=TorqueSensorGain(gain), torque_sensor_bias=TorqueSensorBias(bias)
    )
    lagged, read = (simulate(rig, run, 40, start).surface_torque for rig in (lagging, all_three))
    assert abs(lagged[0]) > 500.0
    assert read == pytest.approx((1.0 + gain) * lagged + bias, rel=1e-9)


def test_gain_scales_torque_at_motor():
    run = commands(10.0, speed=1.0, rise=2.0)
    at_motor = with_effect(EXAMPLE, torque_at_motor=TorqueAtMotor(800.0, 200.0))
    true, read = (
        simulate(rig, run, 40).surface_torque
        for rig in (at_motor, with_effect(at_motor, torque_sensor_gain=TorqueSensorGain(0.1)))
    )
    assert read == pytest.approx(1.1 * true, rel=1e-9)


def test_torque_at_motor_includes_inertia_and_friction():
    """Speed up at a constant rate, hold, slow down: inertia times the rate, and friction against the motion."""
    time = np.arange(0.0, 24.0, 0.05)
    speed = np.interp(time, [0.0, 2.0, 6.0, 12.0, 20.0, 24.0], [0.0, 0.0, 4.0, 4.0, -4.0, -4.0])
    angle = np.concatenate([[0.0], np.cumsum(0.025 * (speed[1:] + speed[:-1]))])
    run = Commands(time, angle, speed, 0.0 * time, 0.0 * time, PUMP + 0.0 * time)
    true = simulate(EXAMPLE, run, 40)
    read = simulate(with_effect(EXAMPLE, torque_at_motor=TorqueAtMotor(1500.0, 300.0)), run, 40)
    added = read.surface_torque - true.surface_torque
    assert added[time < 2.0] == pytest.approx(0.0, abs=1e-9)
    assert added[(time > 3.0) & (time < 5.9)] == pytest.approx(1500.0 + 300.0, abs=5.0)
    assert added[(time > 7.0) & (time < 11.9)] == pytest.approx(300.0, abs=1.0)
    assert added[(time > 13.0) & (time < 15.2)] == pytest.approx(-1500.0 + 300.0, abs=5.0)
    assert added[(time > 16.9) & (time < 19.9)] == pytest.approx(-1500.0 - 300.0, abs=5.0)
    assert np.array_equal(read.tool_face, true.tool_face)


def test_drive_inertia_is_found_despite_noisy_speed(tmp_path):
    """Differences of 50 Hz samples with 0.01 rad/s of noise are 0.5 kN m of 1500 kg m2."""
    time = np.arange(0.0, 24.0, 0.02)
    rate = 2.0 * np.pi / 8.0
    angle, speed, still = -8.0 * np.cos(rate * time), 8.0 * rate * np.sin(rate * time), 0.0 * time
    run = Commands(time, angle, speed, still, still, PUMP + still)
    rig = with_effect(EXAMPLE, torque_at_motor=TorqueAtMotor(1500.0, 0.0))
    read = simulate(rig, run, 40)
    noise = np.random.default_rng(2).normal(0.0, 0.01, time.size)
    noisy = dataclasses.replace(run, top_drive_speed=speed + noise)
    write_simulated(tmp_path / "run.mcap", rig, noisy, read, 1.7e9, "test")
    log = read_log(tmp_path / "run.mcap")
    assert replay(log, rig, elements=40).channels["surface_torque"].rms < 150.0
    assert np.std(1500.0 * np.gradient(noise, time)) > 400.0
