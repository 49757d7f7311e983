"""Noise of the MWD, learnt from its own readings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slider_drilling.control.estimation.mwd_noise import MwdNoise

DEGREE = math.radians(1.0)


def learnt(noise: float, walk: float = 0.0, share: float = 1.0, seed: int = 3) -> float:
    """Standard deviation (deg) after 100 samples, for noise and walk from sample to sample (deg)."""
    random = np.random.default_rng(seed)
    estimate, true, expected = MwdNoise(DEGREE**2), 0.0, 0.0
    for _ in range(100):
        expected += 0.1
        true += share * 0.1 + walk * DEGREE * random.normal()
        estimate.observe(math.remainder(true + noise * DEGREE * random.normal(), math.tau), expected)
    return math.sqrt(estimate.variance) / DEGREE


def test_noise_is_learnt() -> None:
    assert np.mean([learnt(8.0, seed=seed) for seed in range(10)]) == pytest.approx(8.0, rel=0.25)


@pytest.mark.parametrize(("walk", "share"), [(6.0, 1.0), (0.0, 0.3)])
def test_walk_and_wrong_model_are_no_noise(walk: float, share: float) -> None:
    assert learnt(1.0, walk, share) < 3.0


def test_less_noise_than_in_the_rig_file_is_not_believed() -> None:
    assert learnt(0.0) == 1.0


def test_wrong_sample_is_no_noise() -> None:
    estimate = MwdNoise(DEGREE**2)
    for k in range(100):
        estimate.observe(2.0 if k % 9 == 0 else 0.0, 0.0)
    assert estimate.variance == pytest.approx(DEGREE**2)
