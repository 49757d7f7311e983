from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.benchmarks.twin_wander import fit_wander, largest_evidence, threshold
from slider_drilling.twin.change_statistic import Uncertainty, Wander, likeliest_change
from slider_drilling.twin.feature_means import FeatureSeries, means_of
from slider_drilling.twin.wander import WANDERS, comparisons, parameter_wanders, wander_of

_NEEDED = 10.0
_WANDER = Wander(
    white=0.06, slow=0.2, memory=80.0, drift=0.2, jump=2.0, fresh=0.0, weighed=0.0, steered=0.0, swung=0.0,
    threshold=_NEEDED, smallest=0.7,
)  # fmt: skip
_KNOWN = Uncertainty(np.zeros((1, 1)), np.zeros((1, 1)))


def _series(seed, duration=900.0, window=10.0):
    """A feature that wanders as `_WANDER` says, every 5 s, in one stretch of work."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, duration, 5.0)
    kept, slow = np.exp(-5.0 / _WANDER.memory), np.empty(time.size)
    level = random.normal()
    for index in range(time.size):
        slow[index] = level
        level = kept * level + np.sqrt(1.0 - kept**2) * random.normal()
    white = _WANDER.white * np.sqrt(_WANDER.values)
    value = 5.0 + white * random.normal(size=time.size) + _WANDER.slow * slow
    nothing, windows = np.zeros(time.size), np.full(time.size, window)
    return FeatureSeries(time, value, nothing, nothing, windows, *[nothing] * 5, np.zeros((time.size, 1)))


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


def _two_stretches(seed, duration=900.0):
    series = _series(seed, duration)
    later = series.time > 450.0
    return replace(series, stretch=later.astype(float), stretch_start=np.where(later, 450.0, 0.0))


@pytest.mark.parametrize("seed", range(5))
def test_new_level_after_an_operation_is_no_change(seed):
    series = _two_stretches(seed)
    assert _change(series, 2.0 * series.stretch).evidence < _NEEDED


def test_another_way_of_rocking_may_have_a_level_of_its_own():
    """The same step where the period changes, and where it does not."""
    series, wander = _series(0), replace(_WANDER, swung=2.0)
    later = series.time > 450.0
    stepped = replace(series, value=series.value + 2.0 * later)
    faster = replace(stepped, pace=np.where(later, 2.0, 3.0))
    evidence = [likeliest_change(each, _KNOWN, wander).evidence for each in (stepped, faster)]
    assert evidence[1] < _NEEDED < evidence[0]


def test_change_between_stretches_is_dated_by_them():
    series = _two_stretches(0)
    kept = (series.time < 350.0) | (series.time > 500.0)
    series = FeatureSeries(*(getattr(series, name)[kept] for name in vars(series)))
    change = _change(series, 25.0 * series.stretch)
    assert change.evidence > _NEEDED and change.in_operation
    assert 340.0 < change.interval[0] + 5.0 < 410.0 < change.since < 450.0 < change.interval[1] < 510.0


def test_rig_that_wanders_little_shows_smaller_changes():
    """The same step in a third of the wander that other rigs show has more evidence."""
    series, small = _series(0), 0.5 * _step(_series(0), 600.0)
    calm = replace(series, value=series.value / 3.0)
    assert _change(calm, small).evidence > 1.5 * _change(series, small).evidence


@pytest.mark.parametrize(("within", "load", "size", "counts"), [
    (True, 0.5, 3.0, True), (True, 0.0, 3.0, False), (True, 0.0, -3.0, True), (False, 0.5, -3.0, False),
])  # fmt: skip
def test_change_within_a_stretch_counts_where_nothing_else_makes_one(within, load, size, counts):
    """Off bottom a rise may be the bit that touches."""
    series = _series(0)
    change = _change(replace(series, load=np.full(series.time.size, load)), size * _step(series, 600.0))
    assert not change.in_operation
    assert replace(_WANDER, within=within).exceeded_by(change) == counts


def _evidence(series, more, **wander):
    changed = likeliest_change(replace(series, value=series.value + more), _KNOWN, replace(_WANDER, **wander))
    return changed.evidence


def test_what_follows_the_load_is_no_change():
    series = _series(0)
    load = np.where(series.time < 300.0, 0.9, 0.3)
    series = replace(series, load=load)
    assert _evidence(series, -3.0 * load, weighed=3.0) < _NEEDED < _evidence(series, -3.0 * load)


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
    short = _series(0, duration=180.0)
    assert _change(short) is None
    assert likeliest_change(short, _KNOWN, replace(_WANDER, before=2)) is not None
    assert likeliest_change(_series(0, duration=10.0), _KNOWN, _WANDER) is None


def test_no_mean_spans_two_stretches():
    series = _two_stretches(0, duration=700.0)
    means = means_of(series, 12)
    assert (means.end < 455.0).sum() == (means.stretch == 0).sum() and means.count.sum() == series.time.size
    assert all(np.ptp(series.stretch[weights > 0.0]) == 0.0 for weights in means.weights)
    assert np.allclose(means.average(series.value[:, None])[:, 0], means.value)


def test_pressure_off_bottom_is_watched_more_closely_than_on_bottom():
    on, off = (wander_of(mode, "standpipe_pressure", "mean") for mode in ("rocking", "off bottom"))
    assert off.values * off.before < on.values * on.before and off.weighed == 0.0
    assert wander_of("off bottom", "surface_torque", "mean") is None


def test_pressure_of_a_string_that_turns_is_compared_with_itself_alone():
    rocking, turning, off = (set(comparisons(mode, "standpipe_pressure", "mean"))
                             for mode in ("rocking", "turning", "off bottom"))  # fmt: skip
    assert rocking < off and turning == {"turning"}


def test_every_channel_at_surface_is_watched():
    assert {channel for channel, _ in WANDERS} == {"surface_torque", "hook_load", "standpipe_pressure"}


def test_parameters_of_one_kind_wander_together():
    wanders = parameter_wanders(["friction_1", "friction_2", "motor_gain", "string_stiffness"])
    assert wanders.shape == (4, 2)
    assert wanders[0, 0] == wanders[1, 0] > 0.0 and not wanders[3].any()


def test_wander_is_found_in_slides_without_a_change():
    slides = [(_series(seed), _KNOWN) for seed in range(2)]
    found = fit_wander(slides, replace(_WANDER, slow=0.6, white=0.2, jump=0.1))
    assert np.hypot(found.slow, found.white) == pytest.approx(np.hypot(_WANDER.slow, _WANDER.white), rel=0.4)


def test_threshold_extrapolates_an_exponential_tail():
    """Of evidence with an exponential tail of scale 3, ten times fewer slides exceed what is 3 ln 10 higher."""
    largest = np.random.default_rng(0).exponential(3.0, 3000)
    days = 100.0
    assert threshold(largest, 24.0 * days) == pytest.approx(3.0 * np.log(3000 / (0.1 * days)), abs=1.0)
    lower = threshold(largest, 24.0 * days) - threshold(largest, 240.0 * days)
    assert lower == pytest.approx(3.0 * np.log(10.0), abs=0.5)


def test_largest_evidence_is_that_of_the_change():
    series = _series(0)
    stepped = replace(series, value=series.value + 3.0 * _step(series, 650.0))
    assert largest_evidence((series, _KNOWN), _WANDER) < _NEEDED < largest_evidence((stepped, _KNOWN), _WANDER)
