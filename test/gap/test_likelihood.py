"""The likelihood of a discrepancy that forgets plus white noise, against a dense covariance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slider_drilling.gap.evidence.likelihood import (
    Discrepancy,
    fit_discrepancy,
    memory_grid,
    neg2_log_likelihood,
    whiten,
)


def dense(time, size, memory):
    return size**2 * np.exp(-np.abs(np.subtract.outer(time, time)) / memory) + np.eye(time.size)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 30.0), st.floats(0.05, 60.0), st.floats(0.0, 1.0))
def test_filter_equals_dense_covariance(seed, size, memory, uneven):
    generator = np.random.default_rng(seed)
    gaps = np.where(generator.random(80) < uneven**3, generator.uniform(0.02, 3.0, 80), 0.1)
    gaps[0] = 0.0
    time, residual = np.cumsum(gaps), generator.normal(0.0, 3.0, 80)
    covariance = dense(time, size, memory)
    expected = residual @ np.linalg.solve(covariance, residual) + np.linalg.slogdet(covariance)[1]
    found = neg2_log_likelihood(residual, gaps, np.array([size, 0.0]), np.array([memory, 1.0]))
    assert found == pytest.approx([expected, residual @ residual], rel=1e-6, abs=1e-6)


def test_whitening_removes_the_covariance():
    gaps = np.full(60, 0.5)
    gaps[0] = 0.0
    covariance = dense(np.cumsum(gaps), 2.0, 4.0)
    white, price = whiten(np.linalg.cholesky(covariance).T, gaps, Discrepancy(2.0, 4.0))
    assert white.T @ white == pytest.approx(np.eye(60), abs=1e-9)
    assert price.sum() == pytest.approx(np.linalg.slogdet(covariance)[1])


def test_discrepancy_is_found_and_absent_in_noise():
    generator = np.random.default_rng(3)
    gaps = np.full(4000, 0.1)
    noise = generator.normal(size=4000)
    cost, found = fit_discrepancy(noise, gaps, memory_grid(gaps, 20.0))
    assert cost == pytest.approx(noise @ noise, abs=12.0)
    kept = np.exp(-0.1 / 3.0)
    slow = np.zeros(4000)
    for k in range(1, 4000):
        slow[k] = kept * slow[k - 1] + np.sqrt(1.0 - kept**2) * generator.normal(0.0, 2.0)
    _, found = fit_discrepancy(noise + slow, gaps, memory_grid(gaps, 20.0))
    assert 1.2 < found.size < 3.5
    assert 1.0 < found.memory < 9.0


def test_bias_cannot_hide_in_the_discrepancy():
    """A bias cannot hide in the discrepancy: two numbers that follow it cost hundreds of ``-2 log p``."""
    gaps = np.full(4000, 0.1)
    noise = np.random.default_rng(1).normal(size=4000)
    without, _ = fit_discrepancy(noise, gaps, memory_grid(gaps, 20.0))
    biased, _ = fit_discrepancy(noise + 2.0, gaps, memory_grid(gaps, 20.0))
    assert biased - without > 100.0
