"""Without a detection the twin asks now and then whether the rig is as it was: two answers that agree are a change."""

from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.rig import load_rig
from slider_drilling.twin.ask import diagnose_after
from slider_drilling.twin.background import PickledBaseline, Reply
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.diagnoser import Diagnoser
from slider_drilling.twin.motion import new_buffers
from slider_drilling.twin.regular_checks import RegularChecks, is_plain

EVERY, FIRST = 150.0, 960.0


def tree(*effects, group=(), growing=False, torque=(600.0, 300.0, 100.0)):
    """What a diagnosis says that names these effects, of which the torque tells most; its three models."""
    with_effect = torque[2] if effects else None
    rms = {
        "surface_torque": {"nominal": torque[0], "tuned": torque[1], "with_effect": with_effect},
        "hook_load": {"nominal": 5000.0, "tuned": 5000.0, "with_effect": 4900.0 if effects else None},
        "tool_face": {"nominal": 3.0, "tuned": 3.0, "with_effect": 0.1 if effects else None},
    }
    noise = {"surface_torque": {"value": 100.0}, "hook_load": {"value": 4000.0}, "tool_face": {"value": 0.1}}
    ranking = [{"in_answer": True, "group": list(group)}] if effects else []
    return {"verdict": "effect" if effects else "none", "effects": list(effects), "ranking": ranking, "suspected": [],
            "site": "sensor" if effects else None,
            "gap": {"rms": rms, "noise_floor": noise, "tuned": 2.0, "with_effect": 1.0, "threshold": 1.25},
            "change": {"growing": growing}}  # fmt: skip


def reply(*effects, **more):
    return Reply(tree(*effects, **more), PickledBaseline(b""), None)


FAILED = Reply(None, None, "a connection takes nearly all of it")


@pytest.fixture
def checks():
    """Checks of a rig that has been followed since 0 s."""
    checks = RegularChecks(EVERY)
    checks.begin(0.0)
    return checks


def take(checks, *replies):
    """What the last of these replies confirms, one every 150 s from 1000 s on."""
    return [checks.take(each, 1000.0 + EVERY * row) for row, each in enumerate(replies)][-1]


def test_first_check_needs_a_rig_as_it_was_and_five_minutes_more(checks):
    assert checks.due(FIRST - 1.0) is None
    windows = checks.due(FIRST)
    assert windows.before == (0.0, 640.0) and windows.after == (FIRST - 300.0, FIRST)


def test_checks_are_regular(checks):
    times = [time for time in range(3000) if checks.due(float(time)) is not None]
    assert times[:3] == [960, 1110, 1260]


def test_no_check_before_the_rig_is_learnt_or_without_a_period():
    assert RegularChecks(EVERY).due(1e6) is None
    never = RegularChecks(0.0)
    never.begin(0.0)
    assert never.due(1e6) is None


def test_one_name_may_be_chance(checks):
    assert take(checks, reply(), reply("heave")) is None


def test_same_name_twice_in_a_row_is_a_change(checks):
    found = take(checks, reply(), reply("heave"), reply("heave"))
    assert [answer["effects"] for answer in found.answers] == [["heave"], ["heave"]]


@pytest.mark.parametrize("between", [reply(), reply("washout")])
def test_another_answer_between_them_breaks_the_row(checks, between):
    assert take(checks, reply("heave"), between, reply("heave")) is None


def test_name_of_what_calibration_explains_as_well_does_not_count(checks):
    same = reply("heave", torque=(600.0, 120.0, 100.0))
    assert take(checks, reply("heave"), same, reply("heave")) is None and take(checks, same, same) is None


@pytest.mark.parametrize(("tuned", "with_effect", "plain"), [(2.0, 1.5, True), (2.0, 1.65, False), (1.0, 0.8, False)])
def test_change_closes_half_of_what_calibration_leaves(tuned, with_effect, plain):
    assert is_plain({**tree("heave")["gap"], "tuned": tuned, "with_effect": with_effect}) is plain


def test_check_without_an_answer_breaks_no_row(checks):
    assert take(checks, reply("heave"), FAILED, reply("heave")) is not None


def test_name_that_the_other_check_only_holds_possible_is_not_enough(checks):
    assert take(checks, reply("stribeck"), reply("static_aging", group=["stribeck"])) is None


def test_change_began_since_the_last_check_that_named_none(checks):
    found = take(checks, reply(), reply(), reply("heave"), reply("heave"))
    assert found.interval == (1000.0 + EVERY - 300.0, 1000.0 + 2.0 * EVERY)


def test_change_that_the_first_check_names_began_after_the_rig_was_as_it_was(checks):
    assert take(checks, reply("heave"), reply("heave")).interval == (640.0, 1000.0)


def test_channel_is_the_one_at_surface_that_the_change_explains_best(checks):
    found = take(checks, reply("heave"), reply("heave", torque=(900.0, 500.0, 300.0), growing=True))
    assert (found.channel, found.kind, found.size) == ("surface_torque", "ramp", pytest.approx(4.0))


def test_rig_as_it_was_is_renewed_for_a_rig_wanders(checks):
    checks.take(reply(), 1000.0)
    assert checks.due(2300.0).before == (0.0, 640.0)
    assert checks.due(2500.0).before == (1540.0, 2180.0) and checks.baseline is None


