"""What a change adds to the twin's features, and the evidence of a detector that knows it."""

import numpy as np
import pytest

from slider_drilling.benchmarks.twin_limits import _evidence, _shown
from slider_drilling.blind.slides.case import SlideCase
from slider_drilling.drillstring import Commands
from slider_drilling.twin.change_statistic import Uncertainty
from slider_drilling.twin.feature_means import FeatureSeries

_CASE = SlideCase("torque_bias", 600.0, 0.0, "4.0 km", 1, duration=1200.0)
_KNOWN = Uncertainty(np.zeros((1, 1)), np.zeros((1, 1)))


def _series():
    time = np.arange(100.0, 1200.0, 5.0)
    still = np.zeros(time.size)
    return FeatureSeries(time, still, still, still + 70.0, still + 20.0, still + 0.5, still, still + 3.0, still + 3.0,
                         still, np.zeros((time.size, 1)))  # fmt: skip


def _added(kind):
    """What a torque reading that is 2 noise levels too high from 600 s on adds to a feature."""
    time = np.arange(0.0, 1200.0, 0.1)
    still = np.zeros_like(time)
    torque = 5000.0 * np.sin(2.0 * np.pi * time / 20.0)
    added = {"surface_torque": (np.full_like(time, 2.0), torque)}
    return _shown(_series(), ("rocking", "surface_torque", kind), Commands(time, *[still] * 5), added, _CASE)


def test_bias_shows_in_the_mean_from_its_onset_on():
    shown, time = _added("mean"), _series().time
    assert np.allclose(shown[time < 600.0], 0.0) and np.allclose(shown[time > 625.0], 2.0, atol=1e-6)


@pytest.mark.parametrize("kind", ["gain", "lag", "spread"])
def test_bias_shows_in_nothing_else(kind):
    time = _series().time
    assert np.abs(_added(kind)[time > 625.0]).max() < 1e-6


def test_evidence_of_a_known_change_grows_with_its_square_and_with_time():
    key, shown = ("rocking", "surface_torque", "mean"), _added("mean")
    early, late = (_evidence(_series(), shown, key, _KNOWN, now) for now in (700.0, 1100.0))
    assert 0.0 < early < late
    assert _evidence(_series(), 2.0 * shown, key, _KNOWN, 1100.0) == pytest.approx(4.0 * late)
    assert _evidence(_series(), shown, key, _KNOWN, 590.0) == 0.0
