"""When a named change began, by how much of it the samples hold over time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from short_well import coarse_meshes, routine_slide, short_rig

from slider_drilling.diagnosis.baseline import fit_baseline
from slider_drilling.diagnosis.diagnose_change import diagnose_change
from slider_drilling.diagnosis.onset import Onset, Since
from slider_drilling.diagnosis.page import report_page
from slider_drilling.diagnosis.sentences import summary
from slider_drilling.diagnosis.share_rise import ChangeDate, Rise, ShareOverTime, rise_of
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.log.time_window import cut_time_window

BEGAN = 300.0
TIME = 2.5 + 5.0 * np.arange(120)


def _shares(expected, scatter=0.1, held=None, seed=0):
    noise = scatter * np.random.default_rng(seed).standard_normal(TIME.size)
    held = np.full(TIME.size, True) if held is None else held
    return ShareOverTime(TIME[held], (expected + noise)[held], np.full(held.sum(), 0.0025))


def test_step_is_dated_to_a_block():
    found = rise_of(_shares((TIME > BEGAN).astype(float))).date
    assert found.since == pytest.approx(BEGAN, abs=5.0)
    assert found.interval[0] <= BEGAN <= found.interval[1] and found.interval[1] - found.interval[0] <= 20.0


@pytest.mark.parametrize("growth", [150.0, 220.0, 300.0, 450.0])
def test_ramp_begins_within_its_interval(growth):
    ramp = np.clip((TIME - BEGAN) / growth, 0.0, 1.0)
    found = [rise_of(_shares(ramp, seed=seed)).begins for seed in range(10)]
    assert np.mean([date.interval[0] <= BEGAN <= date.interval[1] for date in found]) >= 0.8
    assert np.median([abs(date.since - BEGAN) for date in found]) <= 20.0


def test_ramp_is_distinguished_from_a_step():
    ramp = np.clip((TIME - BEGAN) / 220.0, 0.0, 1.0)
    assert rise_of(_shares(ramp)).gradual and not rise_of(_shares((TIME > BEGAN).astype(float))).gradual


def test_step_is_dated_beside_a_slow_wander():
    found = rise_of(_shares(0.3 * np.sin(TIME / 40.0) + (TIME > BEGAN)))
    assert found.begins.since == pytest.approx(BEGAN, abs=5.0)
    assert found.begins.interval[1] - found.begins.interval[0] <= 30.0


@pytest.mark.parametrize("seed", range(5))
def test_a_wander_alone_shows_no_rise(seed):
    steps = np.random.default_rng(seed).standard_normal(TIME.size)
    assert not rise_of(_shares(0.5 + 0.1 * np.cumsum(steps), seed=seed)).shows


def test_what_begins_in_an_operation_may_have_begun_at_any_time_of_it():
    held = (TIME < 250.0) | (TIME > 350.0)
    found = rise_of(_shares((TIME > BEGAN).astype(float), held=held)).date
    assert found.interval[0] < 256.0 and found.interval[1] > 344.0 and 250.0 < found.since < 350.0


@pytest.mark.parametrize("shares", [
    pytest.param(2.0 + (TIME > BEGAN), id="all of it and more before"),
    pytest.param(0.3 * (TIME > BEGAN), id="little of it afterwards"),
    pytest.param(0.0 * TIME + 1.0, id="as much all the time"),
    pytest.param(0.5 + 0.7 * np.sin(TIME / 40.0), id="comes and goes"),
])  # fmt: skip
def test_shares_that_are_not_none_before_and_all_after_date_nothing(shares):
    assert rise_of(_shares(shares)).date is None


@pytest.mark.parametrize(("shares", "shows"), [
    (2.0 + (TIME > BEGAN), True), (0.5 * (TIME > BEGAN), True), (0.0 * TIME + 1.0, False),
    (1.0 * (TIME < BEGAN), False),
])  # fmt: skip
def test_change_of_which_the_later_samples_hold_no_more_does_not_show(shares, shows):
    assert rise_of(_shares(shares)).shows is shows


@pytest.mark.parametrize(("interval", "more"), [
    (None, True), ((80.0, 130.0), True), ((98.0, 105.0), False), ((111.0, 112.0), True), ((80.0, 89.0), True),
])  # fmt: skip
def test_narrower_or_contradicting_date_counts(interval, more):
    assert ChangeDate(100.0, (90.0, 110.0)).says_more_than(interval) is more


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    """A routine slide of 330 s with a torque reading that is off from 240 s on, and its first 200 s as baseline."""
    with coarse_meshes():
        whole = routine_slide(tmp_path_factory.mktemp("dated") / "slide.mcap", short_rig(), 3, 330.0)
        drive = whole.top_drive
        log = replace(whole, top_drive=replace(drive, effort=drive.effort + 800.0 * (drive.time > 240.0)))
        yield log, fit_baseline([cut_time_window(log, 0.0, 200.0)], short_rig())


def _diagnosed(slide, since, only):
    log, baseline = slide
    onset = Onset(200.0, 290.0).relative_to(60.0)
    later = cut_time_window(log, 60.0, 330.0)
    return diagnose_change(baseline, [later], short_rig(), since=since, onset=onset, whole=(True, False), only=only)


def test_named_change_dates_itself_in_the_time_of_the_users_log(slide):
    found = _diagnosed(slide, Since(245.0, (200.0, 290.0), True, log_start=60.0), ("torque_sensor_bias",))
    assert found.effects == ("torque_sensor_bias",) and found.change.dated
    low, high = found.change.since_interval
    assert low <= 240.0 <= high and high - low <= 20.0 and found.change.since == pytest.approx(240.0, abs=5.0)
    assert f"since {found.change.since:.0f} s" in str(summary(found)) and to_json(found)["change"]["dated"]
    held = found.change.held
    late = held.time > 260.0
    assert np.all(abs(held.share[held.time < 220.0]) < 0.3) and np.all(abs(held.share[late] - 1.0) < 0.3)
    assert np.all(held.interval[:, 0] < held.share) and held.time[-1] == pytest.approx(315.0, abs=20.0)
    assert "When it began" in [section.title for section in report_page(found).sections]
    assert found.change.log_start == 60.0 + Onset(200.0, 290.0).relative_to(60.0).simulated_from


def test_pictures_and_remarks_have_the_times_of_the_users_log(slide):
    found = _diagnosed(slide, Since(245.0, (200.0, 290.0), True, log_start=60.0), ("torque_sensor_bias",))
    begin, source = found.change.log_start, found.log_checks[0].log.source
    assert begin > 60.0 and all(trace.time[0] >= begin for trace in found.traces)
    assert source.endswith(f", from {begin:.0f} s on") and any(source in str(remark) for remark in found.remarks)


def test_name_that_does_not_rise_is_refused(slide, monkeypatch):
    held = ShareOverTime(*np.ones((3, 1)))
    flat = Rise(0.0, 0.02, -2.0, ChangeDate(100.0, (50.0, 150.0)), False, held)
    monkeypatch.setattr("slider_drilling.diagnosis.diagnose_change.rise_of_change", lambda *arguments: flat)
    found = _diagnosed(slide, Since(245.0, (200.0, 290.0), True, log_start=60.0), ("torque_sensor_bias",))
    assert found.effects == () and found.suspected == ("torque_sensor_bias",) and not found.change.dated
    assert "hold no more of it" in found.ranking[0].why_not[0]


def test_time_that_a_user_gives_stays(slide):
    found = _diagnosed(slide, Since(245.0, log_start=60.0), ("torque_sensor_bias",))
    assert (found.change.since, found.change.dated) == (245.0, False)


def test_answer_without_a_known_time_has_no_since(slide):
    log, baseline = slide
    later = cut_time_window(log, 250.0, 330.0)
    found = diagnose_change(baseline, [later], short_rig(), whole=(True, False), only=("torque_sensor_bias",))
    assert found.change.since is None and "since" not in str(summary(found))
