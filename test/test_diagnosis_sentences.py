"""Sentences of a diagnosis on console, in diagnosis.json and on the page say no more than the figures beside them."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.diagnosis.figures import intervals, waterfall
from slider_drilling.diagnosis.page import report_page, whole_run_rows
from slider_drilling.diagnosis.ranking_table import (
    CLOSES,
    GAP_AFTER,
    OTHER_RUNS,
    candidate_status_by_number,
    format_share,
    share_cells,
    share_headers,
)
from slider_drilling.diagnosis.result import (
    ChannelErrors,
    ChannelNoise,
    ChannelTrace,
    ClosedShare,
    Diagnosis,
    FittedParameter,
    Gap,
    RankedEffect,
    ResidualShape,
)
from slider_drilling.diagnosis.rig_source import RigSource
from slider_drilling.diagnosis.sentences import (
    closed_in_words,
    model_error_allowed,
    prediction_horizon,
    summary,
    technical_summary,
)
from slider_drilling.files.installed_files import installed_file
from slider_drilling.gap import criteria_table
from slider_drilling.gap.results.breakdown import GapBreakdown
from slider_drilling.gap.results.whole_runs import WholeRunErrors
from slider_drilling.log import RigLog
from slider_drilling.log_checks import LogChecks, LogIssue
from slider_drilling.pages import page_html
from slider_drilling.rig import load_rig
from slider_drilling.units import FIELD, SI, Sentence

RIG = load_rig(installed_file("config/rig.example.yaml"))
SOURCE = RigSource("own.yaml", "given", "b/own.yaml")
DEG = math.pi / 180.0


def inconclusive(*issues: str) -> Diagnosis:
    """A diagnosis that ended with the checks of its log."""
    checks = LogChecks(RigLog("a/run.mcap", 0), tuple(LogIssue("uninformative", "top_drive", text) for text in issues))
    return Diagnosis(("a/run.mcap",), RIG, SOURCE, (checks,), "inconclusive")


def worn_motor() -> Diagnosis:
    """A motor that gives 24 % less torque per pressure, with two other candidates."""
    motor = RankedEffect("motor_wear", "motor", True, True, (), 0.92, (0.64, 0.97), {
        "motor_wear.torque_loss": FittedParameter(0.24, "-", 0.0, (0.21, 0.27)),
        "motor_wear.extra_leak": FittedParameter(0.0, "-", 0.0),
    }, ())  # fmt: skip
    other = RankedEffect("formation_change", "bit", True, False, ("motor_wear explains it better",), 0.4, (-2.0, 0.5), {
        "formation_change.factor": FittedParameter(0.8, "-", 1.0),
        "formation_change.time": FittedParameter(3.0, "s", 200.0),
    }, ())  # fmt: skip
    screened = RankedEffect("heave", "draw_works", False, False, ("not fitted",), None, None, {}, ())
    gap = Gap(
        9.0, 8.0, 1.1, 0.92, (0.64, 0.97), 1.2,
        {"tool_face": ChannelNoise(0.02, 0.02, "rad", "declared"),
         "hook_load": ChannelNoise(4e3, 3e3, "N", "differences")},
        {"tool_face": ChannelErrors("rad", 130.0 * DEG, 118.0 * DEG, 3.0 * DEG),
         "hook_load": ChannelErrors("N", 9e3, 8e3, 4e3)},
    )  # fmt: skip
    time = np.arange(0.0, 40.0, 0.1)
    stages = {"nominal": np.cos(time), "tuned": 0.5 * np.cos(time), "with_effect": np.sin(time)}
    errors = {stage: {"tool_face": 0.1, "hook_load": 2e3} for stage in stages}
    return Diagnosis(
        ("a/run.mcap",), RIG, SOURCE, (), "effect", "motor", ("motor_wear",), gap=gap, ranking=(motor, other, screened),
        breakdown=GapBreakdown({"tool_face": 0.9, "hook_load": 0.1}, {"still": 1.0}, {"above": 1.0},
                               [{"from": 0.0, "to": 40.0, "share": 1.0}],
                               [{"from": 0.0, "to": 900.0, "share": 1.0, "change": 0.3}]),
        tuned_parameters={"friction_1": FittedParameter(1.12, "-", 1.0),
                          "motor_wear.torque_loss": FittedParameter(0.24, "-", 0.0)},
        whole_run_errors=WholeRunErrors(0.5, errors, errors, errors, {"nominal": 0, "tuned": 9, "with_effect": 11},
                                        {}, (), SimpleNamespace(), {}),
        traces=(ChannelTrace(0, "tool_face", "rad", time, np.sin(time), stages, 20.0),
                ChannelTrace(0, "hook_load", "N", time, np.sin(time), stages, 20.0)),
        runtime=12.0,
    )  # fmt: skip


def says(diagnosis: Diagnosis) -> str:
    return str(summary(diagnosis))


def test_summary_states_cause_error_and_closed_share():
    assert says(worn_motor()) == (
        "The motor gives 24 % less torque per pressure than the file says. With that in the model, toolface error "
        "falls from 118 deg to 3.0 deg and 92 % [64, 97] of the gap is closed."
    )


def test_fed_back_errors_are_told_from_free_runs():
    worn = replace(worn_motor(), fed_back="surface_torque")
    assert "toolface error, predicted from the surface torque measured so far, falls from 118 deg" in says(worn)
    assert "(in one free simulation of the whole log from " in says(worn)
    assert "E with the measured surface torque fed back " in technical_summary(worn)
    assert "measured surface torque is fed back weakly" in page_html(report_page(worn), SI)
    assert "fed back" not in technical_summary(worn_motor()) and "free simulation" not in says(worn_motor())


def test_technical_summary_states_effect_and_e():
    text = technical_summary(worn_motor())
    for figure in ("motor_wear", "0.92 [0.64, 0.97]", "9.00 as given", "8.00", "1.10", "1.20"):
        assert figure in text


def test_summary_is_written_in_the_readers_units():
    bed = RankedEffect("cuttings_bed", "contact", True, True, (), 0.92, None, {
        "cuttings_bed.factor": FittedParameter(2.0, "-", 1.0),
        "cuttings_bed.top": FittedParameter(2663.0, "m", 0.0),
        "cuttings_bed.bottom": FittedParameter(3213.0, "m", 0.0),
    }, ())  # fmt: skip
    text = summary(replace(worn_motor(), effects=("cuttings_bed",), ranking=(bed,)))
    assert "between 2663 m and 3213 m" in str(text)
    assert "between 8737 ft and 10541 ft" in FIELD.convert_text(text)


def test_group_is_named_with_its_effect():
    diagnosis = worn_motor()
    group = replace(diagnosis, ranking=(replace(diagnosis.ranking[0], group=("formation_change",)),))
    assert "(or formation change: this log cannot distinguish them)" in says(group)


def test_unknown_closed_share_has_no_percentage():
    diagnosis = worn_motor()
    nothing = replace(diagnosis, gap=replace(diagnosis.gap, closed=None, closed_interval=None))
    assert "%" not in says(nothing).partition("With that")[2]
    assert format_share(replace(diagnosis.ranking[0], closed=None, interval=None)) == "-"


def test_other_runs_have_a_column_with_several_runs():
    diagnosis = worn_motor()
    in_others = replace(diagnosis.ranking[0], other_runs=ClosedShare(0.71, (0.5, 0.83)))
    several = replace(diagnosis, ranking=(in_others, *diagnosis.ranking[1:]))
    headers = share_headers(several.ranking)
    assert headers == (CLOSES, OTHER_RUNS)
    assert [share_cells(ranked, headers) for ranked in several.ranking] == [
        ("0.92 [0.64, 0.97]", "0.71 [0.50, 0.83]"), ("0.40 [-2.00, 0.50]", "-"), ("-", "-"),
    ]  # fmt: skip
    assert f'data-head="{OTHER_RUNS}"' in page_html(report_page(several), SI)
    assert f'data-head="{OTHER_RUNS}"' not in page_html(report_page(diagnosis), SI)
    assert share_headers(diagnosis.ranking) == (CLOSES,)


def test_effect_found_second_names_the_gap_it_closes():
    diagnosis = worn_motor()
    second = replace(diagnosis.ranking[1], known_before=("motor_wear",))
    headers = share_headers((diagnosis.ranking[0], second))
    assert headers == (CLOSES, GAP_AFTER)
    assert share_cells(diagnosis.ranking[0], headers)[1] == "calibration"
    assert share_cells(second, headers)[1] == "motor wear"
    chart = intervals((diagnosis.ranking[0], second))
    assert chart is not None
    assert chart.panels[0].marks[0].x == ("motor wear", "formation change after motor wear")
    assert "gap that this effect leaves" in chart.caption
    assert "gap that this effect leaves" not in intervals(diagnosis.ranking).caption


def test_more_than_all_is_the_whole_gap():
    assert closed_in_words(1.02, (1.01, 1.03)) == "the whole gap is closed"
    assert closed_in_words(0.97, (0.9, 1.01)) == "97 % [90, 101] of the gap is closed"


def test_unknown_states_channel_and_site():
    text = says(replace(worn_motor(), verdict="unknown", site="hydraulics", effects=(), ranking=()))
    assert "118 deg of toolface" in text
    assert "the hydraulics" in text


def shaped(of: str) -> ResidualShape:
    time = 60.0 * np.arange(3.0)
    return ResidualShape(of, "pressure lost over time", time, 2e5 * np.arange(3.0), "s", "Pa")


def test_residual_shape_is_described_with_its_numbers():
    curve = "pressure lost over time: rises by 2.0 bar per minute"
    unknown = replace(worn_motor(), verdict="unknown", effects=(), ranking=(), residual_shape=shaped("unknown"))
    assert says(unknown).endswith(f"It looks like this: {curve}.")
    remains = replace(worn_motor(), verdict="effect_and_unknown")
    assert says(remains).startswith("The rig behaves as if the motor gives 24 % less")
    assert says(remains).endswith("remains, mostly in toolface.")
    rest = replace(remains, residual_shape=shaped("rest"))
    assert says(rest).endswith(f"mostly in toolface; it looks like this: {curve}.")
    assert "psi per minute" in FIELD.convert_text(summary(rest))


def test_alternative_replaces_the_remainder():
    alternative = replace(worn_motor(), verdict="effect_and_unknown", residual_shape=shaped("alternative"))
    assert says(alternative).endswith(
        "Something else would explain as much: pressure lost over time: rises by 2.0 bar per minute."
    )
    assert "remains" not in says(alternative) + technical_summary(alternative)
    assert "pressure lost over time" in technical_summary(alternative)
    page = page_html(report_page(alternative), SI)
    assert "What else would explain as much" in page and "What the unknown looks like" not in page


@pytest.mark.parametrize(("tuned", "expected"), [(1.1, "within the sensors' noise"), (1.4, "1.40 times the noise")])
def test_calibration_reaches_noise_only_below_threshold(tuned, expected):
    diagnosis = worn_motor()
    gap = replace(diagnosis.gap, tuned=tuned, with_effect=None, closed=None, closed_interval=None)
    text = says(replace(diagnosis, verdict="parameters", effects=(), gap=gap))
    assert expected in text
    assert "friction 1 is 1.12 times the rig file's" in text
    assert ("within the sensors" in text) == (tuned <= 1.2)


@pytest.mark.parametrize(("interval", "named"), [((0.9, 1.4), False), ((1.05, 1.2), True), (None, True)])
def test_calibrated_value_compatible_with_one_is_not_named(interval, named):
    tuned = {
        "friction_1": FittedParameter(1.12, "-", 1.0, interval),
        "axial_damping": FittedParameter(1.4, "-", 1.0, (1.2, 1.6)),
    }
    text = says(replace(worn_motor(), verdict="parameters", effects=(), tuned_parameters=tuned))
    assert ("friction 1 is 1.12 times the rig file's" in text) == named
    assert "axial damping is 1.40 times the rig file's" in text


def test_two_effects_share_one_sentence():
    both = replace(worn_motor(), effects=("motor_wear", "formation_change"))
    assert "than the file says, and from 3 s on the rock takes 0.800 times the weight" in says(both)


def test_models_own_error_is_stated_by_share():
    diagnosis = worn_motor()
    assert model_error_allowed(diagnosis) is None
    shares = {"surface_torque": 0.02, "standpipe_pressure": 0.02, "hook_load": 0.055}
    stated = replace(diagnosis, gap=replace(diagnosis.gap, model_error=shares))
    said = "wrong by 2 % of the spread of surface torque and standpipe pressure; 5.5 % of the spread of hook load ("
    assert said in (model_error_allowed(stated) or "")
    assert said in page_html(report_page(stated), SI)


def test_prediction_horizon_names_each_channel_once():
    diagnosis = worn_motor()
    assert prediction_horizon(diagnosis) == []

    def with_horizon(horizon: dict[str, float], to_end: tuple[str, ...] = ()) -> Diagnosis:
        errors = replace(diagnosis.whole_run_errors, horizon=horizon, predictable_to_end=to_end)
        return replace(diagnosis, whole_run_errors=errors)

    (ahead,) = prediction_horizon(with_horizon({"tool_face": 35.2}))
    assert "toolface 35 s" in ahead
    assert "toolface 35 s." in page_html(report_page(with_horizon({"tool_face": 35.2})), SI)
    both = {"tool_face": 35.2, "hook_load": 40.0}
    ahead, to_end = prediction_horizon(with_horizon(both, ("hook_load",)))
    assert "hook load" not in ahead and "40 s" not in ahead
    assert to_end.endswith("stays below the channel's own spread to the end of the log: hook load.")
    assert len(prediction_horizon(with_horizon(both, ("tool_face", "hook_load")))) == 1


def test_inconclusive_says_why():
    diagnosis = inconclusive("the top drive turned 0.01 rad in total")
    assert "0.01 rad" in says(diagnosis)
    assert "0.01 rad" in technical_summary(diagnosis)
    page = page_html(report_page(diagnosis), SI)
    assert "allows no conclusion" in page and "No conclusion:" not in page, "the reason stands once"


@pytest.mark.parametrize(("interval", "named"), [
    ((0.0, 0.8), False), ((0.05, 0.6), False), ((0.3, 0.8), True), ((-0.1, 0.3), False), (None, True),
])  # fmt: skip
def test_parameter_is_named_only_if_the_log_determines_it(interval, named):
    diagnosis = worn_motor()
    motor = diagnosis.ranking[0]
    leaks = {**motor.parameters, "motor_wear.extra_leak": FittedParameter(0.5, "-", 0.0, interval)}
    text = says(replace(diagnosis, ranking=(replace(motor, parameters=leaks), *diagnosis.ranking[1:])))
    assert ("loses 50 % more of its speed" in text) == named


def test_page_begins_with_the_summary_and_marks_only_the_answer():
    html = page_html(report_page(worn_motor()), SI)
    headline = html.index("The motor gives 24 % less torque")
    assert headline < html.index(technical_summary(worn_motor()).partition("(")[0])
    assert html.count('class="tag good"') == 1
    assert "passed" in html
    assert "own.yaml (given)" in html
    assert "118 deg" in html
    assert "heave: not fitted." in html
    assert "klbf" in page_html(report_page(worn_motor()), FIELD)


def test_page_ends_with_the_criteria_table():
    section = report_page(worn_motor()).sections[-1]
    assert section.title == "What an effect must pass before it is named" and section.collapsed
    (table,) = section.items
    assert table.rows == tuple(tuple(row) for row in criteria_table())


def test_interval_of_the_answer_lies_on_the_axis():
    diagnosis = worn_motor()
    best = replace(diagnosis.ranking[0], closed=0.9, interval=(-0.9, 1.3))
    chart = intervals((best, diagnosis.ranking[1]))
    assert chart is not None
    (bars,) = chart.panels[0].marks
    assert chart.x_limits is not None
    assert chart.x_limits[0] < -0.9 < 1.3 < chart.x_limits[1]
    assert bars.base[0] == pytest.approx(-0.9)
    assert "←" not in bars.text[0]
    assert bars.text[1] == "← 0.40 [-2.00, 0.50]"
    assert bars.base[1] == pytest.approx(-0.9)
    assert bars.colours == ("green", "grey")
    assert intervals(diagnosis.ranking[2:]) is None


def test_bar_below_the_null_threshold_is_explained():
    gap = worn_motor().gap
    assert gap.threshold is not None
    within = replace(gap, tuned=0.9 * gap.threshold)
    assert "E does not decide" in waterfall(within, named=True).caption
    assert "E does not decide" not in waterfall(within).caption
    assert "E does not decide" not in waterfall(replace(gap, tuned=1.1 * gap.threshold), named=True).caption
    assert waterfall(replace(gap, threshold=None)).caption == ""


def test_errors_of_fitted_and_unfitted_parts_are_separate():
    headers, rows = whole_run_rows(worn_motor())
    assert headers[:2] == ("part", "channel")
    assert rows[0][2:] == (0, 9, 11)
    assert [row[0] for row in rows[1:]] == [
        "first 50 %, fitted", "first 50 %, fitted", "the rest, not fitted", "the rest, not fitted",
        "whole log", "whole log",
    ]  # fmt: skip


def test_invisible_fall_of_the_error_is_not_named():
    diagnosis = worn_motor()
    rms = {name: replace(errors, with_effect=0.9999 * errors.tuned) for name, errors in diagnosis.gap.rms.items()}
    text = says(replace(diagnosis, gap=replace(diagnosis.gap, rms=rms)))
    assert "falls from" in says(diagnosis) and "falls from" not in text
    assert "With that in the model, 92 %" in text


def test_structured_residual_within_noise_level_is_said():
    diagnosis = worn_motor()
    gap = replace(diagnosis.gap, tuned=1.1, with_effect=None, closed=None, closed_interval=None, threshold=1.2,
                  misfit_channels=("standpipe_pressure",))  # fmt: skip
    unknown = replace(diagnosis, verdict="unknown", effects=(), gap=gap)
    clause = "standpipe pressure is not noise"
    assert clause in technical_summary(unknown)
    assert clause not in technical_summary(replace(unknown, gap=replace(gap, tuned=1.3)))
    assert clause not in technical_summary(replace(unknown, verdict="parameters"))
    assert clause not in technical_summary(replace(unknown, gap=replace(gap, misfit_channels=())))


def test_far_calibration_names_the_effects_it_may_hide():
    diagnosis = worn_motor()
    gap = replace(diagnosis.gap, tuned=1.05, with_effect=None, closed=None, closed_interval=None)
    far = replace(diagnosis, verdict="parameters", effects=(), masked_effects=("motor_wear",), gap=gap)
    assert says(far).endswith(
        "It takes values far from the rig file's. They may stay near it if the motor gives 24 % less torque per "
        "pressure than the file says: this log cannot distinguish the two."
    )
    assert "motor_wear" in technical_summary(far)


@pytest.mark.parametrize(
    ("tool_face", "hook_load", "words"),
    [
        (10.0, 4e3, "within the sensors' noise; the toolface is off by 10 deg, within the 15 deg"),
        (16.0, 4e3, "within the sensors' noise; the toolface is off by 16 deg, hardly more than the 15 deg"),
        (0.5, 8e3, "within the sensors' noise and what any rig and model are off by."),
    ],
)
def test_no_gap_is_told_as_it_is(tool_face, hook_load, words):
    rms = {
        "tool_face": ChannelErrors("rad", DEG, tool_face * DEG, None),
        "hook_load": ChannelErrors("N", 9e3, hook_load, None),
    }
    gap = replace(worn_motor().gap, tuned=1.1, with_effect=None, closed=None, closed_interval=None, rms=rms)
    assert words in says(replace(worn_motor(), verdict="parameters", effects=(), gap=gap))


def test_small_cause_explains_the_rest():
    diagnosis = worn_motor()
    gap = replace(diagnosis.gap, tuned=1.3, with_effect=None, closed=None, closed_interval=None)
    small = replace(diagnosis, verdict="parameters", effects=(), small_cause="motor_wear", gap=gap)
    assert says(small).endswith("than the file says: that explains the rest, and is too small to act on.")
    assert "motor_wear, too small to act on, explains the rest" in technical_summary(small)


def test_narrow_table_numbers_its_reasons():
    diagnosis = worn_motor()
    reasons = ["other", "not fitted"]
    assert candidate_status_by_number(diagnosis.ranking[0], reasons) == "in the answer"
    assert candidate_status_by_number(diagnosis.ranking[2], reasons) == "not (2)"


@pytest.mark.parametrize("verdict", ["none", "parameters", "effect", "effect_and_unknown", "unknown"])
def test_every_summary_ends_with_one_full_stop(verdict):
    diagnosis = replace(worn_motor(), verdict=verdict, residual_shape=shaped("unknown"))
    text = summary(diagnosis)
    assert isinstance(text, Sentence)
    assert str(text).endswith(".") and ".." not in str(text) and "  " not in str(text)
