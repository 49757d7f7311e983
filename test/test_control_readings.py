"""Sensors that repeat their reading, jump, or have a wrong gain."""

import math

import numpy as np
import pytest

from slider_drilling.control.estimation.repeated_reading import RepeatedReading
from slider_drilling.control.interlocks.drive_following import DriveFollowing

DEG = math.radians(1.0)


@pytest.mark.parametrize("resolution", [0.0, DEG, 2.0 * DEG])
def test_noisy_reading_at_rest_is_not_stuck(resolution):
    random, readings = np.random.default_rng(1), RepeatedReading(1.3 * DEG, resolution)
    for k, reading in enumerate(1.3 * DEG * random.normal(size=5000)):
        readings.update(float(np.round(reading / resolution) * resolution) if resolution else reading, 12.0 * k)
        assert not readings.stuck


@pytest.mark.parametrize(("resolution", "most"), [(0.0, 2), (DEG, 16), (2.0 * DEG, 25)])
def test_reading_repeated_too_often_is_stuck(resolution, most):
    readings = RepeatedReading(1.3 * DEG, resolution)
    readings.update(0.3, 0.0)
    for k in range(most):
        readings.update(0.5, 12.0 * (k + 1))
    assert readings.stuck and readings.since == 12.0
    readings.update(0.6, 1e3)
    assert not readings.stuck


def test_sensor_without_noise_may_repeat():
    readings = RepeatedReading(0.0, 2.0 * DEG)
    for k in range(1000):
        readings.update(0.5, float(k))
    assert not readings.stuck


def lower(drives, seconds, gain=1.0, jump=0.0):
    """Lower at 9 m/h; what the block shows."""
    position = drives._position if math.isfinite(drives._position) else 0.0
    for k in range(round(10 * seconds)):
        position += gain * 0.1 * 0.0025 + (jump if k == 100 else 0.0)
        drives.update_block(position, 0.0025, 0.1)


@pytest.mark.parametrize(("gain", "jump", "says"), [(1.0, 0.0, ""), (1.0, -0.5, "jumped by -0.50 m"),
                                                    (0.8, 0.0, "shows 80% of"), (1.7, 0.0, "shows 170% of")])
def test_lying_block_position_is_named(gain, jump, says):
    drives = DriveFollowing()
    lower(drives, 300.0, gain, jump)
    assert (says in drives.block_fault) if says else not drives.block_fault


def test_jump_of_the_block_is_forgotten():
    drives = DriveFollowing()
    lower(drives, 300.0, jump=0.5)
    assert drives.block_fault
    lower(drives, 700.0)
    assert not drives.block_fault


@pytest.mark.parametrize(("error", "follows"), [(lambda t: 1.5 * math.sin(t), True), (lambda t: 1.0, False)])
def test_drive_off_its_reference_on_average_is_named(error, follows):
    drives = DriveFollowing()
    for k in range(3000):
        drives.update_drive(error(0.1 * k), 0.1)
    assert drives.drive_follows == follows
