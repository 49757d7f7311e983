from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.twin.activity import OFF_BOTTOM, Activity
from slider_drilling.twin.change_statistic import Uncertainty
from slider_drilling.twin.detector import ChangeDetector
from slider_drilling.twin.features import Feature
from slider_drilling.twin.wander import ROCKING_OR_OFF_BOTTOM, WANDERS

_PRESSURE = (OFF_BOTTOM, "standpipe_pressure", "mean")
_OFF = Activity(
    OFF_BOTTOM, False, "off bottom", False, 8.0, 1, 0.0, comparable=False, circulating=True, hanging=True,
    circulation_known=True, valid_until=np.inf,
)  # fmt: skip


def _detector(levels, apart=600.0):
    """Off bottom twice, a minute each, so many s apart at these pressures; the block is lowered at the end of each."""
    detector = ChangeDetector(Uncertainty(np.zeros((1, 1)), np.zeros((1, 1))))
    random = np.random.default_rng(0)
    for stretch, level in enumerate(levels):
        for second in range(0, 60, 5):
            now = apart * stretch + second
            value = level + 0.1 * random.normal()
            found = [Feature("standpipe_pressure", "mean", value, np.array([2.0])),
                     Feature("hook_load", "spread", 0.0, np.zeros(1)),
                     Feature("surface_torque", "mean", 0.0, np.zeros(1))]  # fmt: skip
            detector.add(now, replace(_OFF, stretch=stretch, stretch_start=apart * stretch, hanging=second < 30), found)
    return detector


def test_pressure_lost_between_two_stretches_off_bottom_is_a_change():
    alarm = _detector([3.0, -17.0]).test(_PRESSURE, complete=True)
    assert alarm.kind == "mean" and alarm.change.in_operation
    assert 55.0 < alarm.change.since < 600.0 and abs(alarm.change.size + 20.0) < 4.0


def test_pressure_lost_between_two_connections_is_a_change():
    assert _detector([3.0, -27.0], apart=5400.0).test(_PRESSURE, complete=True) is not None


def test_long_circulation_keeps_as_many_values_as_work():
    detector = _detector([3.0])
    for second in range(60, 7200, 5):
        detector.add(float(second), _OFF, [Feature(*_PRESSURE[1:], 3.0, np.array([2.0]))])
    assert detector.series(_PRESSURE).time.size == 360


def test_change_that_has_just_shown_waits_unless_the_stretch_is_over():
    detector = _detector([3.0, -17.0])
    assert detector.test(_PRESSURE) is None
    assert detector.test(_PRESSURE, complete=True) is not None


def test_bit_that_touches_bottom_before_the_twins_is_no_change():
    """Within one stretch off bottom, the pressure may rise because the bit drills already."""
    detector = _detector([3.0, 3.0])
    touching = replace(_OFF, stretch=1, stretch_start=600.0)
    for second in range(60, 120, 5):
        detector.add(600.0 + second, touching, [Feature("standpipe_pressure", "mean", 15.0, np.array([2.0]))])
    assert detector.change(_PRESSURE).evidence > 10.0
    assert detector.test(_PRESSURE, complete=True) is None


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_pressure_that_falls_off_bottom_is_a_change_within_one_stretch(sign):
    """A bit that touches bottom raises the pressure; nothing but a change lets it fall."""
    detector = _detector([3.0])
    for second in range(60, 160, 5):
        value = 3.0 + sign * 0.05 * (second - 60)
        detector.add(float(second), replace(_OFF, stretch=0), [Feature(*_PRESSURE[1:], value, np.array([2.0]))])
    alarm = detector.test(_PRESSURE, complete=True)
    assert (alarm is not None) == (sign < 0.0)


