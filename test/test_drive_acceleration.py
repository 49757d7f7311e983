"""The acceleration of a top drive, from a speed that was measured."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slider_drilling.log_inputs.drive_acceleration import drive_acceleration


def strokes(rate: float, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, measured speed and true acceleration of a drive that rocks smoothly."""
    time = np.arange(0.0, 60.0, 1.0 / rate)
    pulse = 2.0 * np.pi / 9.0
    speed = 4.0 * np.sin(pulse * time) + np.random.default_rng(3).normal(0.0, noise, time.size)
    return time, speed, 4.0 * pulse * np.cos(pulse * time)


def inside(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error[5:-5] ** 2)))


@pytest.mark.parametrize("rate", [10.0, 50.0])
def test_acceleration_of_noiseless_speed_is_its_slope(rate):
    time, speed, true = strokes(rate)
    assert inside(drive_acceleration(time, speed) - true) < 0.01


def test_acceleration_rejects_noise():
    """At 50 Hz differences of a speed with 0.01 rad/s of noise are off by 0.35 rad/s2; the drive's own peak is 2.8."""
    time, speed, true = strokes(50.0, 0.01)
    assert inside(np.gradient(speed, time) - true) > 0.3
    assert inside(drive_acceleration(time, speed) - true) < 0.06


def test_noiseless_corners_are_kept():
    """A drive that is switched from one constant acceleration to another, at a twentieth of a second."""
    time = np.arange(0.0, 30.0, 0.05)
    true = np.where(time % 10.0 < 5.0, 2.0, -2.0)
    speed = np.concatenate([[0.0], np.cumsum(0.05 * true[:-1])])
    away = np.minimum(time % 5.0, 5.0 - time % 5.0) > 0.2
    assert np.abs(drive_acceleration(time, speed) - true)[away].max() < 0.1


def test_uneven_and_few_samples_work():
    time, speed, true = strokes(50.0)
    kept = np.sort(np.random.default_rng(1).choice(time.size, 1500, replace=False))
    assert inside(drive_acceleration(time[kept], speed[kept]) - true[kept]) < 0.05
    assert drive_acceleration(time[:1], speed[:1]) == pytest.approx([0.0])
    assert drive_acceleration(np.arange(4.0), 3.0 * np.arange(4.0)) == pytest.approx(3.0 * np.ones(4))


def test_long_records_use_their_busiest_part():
    time = np.arange(0.0, 120.0, 0.02)
    speed = np.where(time > 100.0, np.sin(2.0 * np.pi * time), 0.0)
    true = np.where(time > 100.0, 2.0 * np.pi * np.cos(2.0 * np.pi * time), 0.0)
    error = drive_acceleration(time, speed) - true
    assert np.abs(error[(time > 100.2) & (time < 119.8)]).max() < 0.1


@given(
    st.lists(st.floats(0.001, 2.0), min_size=1, max_size=60),
    st.randoms(use_true_random=False),
    st.sampled_from([0.0, 1e-9, 1.0, 1e4]),
)
def test_acceleration_is_always_finite(gaps, random, size):
    time = np.cumsum(gaps)
    speed = np.array([size * random.uniform(-1.0, 1.0) for _ in gaps])
    found = drive_acceleration(time, speed)
    assert found.shape == time.shape
    assert np.isfinite(found).all()
