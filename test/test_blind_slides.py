"""Sealed slides in which something begins, and the score of a twin that watched them."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from itertools import pairwise

import numpy as np
import pytest
from short_well import short_rig

from slider_drilling.blind.slides.beginnings import BEGINNINGS, SIX_CASES
from slider_drilling.blind.slides.case import SlideCase, draw_slides, slide_case_from_json
from slider_drilling.blind.slides.crew import draw_rocking, settings_at
from slider_drilling.blind.slides.driller import Driller
from slider_drilling.blind.slides.forecasts import ForecastErrors
from slider_drilling.blind.slides.label import SlideLabel, read_slide_label
from slider_drilling.blind.slides.make import make_slide
from slider_drilling.blind.slides.operations import DURATIONS, Operation, draw_operations
from slider_drilling.blind.slides.score import score_slide
from slider_drilling.blind.slides.table import campaign_table
from slider_drilling.blind.slides.watched import TwinAnswer, WatchedDetection, WatchedSlide, watched_from_json
from slider_drilling.control.fixed_rocking import FixedRocking
from slider_drilling.control.interface import Measurements
from slider_drilling.errors import InputError
from slider_drilling.log import read_log

LABEL = SlideLabel("x.mcap", "washout", "washout", ("washout",), "hydraulics", True, 1000.0, 600.0, 1100.0, 4.0, (),
                   2400.0, 1, "horizontal")  # fmt: skip


def _watched(*detections):
    return WatchedSlide("x.mcap", 2400.0, 2000.0, detections, 0.05, (6.0,), 200_000_000, ForecastErrors())


def _detection(detected, *answers, since=None):
    return WatchedDetection(detected, detected - 20.0 if since is None else since, (0.0, 1.0), "standpipe_pressure",
                            "hydraulics", "ramp", answers)  # fmt: skip


def _answer(after, *effects, group=(), verdict="effect", site="hydraulics"):
    return TwinAnswer(after, verdict, effects, tuple(group), (), site)


def test_more_slides_begin_with_the_same():
    assert draw_slides(30, 4)[:7] == draw_slides(7, 4)
    assert draw_slides(3, 4) != draw_slides(3, 5)


def test_mixture_has_all_six_and_quiet_slides():
    begins = [case.begins for case in draw_slides(40, 1)]
    assert set(SIX_CASES) <= set(begins) and begins.count("none") == 8


def test_case_is_kept_in_json():
    case = draw_slides(1, 9)[0]
    assert slide_case_from_json(json.loads(json.dumps(case.to_json()))) == case


def test_ramp_grows_from_its_onset():
    case = SlideCase("washout", 1000.0, 400.0, "horizontal", 1)
    assert [case.share_at(time) for time in (999.0, 1100.0, 2000.0)] == [0.0, 0.25, 1.0]
    assert replace(case, growth=0.0).share_at(1000.0) == 1.0


def test_operations_follow_each_other():
    for seed in range(20):
        operations = draw_operations(np.random.default_rng(seed), 2400.0)
        assert len({each.name for each in operations}) == len(operations) >= 5
        assert all(a.end <= b.start for a, b in pairwise(operations))


@pytest.mark.parametrize("name", sorted(BEGINNINGS))
def test_beginning_is_nothing_at_share_zero(name):
    beginning = BEGINNINGS[name](np.random.default_rng(0), short_rig(), 900.0)
    full, none = beginning.values(1.0, 17.0), beginning.values(0.0, 17.0)
    assert beginning.flow(0.0, 17.0) == 1.0 and beginning.hook_load(0.0, 17.0, 5.0) == 5.0
    changed = full != none or beginning.flow(1.0, 17.0) != 1.0 or beginning.hook_load(1.0, 17.0, 5.0) != 5.0
    assert changed and beginning.name in beginning.accepted
    assert all(value == 1.0 for key, value in none.items() if "." not in key)


def test_sealed_slide_hides_what_begins(tmp_path):
    case = SlideCase("torque_bias", 60.0, 0.0, "own", 3, 120.0)
    label = make_slide(case, short_rig(), tmp_path / "a.mcap")
    log = read_log(tmp_path / "a.mcap")
    assert log.truth_bit is None and b"torque_sensor_bias" not in (tmp_path / "a.mcap").read_bytes()
    assert label.reached == pytest.approx(60.0, abs=15.0) and label.size > 1.5
    again = make_slide(case, short_rig(), tmp_path / "b.mcap")
    assert again == replace(label, log="b.mcap")
    (tmp_path / "label.json").write_text(json.dumps(asdict(label)))
    assert read_slide_label(tmp_path / "label.json") == label


@pytest.mark.parametrize("seed", range(6))
def test_crew_keeps_to_settings_that_the_drive_can_follow(seed):
    rig = short_rig()
    changes = draw_rocking(np.random.default_rng(seed), rig, 2400.0)
    assert changes[0].start == 0.0 and all(a.start < b.start < 2400.0 for a, b in pairwise(changes))
    for change in changes:
        FixedRocking(rig, change.settings)
        assert settings_at(changes, change.start + 1.0) == change.settings


def test_crew_rocks_as_before_after_an_operation():
    rig = short_rig()
    changes = draw_rocking(np.random.default_rng(1), rig, 2400.0)
    driller = Driller(rig, (Operation("flow", 5.0, 0.9), Operation("rest", 10.0)), 0.0, changes)
    measured = Measurements(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    commands = [driller.command(replace(measured, time=0.1 * step), 0.1) for step in range(800)]
    speeds = [abs(each.top_drive_speed) for each in commands]
    assert max(speeds[110:690]) == 0.0 and max(speeds[720:]) > 1.0
    assert commands[-1].pump_speed == pytest.approx(0.9 * rig.reference_pump_speed)
    assert commands[-1].block_speed == changes[0].settings.block_speed


def test_wrong_label_is_refused(tmp_path):
    (tmp_path / "label.json").write_text('{"schema": "slider_drilling/slide_label/0"}')
    with pytest.raises(InputError, match="this version reads"):
        read_slide_label(tmp_path / "label.json")


def test_delay_counts_from_visible_size():
    scored = score_slide(LABEL, _watched(_detection(1150.0, _answer(1180.0, "washout"))))
    assert (scored.detected, scored.delay, scored.right, scored.wrong) == (True, 50.0, True, False)


def test_detection_before_onset_is_false_alarm():
    scored = score_slide(LABEL, _watched(_detection(500.0), _detection(1150.0)))
    assert scored.false_alarms == 1 and scored.detected and not scored.right


def test_late_answer_does_not_count():
    scored = score_slide(LABEL, _watched(_detection(1150.0, _answer(1340.0, "washout"))))
    assert not scored.right and scored.verdict == ""


def test_group_is_right_and_other_name_wrong():
    grouped = score_slide(LABEL, _watched(_detection(1150.0, _answer(1180.0, "motor_wear", group=["washout"]))))
    other = score_slide(LABEL, _watched(_detection(1150.0, _answer(1180.0, "motor_wear"))))
    assert grouped.right and not grouped.wrong and other.wrong


def test_unknown_is_right_for_what_is_outside():
    sheave = {"name": "sticking_sheave", "accepted": ("sticking_sheave",), "site": "draw_works"}
    outside = replace(LABEL, in_catalogue=False, **sheave)
    unknown = score_slide(outside, _watched(_detection(1150.0, _answer(1180.0, verdict="unknown"))))
    named = score_slide(outside, _watched(_detection(1150.0, _answer(1180.0, "washout"))))
    assert unknown.right and named.wrong


def test_table_counts_false_alarms_per_day():
    quiet = replace(LABEL, name="none", case="none", onset=None, reached=None)
    scored = [score_slide(quiet, _watched(_detection(500.0))), score_slide(LABEL, _watched(_detection(1150.0)))]
    rows = {row.what: row.value for row in campaign_table(scored, [_watched()])}
    assert rows["false alarms in 24 h"].startswith("25.4 [") and "(1 in 0.9 h)" in rows["false alarms in 24 h"]
    assert rows["detected, of 1.5 noise levels or more"].startswith("100 %")


def test_watched_slide_is_kept_in_json():
    watched = _watched(_detection(1150.0, _answer(1180.0, "washout", group=["x"])))
    assert watched_from_json(json.loads(json.dumps(asdict(watched)))) == watched


def test_every_operation_has_a_duration():
    assert set(DURATIONS) == {"target", "flow", "pick_up", "rotation", "rest", "connection"}
