"""What a user is told: nothing that the figures beside it do not say, on console, in diagnosis.json and on the page."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.diagnosis import sentences
from slider_drilling.diagnosis.diagnose import Diagnosis
from slider_drilling.diagnosis.figures import intervals, waterfall
from slider_drilling.diagnosis.page import report_page, simulated_rows
from slider_drilling.diagnosis.result import (
    ChannelErrors,
    ChannelNoise,
    ChannelTrace,
    ClosedShare,
    FittedParameter,
    Gap,
    Outcome,
    RankedEffect,
    ResidualShape,
    Where,
)
from slider_drilling.diagnosis.rig_source import RigSource, find_rig_source, rig_remarks
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.effects import CuttingsBed, Effects
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import RigLog
from slider_drilling.pages import page_html
from slider_drilling.rig import dump_rig, load_rig
from slider_drilling.units import FIELD, SI


def worn_motor() -> Outcome:
    """A motor that gives 24 % less torque per pressure, with rivals."""
    deg = math.pi / 180.0
    motor = RankedEffect("motor_wear", "motor", True, True, (), 0.92, (0.64, 0.97), {
        "motor_wear.torque_loss": FittedParameter(0.24, "-", 0.0, (0.21, 0.27)),
        "motor_wear.extra_leak": FittedParameter(0.0, "-", 0.0),
    }, ())  # fmt: skip
    rival = RankedEffect("formation_change", "bit", True, False, ("motor_wear explains it better",), 0.4, (-2.0, 0.5), {
        "formation_change.factor": FittedParameter(0.8, "-", 1.0),
        "formation_change.time": FittedParameter(3.0, "s", 200.0),
    }, ())  # fmt: skip
    screened = RankedEffect("heave", "draw_works", False, False, ("not fitted",), None, None, {}, ())
    gap = Gap(
        9.0, 8.0, 1.1, 0.92, (0.64, 0.97), 1.2,
        {"tool_face": ChannelNoise(0.02, 0.02, "rad", "declared"),
         "hook_load": ChannelNoise(4e3, 3e3, "N", "differences")},
        {"tool_face": ChannelErrors("rad", 130.0 * deg, 118.0 * deg, 3.0 * deg),
         "hook_load": ChannelErrors("N", 9e3, 8e3, 4e3)},
    )  # fmt: skip
    time = np.arange(0.0, 40.0, 0.1)
    stages = {"nominal": np.cos(time), "tuned": 0.5 * np.cos(time), "with_effect": np.sin(time)}
    errors = {stage: {"tool_face": 0.1, "hook_load": 2e3} for stage in stages}
    return Outcome(
        "effect", "motor", ("motor_wear",), gap=gap, ranking=(motor, rival, screened),
        where=Where({"tool_face": 0.9, "hook_load": 0.1}, {"still": 1.0}, {"above": 1.0},
                    ({"from": 0.0, "to": 40.0, "share": 1.0},),
                    ({"from": 0.0, "to": 900.0, "share": 1.0, "change": 0.3},)),
        tuned_parameters={"friction_1": FittedParameter(1.12, "-", 1.0),
                          "motor_wear.torque_loss": FittedParameter(0.24, "-", 0.0)},
        simulated={"share": 0.5, "fitted": errors, "rest": errors, "whole": errors,
                   "freed": {"nominal": 0, "tuned": 9, "with_effect": 11}},
        traces=(ChannelTrace(0, "tool_face", "rad", time, np.sin(time), stages, 20.0),
                ChannelTrace(0, "hook_load", "N", time, np.sin(time), stages, 20.0)),
        runtime=12.0,
    )  # fmt: skip


def diagnosis_of(outcome: Outcome) -> Diagnosis:
    rig = load_rig(installed_file("config/rig.example.yaml"))
    return Diagnosis(("a/run.mcap",), rig, RigSource("own.yaml", "given", "b/own.yaml"), (), outcome)


def test_the_driller_reads_cause_error_and_share_first():
    assert sentences.driller(worn_motor()) == (
        "The motor gives 24 % less torque per pressure than the file says; with that in, toolface error falls from "
        "118 to 3.0 deg and 92 % [64, 97] of the gap is closed."
    )
    assert sentences.sentence(worn_motor()) == (
        "effect: motor_wear, closes 0.92 [0.64, 0.97] (E = 9.00 as given, 8.00 re-tuned, 1.10 with it; noise alone "
        "stays below 1.20)."
    )


def test_a_group_is_told_with_its_rivals():
    outcome = worn_motor()
    group = replace(outcome, ranking=(replace(outcome.ranking[0], group=("formation_change",)),))
    assert "(or formation change: this log cannot tell them apart)" in sentences.driller(group)


def test_a_share_that_cannot_be_said_gets_no_percentage():
    outcome = worn_motor()
    assert outcome.gap is not None
    nothing = replace(outcome, gap=replace(outcome.gap, closed=None, closed_interval=None))
    assert "%" not in sentences.driller(nothing).partition(";")[2]
    assert sentences.format_share(replace(outcome.ranking[0], closed=None, interval=None)) == "-"


def test_what_an_effect_closes_of_runs_that_its_fit_has_not_seen_has_a_column_where_that_was_asked():
    outcome = worn_motor()
    asked = replace(outcome.ranking[0], other_runs=ClosedShare(0.71, (0.5, 0.83)))
    several = replace(outcome, ranking=(asked, *outcome.ranking[1:]))
    heads = sentences.share_headers(several.ranking)
    assert [sentences.share_cells(one, heads) for one in several.ranking] == [
        ("0.92 [0.64, 0.97]", "0.71 [0.50, 0.83]"), ("0.40 [-2.00, 0.50]", "-"), ("-", "-"),
    ]  # fmt: skip
    assert heads[1] in page_html(report_page(diagnosis_of(several)), SI)
    assert heads[1] not in page_html(report_page(diagnosis_of(outcome)), SI)
    assert sentences.share_headers(outcome.ranking) == heads[:1]


def test_what_was_found_beside_another_says_of_which_gap_it_closes_a_share():
    outcome = worn_motor()
    second = replace(outcome.ranking[1], beside=("motor_wear",))
    heads = sentences.share_headers((outcome.ranking[0], second))
    assert heads == ("closes [95 %]", "of what is left by")
    assert sentences.share_cells(outcome.ranking[0], heads)[1] == "re-tuning"
    assert sentences.share_cells(second, heads)[1] == "motor wear"
    chart = intervals((outcome.ranking[0], second))
    assert chart is not None
    assert chart.panels[0].marks[0].x == ("motor wear", f"{second.effect.replace('_', ' ')} beside motor wear")
    assert "of the gap that these leave" in chart.caption
    assert "that these leave" not in intervals(outcome.ranking).caption


def test_what_closes_more_than_all_closes_the_whole_gap():
    assert sentences.closed_in_words(1.02, (1.01, 1.03)) == "the whole gap is closed"
    assert sentences.closed_in_words(0.97, (0.9, 1.01)) == "97 % [90, 101] of the gap is closed"


def test_what_an_unknown_leaves_is_told_with_its_channel_site_and_shape():
    outcome = replace(worn_motor(), verdict="unknown", site="hydraulics", effects=(), ranking=())
    text = sentences.driller(outcome)
    assert "118 deg of toolface" in text
    assert "the hydraulics" in text
    drawn = ("pressure lost at 2 bar/min", "time, s", "pressure, bar", np.arange(3.0), np.arange(3.0))
    shape = ResidualShape("unknown", *drawn)
    assert "pressure lost at 2 bar/min" in sentences.driller(replace(outcome, shape=shape))
    remains = replace(worn_motor(), verdict="effect_and_unknown")
    assert sentences.driller(remains).startswith("It acts as if the motor gives 24 % less")
    assert sentences.driller(remains).endswith("remains, most of it in toolface.")
    rest = replace(remains, shape=ResidualShape("rest", *drawn))
    assert sentences.driller(rest).endswith("most of it in toolface; it looks like this: pressure lost at 2 bar/min.")
    assert sentences.sentence(rest).endswith("something structured remains: pressure lost at 2 bar/min.")
    assert "explain as much" not in sentences.driller(rest) + sentences.sentence(rest)
    alike = replace(remains, shape=ResidualShape("alternative", *drawn))
    assert sentences.driller(alike).endswith("Something else would explain as much: pressure lost at 2 bar/min.")
    assert "remains" not in sentences.driller(alike) + sentences.sentence(alike)
    assert sentences.sentence(alike).endswith("pressure lost at 2 bar/min: explains as much.")
    page = page_html(report_page(diagnosis_of(alike)), SI)
    assert "What else would explain as much" in page and "What the unknown looks like" not in page


@pytest.mark.parametrize(("tuned", "says"), [(1.1, "as closely as noise"), (1.4, "1.40 times the noise")])
def test_re_tuning_is_said_to_reach_the_noise_only_where_it_does(tuned, says):
    outcome = worn_motor()
    assert outcome.gap is not None
    gap = replace(outcome.gap, tuned=tuned, with_effect=None, closed=None, closed_interval=None)
    text = sentences.driller(replace(outcome, verdict="parameters", effects=(), gap=gap))
    assert says in text
    assert "friction 1 is 1.12 times the file's" in text
    assert ("as closely" in text) == (tuned <= 1.2)
    assert "reaches" not in sentences.sentence(replace(outcome, verdict="parameters", effects=(), gap=gap))


@pytest.mark.parametrize(("interval", "told"), [((0.9, 1.4), False), ((1.05, 1.2), True), (None, True)])
def test_a_re_tuned_value_that_may_as_well_be_the_file_s_is_not_told(interval, told):
    outcome = worn_motor()
    tuned = {
        "friction_1": FittedParameter(1.12, "-", 1.0, interval),
        "axial_damping": FittedParameter(1.4, "-", 1.0, (1.2, 1.6)),
    }
    text = sentences.driller(replace(outcome, verdict="parameters", effects=(), tuned_parameters=tuned))
    assert ("friction 1 is 1.12 times the file's" in text) == told
    assert "axial damping is 1.40 times the file's" in text


def test_two_effects_are_one_sentence():
    outcome = worn_motor()
    both = replace(outcome, effects=("motor_wear", "formation_change"))
    assert "than the file says, and from 3 s on the rock takes 0.800 times the weight" in sentences.driller(both)


def test_how_far_the_model_foretells_is_said():
    outcome = replace(worn_motor(), horizon={"tool_face": 35.2})
    (ahead,) = sentences.prediction_horizon(outcome)
    assert "toolface 35 s" in ahead
    assert "own spread: toolface 35 s." in page_html(report_page(diagnosis_of(outcome)), SI)
    assert sentences.prediction_horizon(worn_motor()) == []
    several = replace(outcome, horizon={"tool_face": 35.2, "hook_load": 40.0}, foretold=("hook_load",))
    ahead, all_of_it = sentences.prediction_horizon(several)
    assert "hook load" not in ahead and "40 s" not in ahead
    assert all_of_it == "To the end of the log the model's error stays below the channel's own spread: hook load."
    assert len(sentences.prediction_horizon(replace(several, foretold=("tool_face", "hook_load")))) == 1


def test_an_answer_of_nothing_says_why():
    outcome = Outcome("inconclusive", remarks=("the top drive turned 0.01 rad in all",))
    assert "0.01 rad" in sentences.driller(outcome)
    assert "0.01 rad" in sentences.sentence(outcome)


@pytest.mark.parametrize(("interval", "told"), [
    ((0.0, 0.8), False), ((0.05, 0.6), False), ((0.3, 0.8), True), ((-0.1, 0.3), False), (None, True),
])  # fmt: skip
def test_a_leak_is_told_where_the_log_tells_how_much(interval, told):
    outcome = worn_motor()
    motor = outcome.ranking[0]
    leaks = {**motor.parameters, "motor_wear.extra_leak": FittedParameter(0.5, "-", 0.0, interval)}
    text = sentences.driller(replace(outcome, ranking=(replace(motor, parameters=leaks), *outcome.ranking[1:])))
    assert ("loses 50 % more of its speed" in text) == told


def test_the_tree_is_plain_json_with_every_key_documented(repository):
    tree = to_json(diagnosis_of(worn_motor()))
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree
    page = (repository / "docs" / "reference" / "diagnosis.md").read_text()
    for key in tree:
        assert f"`{key}`" in page, key
    for block in (tree["gap"], tree["ranking"][0], tree["rig"]):
        for key in block:
            assert f"`{key}`" in page, key
    assert tree["rig"] == {"name": "own.yaml", "source": "given", "path": "b/own.yaml"}
    assert [(row["passed"], row["in_answer"]) for row in tree["ranking"]] == [
        (True, True),
        (True, False),
        (False, False),
    ]
    assert tree["ranking"][0]["parameters"]["torque_loss"] == {
        "value": 0.24, "unit": "-", "nominal": 0.0, "interval": [0.21, 0.27],
    }  # fmt: skip
    empty = to_json(diagnosis_of(Outcome("inconclusive")))
    assert set(empty) == set(tree)
    assert set(empty["gap"]) == set(tree["gap"])


def test_the_page_begins_with_the_driller_and_marks_only_the_answer_green():
    html = page_html(report_page(diagnosis_of(worn_motor())), SI)
    lead = html.index("The motor gives 24 % less torque")
    assert lead < html.index("effect: motor_wear")
    assert html.count('class="tag good"') == 1
    assert "passed" in html
    assert "own.yaml (given)" in html
    assert "118 deg" in html
    assert "heave: not fitted." in html
    assert "klbf" in page_html(report_page(diagnosis_of(worn_motor())), FIELD)
    assert "No conclusion" in page_html(report_page(diagnosis_of(Outcome("inconclusive"))), SI)


def test_the_winners_interval_lies_on_its_axis_and_others_are_cut_with_their_number():
    outcome = worn_motor()
    best = replace(outcome.ranking[0], closed=0.9, interval=(-0.9, 1.3))
    chart = intervals((best, outcome.ranking[1]))
    assert chart is not None
    (bars,) = chart.panels[0].marks
    assert chart.x_limits is not None
    assert chart.x_limits[0] < -0.9 < 1.3 < chart.x_limits[1]
    assert bars.base[0] == pytest.approx(-0.9)
    assert "←" not in bars.text[0]
    assert bars.text[1] == "← 0.40 [-2.00, 0.50]"
    assert bars.base[1] == pytest.approx(-0.9)
    assert bars.colours == ("green", "grey")
    assert intervals(outcome.ranking[2:]) is None


def test_a_bar_below_what_noise_reaches_is_explained():
    gap = worn_motor().gap
    assert gap is not None
    assert "below the dotted line" in waterfall(gap).caption
    assert waterfall(replace(gap, with_effect=None)).caption == ""


def test_errors_of_what_was_not_fitted_are_told_apart():
    heads, rows = simulated_rows(worn_motor())
    assert heads[:2] == ("part", "channel")
    assert rows[0][2:] == (0, 9, 11)
    assert [row[0] for row in rows[1:]] == [
        "first 50 %, fitted", "first 50 %, fitted", "the rest, not fitted", "the rest, not fitted",
        "whole log", "whole log",
    ]  # fmt: skip


def test_the_rig_file_is_told_with_where_it_came_from():
    rig = load_rig(installed_file("config/rig.example.yaml"))
    bed = replace(rig, effects=dataclasses.replace(Effects(), cuttings_bed=CuttingsBed(2.0, 2400.0, 2600.0)))
    attached = RigLog("d/run.mcap", 0, dump_rig(bed), "d/run.mcap: rig.yaml", {"recorded_by": "slider-drilling run"})
    origin = find_rig_source([attached], bed)
    assert origin == RigSource("rig.yaml in run.mcap", "attached", "d/run.mcap")
    says = rig_remarks(origin, [attached], bed)
    assert "the one it was recorded with (slider-drilling run)" in says[0]
    assert "cuttings_bed" in says[1]
    assert "--rig" in says[1]
    given = replace(attached, rig_source="e/own.yaml")
    assert find_rig_source([given], bed) == RigSource("own.yaml", "given", "e/own.yaml")
    assert find_rig_source([given], rig) == RigSource("the rig given", "given", None)
    assert rig_remarks(find_rig_source([given], rig), [given], rig) == []


def test_an_error_that_falls_by_less_than_two_digits_show_is_not_told():
    outcome = worn_motor()
    assert outcome.gap is not None
    rms = {name: replace(one, with_effect=None if one.tuned is None else 0.9999 * one.tuned)
           for name, one in outcome.gap.rms.items()}  # fmt: skip
    told = sentences.driller(replace(outcome, gap=replace(outcome.gap, rms=rms)))
    assert "falls from" in sentences.driller(outcome) and "falls from" not in told
    assert "; with that in, 92 %" in told


def test_an_e_that_noise_could_leave_does_not_say_that_noise_left_it():
    outcome = worn_motor()
    assert outcome.gap is not None
    gap = replace(outcome.gap, tuned=1.1, with_effect=None, closed=None, closed_interval=None, threshold=1.2,
                  stand_out=("standpipe_pressure",))  # fmt: skip
    unknown = replace(outcome, verdict="unknown", effects=(), gap=gap)
    said = "noise alone stays below 1.20, but what is left of standpipe pressure is not noise)."
    assert sentences.sentence(unknown).endswith(said)
    assert "not noise" not in sentences.sentence(replace(unknown, gap=replace(gap, tuned=1.3)))
    assert "not noise" not in sentences.sentence(replace(unknown, verdict="parameters"))
    assert "not noise" not in sentences.sentence(replace(unknown, gap=replace(gap, stand_out=())))
    assert to_json(diagnosis_of(unknown))["gap"]["stand_out"] == ["standpipe_pressure"]


def test_a_re_tuning_that_went_far_says_what_it_may_stand_for():
    outcome = worn_motor()
    assert outcome.gap is not None
    gap = replace(outcome.gap, tuned=1.05, with_effect=None, closed=None, closed_interval=None)
    far = replace(outcome, verdict="parameters", effects=(), instead=("motor_wear",), gap=gap)
    assert sentences.driller(far).endswith(
        "That takes values far from the file's; they may stay near it if the motor gives 24 % less torque per pressure "
        "than the file says: this log cannot tell."
    )
    assert sentences.sentence(far).endswith("; they may stand for motor_wear.")
    assert to_json(diagnosis_of(far))["instead"] == ["motor_wear"]
    assert to_json(diagnosis_of(outcome))["instead"] == []


def test_where_there_is_little_room_reasons_are_numbered():
    outcome = worn_motor()
    reasons = ["other", "not fitted"]
    assert sentences.candidate_status_by_number(outcome.ranking[0], reasons) == "in the answer"
    assert sentences.candidate_status_by_number(outcome.ranking[2], reasons) == "not (2)"
