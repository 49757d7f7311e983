"""Sentences of a diagnosis on console, in diagnosis.json and on the page say no more than the figures beside them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from diagnosis_example import DEG, inconclusive, shaped, worn_motor

from slider_drilling.diagnosis.page import report_page
from slider_drilling.diagnosis.ranking_table import format_share
from slider_drilling.diagnosis.result import (
    ChannelErrors,
    Diagnosis,
    FittedParameter,
    RankedEffect,
)
from slider_drilling.diagnosis.sentences import (
    closed_in_words,
    model_error_allowed,
    prediction_horizon,
    summary,
    technical_summary,
)
from slider_drilling.pages import Chart, page_html
from slider_drilling.units import FIELD, SI, Sentence


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


@pytest.mark.parametrize("verdict", ["none", "parameters", "effect"])
def test_no_sentence_takes_fed_back_runs_for_free_runs(verdict):
    fed, free = " while the measured surface torque is fed back", "(5.7 deg in one free simulation of the whole log)"
    worn = replace(worn_motor(), verdict=verdict, gap=replace(worn_motor().gap, tuned=1.1))
    assert fed not in says(worn) and free not in says(worn)
    text = says(replace(worn, fed_back="surface_torque"))
    assert fed in text
    assert (free in text) == (verdict != "effect"), "there the free run's errors stand beside those that fall"


def test_pictures_and_ranking_of_fed_back_runs_say_so():
    worn = replace(worn_motor(), fed_back="surface_torque")
    sections = {section.title: section for section in report_page(worn).sections}
    size, cause = sections["How large the gap is"].items, sections["Which effect causes it"].items
    charts = [item for item in (*size, *cause) if isinstance(item, Chart)]
    assert len(charts) == 2
    for captioned in (*charts, cause[0]):
        assert "measured surface torque is fed back" in str(captioned.caption)
    assert "measured surface torque is fed back" in str(sections["Where the gap lies"].items[0])
    assert page_html(report_page(worn_motor()), SI).count("fed back") == 0


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


def test_more_than_all_is_the_whole_gap():
    assert closed_in_words(1.02, (1.01, 1.03)) == "the whole gap is closed"
    assert closed_in_words(0.97, (0.9, 1.01)) == "97 % [90, 101] of the gap is closed"


def test_unknown_states_channel_and_site():
    text = says(replace(worn_motor(), verdict="unknown", site="hydraulics", effects=(), ranking=()))
    assert "118 deg of toolface" in text
    assert "the hydraulics" in text


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
        (45.0, 4e3, "within the sensors' noise; the toolface is off by 45 deg, more than the 15 deg"),
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


@pytest.mark.parametrize(
    ("offset", "words"),
    [
        (2.3e5, "276 kN more than the rig file explains: its tare leaves the block's weight in, or the string weighs"),
        (-9e4, "90 kN less than the rig file explains: its tare takes off too much, or the string weighs less"),
    ],
)
def test_weight_of_block_or_string_is_left_open(offset, words):
    worn = worn_motor()
    difference = 276e3 if offset > 0.0 else -90e3
    traces = tuple(
        replace(trace, measured=trace.simulated["nominal"] + difference) for trace in worn.traces
        if trace.channel == "hook_load"
    )  # fmt: skip
    tuned = {
        "string_weight": FittedParameter(1.06, "-", 1.0, (1.01, 1.1)),
        "hook_load_offset": FittedParameter(offset, "N", 0.0, (offset - 4e4, offset + 4e4)),
    }
    read = replace(worn, verdict="parameters", effects=(), tuned_parameters=tuned, traces=traces)
    assert words in says(read) and "weigh the block" in says(read)
    assert "string weight is" not in says(read), "which of the two it is cannot be known"
    usual = tuned | {"hook_load_offset": FittedParameter(1e4, "N", 0.0)}
    assert "string weight is 1.06 times" in says(replace(read, tuned_parameters=usual))
    assert "tare" not in says(replace(read, tuned_parameters=usual))


def test_small_cause_explains_the_rest():
    diagnosis = worn_motor()
    gap = replace(diagnosis.gap, tuned=1.3, with_effect=None, closed=None, closed_interval=None)
    small = replace(diagnosis, verdict="parameters", effects=(), small_cause="motor_wear", gap=gap)
    assert says(small).endswith("than the file says: that explains the rest, and is too small to act on.")
    assert "motor_wear, too small to act on, explains the rest" in technical_summary(small)


@pytest.mark.parametrize("verdict", ["none", "parameters", "effect", "effect_and_unknown", "unknown"])
def test_every_summary_ends_with_one_full_stop(verdict):
    diagnosis = replace(worn_motor(), verdict=verdict, residual_shape=shaped("unknown"))
    text = summary(diagnosis)
    assert isinstance(text, Sentence)
    assert str(text).endswith(".") and ".." not in str(text) and "  " not in str(text)
