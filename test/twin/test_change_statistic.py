import numpy as np
import pytest

from slider_drilling.twin.change_statistic import Wander, likeliest_change
from slider_drilling.twin.wander import THRESHOLD, WANDERS

_WANDER = Wander(0.1, 0.2, 80.0, 0.2, 2.0, 0.7)


def _series(seed, duration=600.0, window=10.0):
    """A feature that wanders as `_WANDER` says, every 5 s."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, duration, 5.0)
    kept, slow = np.exp(-5.0 / _WANDER.memory), np.empty(time.size)
    level = random.normal()
    for index in range(time.size):
        slow[index] = level
        level = kept * level + np.sqrt(1.0 - kept**2) * random.normal()
    return time, 5.0 + _WANDER.short * random.normal(size=time.size) + _WANDER.slow * slow


def _change(time, value, work=None, window=10.0):
    work = np.zeros(time.size) if work is None else work
    nothing = np.zeros((time.size, 1))
    return likeliest_change(time, value, work, np.full(time.size, window), nothing, np.eye(1), _WANDER)


@pytest.mark.parametrize("seed", range(5))
def test_step_is_found_with_its_time(seed):
    time, value = _series(seed)
    change = _change(time, value + 2.0 * np.clip((time - 400.0) / 10.0, 0.0, 1.0))
    assert change.evidence > THRESHOLD
    assert change.kind == "step"
    assert change.since == pytest.approx(400.0, abs=15.0)
    assert change.interval[0] <= 405.0 and change.interval[1] >= 390.0
    assert change.size == pytest.approx(2.0, abs=0.6)


@pytest.mark.parametrize("seed", range(5))
def test_ramp_is_called_ramp(seed):
    time, value = _series(seed)
    change = _change(time, value + np.maximum(time - 300.0, 0.0) / 60.0)
    assert change.evidence > THRESHOLD
    assert change.kind == "ramp"
    assert change.since == pytest.approx(300.0, abs=60.0)


def test_wander_alone_stays_below_threshold():
    evidence = [_change(*_series(seed)).evidence for seed in range(40)]
    assert max(evidence) < THRESHOLD
    assert np.median(evidence) < 4.0


@pytest.mark.parametrize("seed", range(5))
def test_new_level_after_an_operation_is_no_change(seed):
    time, value = _series(seed)
    work = (time > 300.0).astype(float)
    assert _change(time, value + 2.0 * work, work).evidence < THRESHOLD


def test_uncertain_parameter_explains_its_own_change():
    time, value = _series(0)
    shape = np.clip((time - 300.0) / 10.0, 0.0, 1.0)
    window, work = np.full(time.size, 10.0), np.zeros(time.size)
    change = likeliest_change(time, value + 2.0 * shape, work, window, shape[:, None], 4.0 * np.eye(1), _WANDER)
    assert change.evidence < THRESHOLD


def test_too_few_values_say_nothing():
    time, value = _series(0, duration=60.0)
    assert _change(time, value) is None


def test_every_feature_has_its_wander():
    kinds = {kind for _, kind in WANDERS}
    assert kinds == {"mean", "gain", "lag", "spread"}