def _drilled_then_off_bottom(pressure):
    """Ten minutes of rocking at a pressure of 1, then off bottom at another one."""
    detector = ChangeDetector(Uncertainty(np.zeros((1, 1)), np.zeros((1, 1))))
    random = np.random.default_rng(0)
    rocking = replace(_OFF, mode="rocking", period=20.0, comparable=True, circulating=False, load=0.8)
    for second in range(0, 720, 5):
        work = rocking if second < 600 else replace(_OFF, stretch=2, stretch_start=640.0)
        level = (1.0 if second < 600 else pressure) + 0.1 * random.normal()
        if second < 600 or second >= 655:
            detector.add(float(second), work, [Feature(*_PRESSURE[1:], level, np.array([2.0]))])
    return detector.test((ROCKING_OR_OFF_BOTTOM, *_PRESSURE[1:]), complete=True)


def test_pressure_lost_as_the_bit_leaves_bottom_is_a_change():
    alarm = _drilled_then_off_bottom(-40.0)
    assert alarm.change.in_operation and alarm.change.size < -20.0


def test_model_error_of_the_motors_pressure_is_no_change():
    """Load moves the error of the pressure on rigs that do not change: 2.4 standard deviations are no change."""
    assert _drilled_then_off_bottom(-2.4 * WANDERS["standpipe_pressure", "mean"].weighed) is None


def test_warmer_mud_is_no_change():
    assert _detector([3.0, -1.0]).test(_PRESSURE, complete=True) is None


def test_hook_load_is_watched_off_bottom_while_the_string_hangs_still():
    detector = _detector([3.0])
    hook_load = (OFF_BOTTOM, "hook_load", "spread")
    assert set(detector.watched(OFF_BOTTOM)) == {_PRESSURE, (ROCKING_OR_OFF_BOTTOM, *_PRESSURE[1:]), hook_load}
    assert detector.series(hook_load).time.size == 6


def test_what_was_seen_before_calibration_counts_after_it():
    before = _detector([3.0])
    after = before.recalibrated(np.array([1.5]), before.uncertain)
    moved = before.series(_PRESSURE).value - after.series(_PRESSURE).value
    assert np.allclose(moved, 3.0)


_ROCKING = Activity(
    "rocking", True, "", True, 20.0, 1, 0.0, comparable=True, circulating=False, hanging=False,
    circulation_known=False, valid_until=np.inf, load=1.0,
)  # fmt: skip


def _rocked(hook_load):
    """Rocking for 10 min; the pressure rises by 8 noise levels at 400 s, the hook load by so many within a minute."""
    detector = ChangeDetector(Uncertainty(np.zeros((1, 1)), np.zeros((1, 1))))
    random = np.random.default_rng(0)
    for now in np.arange(0.0, 600.0, 5.0):
        pressure = 8.0 * (now >= 400.0) + 0.5 * random.normal()
        hook = hook_load * np.clip((now - 380.0) / 60.0, 0.0, 1.0) + 0.2 * random.normal()
        zero = np.zeros(1)
        found = [Feature("standpipe_pressure", "mean", pressure, zero), Feature("hook_load", "mean", hook, zero)]
        detector.add(now, _ROCKING, found)
    return detector.change((ROCKING_OR_OFF_BOTTOM, "standpipe_pressure", "mean")).evidence


def test_pressure_that_rises_as_the_string_slips_is_weight_and_not_a_change():
    threshold = WANDERS["standpipe_pressure", "mean"].threshold
    assert _rocked(0.0) > threshold
    assert _rocked(5.0) < 0.7 * threshold


def test_hook_load_of_a_new_stretch_has_a_level_of_its_own():
    detector = ChangeDetector(Uncertainty(np.zeros((1, 1)), np.zeros((1, 1))))
    for now in np.arange(0.0, 400.0, 5.0):
        second = now >= 200.0
        found = [Feature("hook_load", "mean", 4.0 * second, np.zeros(1))]
        detector.add(now, replace(_ROCKING, stretch=int(second), stretch_start=200.0 * second), found)
    assert not detector.series(("rocking", "hook_load", "mean")).hook_load_moved.any()