def test_rig_as_it_was_stays_while_a_name_waits_to_be_confirmed(checks):
    checks.take(reply("heave"), 2390.0)
    assert checks.due(2500.0).before == (0.0, 640.0)


def test_samples_that_show_no_rig_are_left_for_later_ones(checks):
    checks.due(FIRST)
    checks.take(FAILED, FIRST)
    assert checks.due(FIRST + EVERY).before == (0.0, 640.0)
    checks.take(FAILED, FIRST + EVERY)
    assert checks.due(FIRST + EVERY - 1.0) is None
    assert checks.due(FIRST + EVERY).before == (EVERY, EVERY + 640.0)


def test_failure_later_on_leaves_the_rig_as_it_was(checks):
    for time in (FIRST, FIRST + EVERY, FIRST + 2 * EVERY):
        checks.take(reply() if time == FIRST else FAILED, time)
    assert checks.due(FIRST + 3 * EVERY).before == (0.0, 640.0) and checks.baseline is not None


class Answers:
    """Stands for the other process, which `test_background` tests: every question has the same answer, 10 s later."""

    def __init__(self, *effects):
        self._reply = replace(reply(*effects), cpu=10.0)
        self.questions = []

    def start(self, question):
        self.questions.append(question)

    def wait(self):
        return self._reply

    def poll(self):
        return None

    def end(self):
        """Nothing runs."""


def diagnoser(request, monkeypatch, *effects, dated=lambda low, high: None, told=lambda question: None):
    """A replay of half an hour, with checks from the start, whose diagnoses all name these effects."""
    rig = load_rig(request.config.rootpath / "config" / "rig.short.yaml")
    buffers, log = new_buffers(3600.0), DetectionLog()
    times = np.arange(0.0, 1800.0, 0.5)
    buffers["top_drive_angle"].add(times, np.sin(times))
    answers = Answers(*effects)
    monkeypatch.setattr("slider_drilling.twin.diagnoser.BackgroundDiagnosis", lambda: answers)
    made = Diagnoser(diagnose_after, rig, buffers, log, True, EVERY, dated, told)
    made.checks.begin(0.0)
    made.questions = answers.questions
    return made, log


def run(made, *times):
    for time in times:
        made.update(time)


def test_second_check_makes_a_named_detection(request, monkeypatch):
    made, log = diagnoser(request, monkeypatch, "heave")
    run(made, FIRST, FIRST + 100.0)
    assert not log.detections and made.answer is None and not made.asking
    run(made, FIRST + EVERY, FIRST + EVERY + 100.0)
    (detection,) = log.detections
    assert detection.effects == ("heave",) and detection.verdict == "effect" and made.answer["effects"] == ["heave"]
    assert detection.detected == detection.answered == FIRST + EVERY + 100.0
    assert detection.interval == (640.0, FIRST) and detection.since == 800.0
    assert made.checks.due(FIRST + 700.0) is None


def test_later_questions_about_it_compare_with_the_same_rig_and_ask_for_no_channel(request, monkeypatch):
    made, log = diagnoser(request, monkeypatch, "heave")
    run(made, FIRST, FIRST + 100.0, FIRST + EVERY, FIRST + EVERY + 100.0, FIRST + EVERY + 130.0)
    asked = made.questions[-1]
    assert made.asking and len(made.questions) == 3 and asked.since.channel is None
    assert asked.before == PickledBaseline(b"") and asked.since.interval == (640.0, FIRST)
    begins = asked.since.log_start
    assert asked.onset.changed_from + begins == FIRST and begins * 1e9 == asked.after.start_ns
    assert log.detections[0].channel == "surface_torque"


def test_rig_shows_how_it_is_a_minute_after_the_twin_began(checks):
    checks.follow_from(100.0)
    assert checks.due(FIRST + 159.0) is None and checks.due(FIRST + 160.0).before == (160.0, 800.0)


def test_feature_dates_what_checks_have_found(request, monkeypatch):
    seen = FeatureChange(9.0, 800.0, (790.0, 815.0), "step", 2.0, in_operation=False)
    made, log = diagnoser(
        request, monkeypatch, "heave", dated=lambda low, high: seen if low <= 800.0 <= high else None
    )
    run(made, FIRST, FIRST + 100.0, FIRST + EVERY, FIRST + EVERY + 100.0)
    assert (log.detections[0].since, log.detections[0].interval) == (800.0, (790.0, 815.0))


def test_rig_that_stays_as_it_was_is_no_detection(request, monkeypatch):
    told = []
    made, log = diagnoser(request, monkeypatch, told=told.append)
    run(made, *np.arange(FIRST, FIRST + 2 * EVERY, 50.0))
    assert not log.detections and made.answer is None and len(told) == 2
    assert all(question.number is None and question.change is None and question.error is None for question in told)


def test_check_gives_way_to_a_question_of_the_user(request, monkeypatch):
    made, log = diagnoser(request, monkeypatch, "heave")
    run(made, FIRST)
    made.ask_now(FIRST + 1.0)
    assert made.asking
    made.take_held_reply()
    assert made.answer["effects"] == ["heave"] and not log.detections and not made.asking
    assert made.answered == FIRST + 11.0
