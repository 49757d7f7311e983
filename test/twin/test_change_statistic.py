from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.benchmarks.twin_wander import fit_wander, largest_evidence, threshold
from slider_drilling.twin.change_statistic import FeatureSeries, Thresholds, Uncertainty, Wander, likeliest_change
from slider_drilling.twin.wander import WANDERS, parameter_wanders, wander_of

_NEEDED = 12.0
_WANDER = Wander(
    0.1, 4.0, 0.2, 80.0, 0.2, 2.0, 0.0, 30.0, np.inf, 0.0, 0.0, 40.0, 0.0, 0.0,
    Thresholds(_NEEDED, _NEEDED, _NEEDED, _NEEDED), 0.7,
)  # fmt: skip
_KNOWN = Uncertainty(np.zeros((1, 1)), np.zeros((1, 1)))


def _series(seed, duration=600.0, window=10.0):
    """A feature that wanders as `_WANDER` says, every 5 s, in one stretch of work."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, duration, 5.0)
    kept, slow = np.exp(-5.0 / _WANDER.memory), np.empty(time.size)
    level = random.normal()
    for index in range(time.size):
        slow[index] = level
        level = kept * level + np.sqrt(1.0 - kept**2) * random.normal()
    value = 5.0 + _WANDER.short * random.normal(size=time.size) + _WANDER.slow * slow
    nothing, windows = np.zeros(time.size), np.full(time.size, window)
    return FeatureSeries(time, value, nothing, nothing, windows, *[nothing] * 4, np.zeros((time.size, 1)))


def _change(series, more=0.0, uncertain=_KNOWN):
    return likeliest_change(replace(series, value=series.value + more), uncertain, _WANDER)


def _step(series, since):
    return np.clip((series.time - since) / series.window, 0.0, 1.0)


@pytest.mark.parametrize("seed", range(5))
def test_step_is_found_with_its_time(seed):
    series = _series(seed)
    change = _change(series, 2.0 * _step(series, 400.0))
    assert change.evidence > _NEEDED
    assert change.kind == "step"
    assert change.since == pytest.approx(400.0, abs=15.0)
    assert change.interval[0] <= 405.0 and change.interval[1] >= 390.0
    assert change.size == pytest.approx(2.0, abs=0.6)


@pytest.mark.parametrize("seed", range(5))
def test_ramp_is_called_ramp(seed):
    series = _series(seed)
    change = _change(series, np.maximum(series.time - 300.0, 0.0) / 60.0)
    assert change.evidence > _NEEDED
    assert change.kind == "ramp"
    assert change.since == pytest.approx(300.0, abs=60.0)


def test_wander_alone_stays_below_threshold():
    evidence = [_change(_series(seed)).evidence for seed in range(40)]
    assert max(evidence) < _NEEDED
    assert np.median(evidence) < 4.0


def _two_stretches(seed, duration=600.0):
    series = _series(seed, duration)
    later = series.time > 300.0
    return replace(series, stretch=later.astype(float), stretch_start=np.where(later, 300.0, 0.0))


@pytest.mark.parametrize("seed", range(5))
def test_new_level_after_an_operation_is_no_change(seed):
    series = _two_stretches(seed)
    assert _change(series, 2.0 * series.stretch).evidence < _NEEDED


def test_change_between_stretches_is_dated_by_them():
    series = _two_stretches(0)
    kept = (series.time < 200.0) | (series.time > 350.0)
    series = FeatureSeries(*(getattr(series, name)[kept] for name in vars(series)))
    change = _change(series, 25.0 * series.stretch)
    assert change.evidence > _NEEDED
    assert 190.0 < change.interval[0] + 5.0 < 260.0 < change.since < 300.0 < change.interval[1] < 360.0


@pytest.mark.parametrize(("shape", "size", "since", "beginning"), [
    (_step, 3.0, 800.0, "sudden"), (_step, 3.0, 600.0, "long_ago"), (_step, 9.0, 320.0, "after_operation"),
    (lambda series, since: np.maximum(series.time - since, 0.0) / 60.0, 2.0, 700.0, "gradual"),
])  # fmt: skip
def test_each_beginning_needs_evidence_of_its_own(shape, size, since, beginning):
    series = _two_stretches(0, duration=900.0)
    change = _change(series, size * shape(series, since))
    assert change.beginning == beginning
    others = Thresholds(**{**vars(Thresholds(1.0, 1.0, 1.0, 1.0)), beginning: 1e9})
    assert not replace(_WANDER, thresholds=others).exceeded_by(change)
    alone = Thresholds(**{**vars(Thresholds(1e9, 1e9, 1e9, 1e9)), beginning: 1.0})
    assert replace(_WANDER, thresholds=alone).exceeded_by(change)


def _evidence(series, more, **wander):
    changed = likeliest_change(replace(series, value=series.value + more), _KNOWN, replace(_WANDER, **wander))
    return changed.evidence


def test_what_follows_the_load_is_no_change():
    series = _series(0)
    load = np.where(series.time < 300.0, 0.9, 0.3)
    series = replace(series, load=load)
    assert _evidence(series, -3.0 * load, weighed=3.0) < _NEEDED < _evidence(series, -3.0 * load)


def test_moving_load_hides_a_short_excursion():
    series = _series(0)
    moves = np.exp(-(((series.time - 400.0) / 30.0) ** 2))
    series = replace(series, loading=moves)
    assert _evidence(series, 4.0 * moves, loaded=4.0) < _NEEDED < _evidence(series, 4.0 * moves)


def test_what_steering_leaves_is_no_change():
    series = _series(0)
    steered = 100.0 * _step(series, 300.0)
    series = replace(series, steering=steered)
    left = 2.0 * _step(series, 300.0)
    assert _evidence(series, left, steered=0.2) < _NEEDED < _evidence(series, left)
    later = 2.0 * _step(series, 450.0)
    assert _evidence(series, later, steered=0.2) > _NEEDED


def test_another_swing_of_the_drive_is_no_change():
    series = _series(0)
    wider = _step(series, 300.0)
    series = replace(series, swing=3.0 + 0.4 * wider)
    assert _evidence(series, 2.0 * wider, swung=1.5) < _NEEDED < _evidence(series, 2.0 * wider)


def test_what_acts_only_under_load_is_found():
    series = _series(0)
    load = np.abs(np.sin(series.time / 60.0))
    series = replace(series, sensitivity=load[:, None])
    uncertain = Uncertainty(np.zeros((1, 1)), np.array([[0.35]]))
    more = 3.0 * load * _step(series, 300.0)
    loaded, unloaded = _change(series, more, uncertain), _change(series, more)
    assert loaded.since == pytest.approx(300.0, abs=20.0)
    assert loaded.size == pytest.approx(3.0, abs=0.5)
    assert loaded.evidence > _NEEDED and unloaded.size < 2.5


def test_uncertain_parameter_explains_its_own_change():
    series = _series(0)
    shape = _step(series, 300.0)
    series = replace(series, sensitivity=shape[:, None])
    uncertain = Uncertainty(4.0 * np.eye(1), np.zeros((1, 1)))
    assert _change(series, 2.0 * shape, uncertain).evidence < _NEEDED


def test_too_few_values_say_nothing():
    short = _series(0, duration=60.0)
    assert _change(short) is None
    assert likeliest_change(short, _KNOWN, replace(_WANDER, before=2)) is not None


def test_pressure_off_bottom_is_watched_more_closely_than_on_bottom():
    on, off = (wander_of(mode, "standpipe_pressure", "mean") for mode in ("rocking", "off bottom"))
    assert off.before < on.before and off.weighed == 0.0
    assert wander_of("off bottom", "surface_torque", "mean") is None


def test_every_channel_at_surface_is_watched():
    assert {channel for channel, _ in WANDERS} == {"surface_torque", "hook_load", "standpipe_pressure"}


def test_parameters_of_one_kind_wander_together():
    wanders = parameter_wanders(["friction_1", "friction_2", "motor_gain", "string_stiffness"])
    assert wanders.shape == (4, 2)
    assert wanders[0, 0] == wanders[1, 0] > 0.0 and not wanders[3].any()


def test_wander_is_found_in_slides_without_a_change():
    slides = [(_series(seed), _KNOWN) for seed in range(2)]
    found = fit_wander(slides, replace(_WANDER, slow=0.6, short=0.03, jump=0.1))
    assert found.slow == pytest.approx(_WANDER.slow, rel=0.4)
    assert found.short == pytest.approx(_WANDER.short, rel=0.3)


def test_threshold_extrapolates_an_exponential_tail():
    """Of evidence with an exponential tail of scale 3, ten times fewer slides exceed what is 3 ln 10 higher."""
    largest = np.random.default_rng(0).exponential(3.0, 3000)
    days = 100.0
    assert threshold(largest, 24.0 * days) == pytest.approx(3.0 * np.log(3000 / (0.025 * days)), abs=1.0)
    lower = threshold(largest, 24.0 * days) - threshold(largest, 240.0 * days)
    assert lower == pytest.approx(3.0 * np.log(10.0), abs=0.5)


def test_largest_evidence_is_told_by_how_a_change_begins():
    series = _series(0)
    quiet = largest_evidence((series, _KNOWN), _WANDER)
    stepped = largest_evidence((replace(series, value=series.value + 3.0 * _step(series, 450.0)), _KNOWN), _WANDER)
    assert max(quiet.values()) < _NEEDED < stepped["sudden"]
    assert stepped["after_operation"] == 0.0
