"""What is different between two logs of one rig."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from short_well import coarse_meshes, routine_slide, short_rig

from slider_drilling.api.diagnose import diagnose
from slider_drilling.api.what_changed import parse_since, windows_at
from slider_drilling.diagnosis import baseline as baseline_module
from slider_drilling.diagnosis import change_answer, change_search
from slider_drilling.diagnosis.baseline import fit_baseline
from slider_drilling.diagnosis.catalogue import catalogue
from slider_drilling.diagnosis.change_answer import ChangedParameter
from slider_drilling.diagnosis.change_search import TriedChange, changed_beside, only_wandered
from slider_drilling.diagnosis.change_sentences import moved_clause
from slider_drilling.diagnosis.diagnose import tuned_rig
from slider_drilling.diagnosis.diagnose_change import diagnose_change
from slider_drilling.diagnosis.onset import Since
from slider_drilling.diagnosis.page import report_page
from slider_drilling.diagnosis.rig_changes import RIG_CHANGES, with_rig_changes
from slider_drilling.diagnosis.sentences import summary
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.diagnosis.undisturbed import calm_times
from slider_drilling.drillstring import Commands
from slider_drilling.effects import EFFECTS, effects_with
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Parameter
from slider_drilling.log.time_window import cut_time_window

BACKLASH = {"top_drive_backlash": {"angle": 0.4}}


def _log(folder, name, seed, share_of_pressure=1.0, **effects):
    """A routine slide of 100 s; share_of_pressure: of the circulating pressure, that a washout leaves."""
    rig = short_rig()
    hydraulics = replace(rig.hydraulics, reference_pressure=share_of_pressure * rig.hydraulics.reference_pressure)
    true = replace(rig, hydraulics=hydraulics, effects=effects_with(**effects))
    return routine_slide(folder / f"{name}.mcap", true, seed, 100.0)


@pytest.fixture(scope="module", autouse=True)
def coarse():
    with coarse_meshes():
        yield


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    return {
        "before": _log(folder, "before", 1), "same": _log(folder, "same", 2),
        "worn": _log(folder, "worn", 3, motor_wear={"torque_loss": 0.15}),
        "washout": _log(folder, "washout", 4, 0.95),
    }  # fmt: skip


@pytest.fixture(scope="module")
def baseline(logs):
    return fit_baseline([logs["before"]], short_rig())


def test_same_rig_is_not_different(baseline, logs):
    found = diagnose_change(baseline, [logs["same"]], short_rig())
    assert (found.verdict, found.effects) == ("none", ())


@pytest.mark.slow
@pytest.mark.parametrize(("torque", "pressure"), [(0.02, 1.0), (-0.02, 1.0), (0.01, 0.9975), (-0.01, 1.0025)])
def test_numbers_that_wander_get_no_name(baseline, tmp_path, torque, pressure):
    """Motor torque within two of its standard deviations, circulating pressure within one."""
    wandered = _log(tmp_path, "wandered", 7, pressure, motor_wear={"torque_loss": torque})
    assert diagnose_change(baseline, [wandered], short_rig()).effects == ()


def test_lost_motor_torque_is_the_change(baseline, logs):
    found = diagnose_change(baseline, [logs["worn"]], short_rig(), since=Since(1200.0, (1190.0, 1210.0)))
    assert found.effects == ("motor_wear",)
    loss = found.tuned_parameters["motor_wear.torque_loss"]
    assert loss.interval[0] <= 0.15 <= loss.interval[1]
    assert found.change.explained > 0.8
    assert str(summary(found)).startswith("What is different since 1200 s (1190 to 1210 s): the motor gives 1")
    assert "less torque per pressure than before" in str(summary(found))


@pytest.fixture(scope="module")
def washout(baseline, logs):
    return diagnose_change(baseline, [logs["washout"]], short_rig())


def test_washout_is_named_and_in_tuned_rig(washout):
    found = washout
    assert found.effects == ("washout",)
    assert tuned_rig(found).hydraulics.reference_pressure == pytest.approx(
        0.95 * short_rig().hydraulics.reference_pressure, rel=0.01
    )


@pytest.mark.slow
def test_effect_of_both_logs_is_no_change(tmp_path):
    always, still = _log(tmp_path, "always", 5, **BACKLASH), _log(tmp_path, "still", 6, **BACKLASH)
    found = diagnose_change([always], [still], short_rig())
    assert (found.verdict, found.effects) == ("none", ())


def test_json_holds_the_change(baseline, washout):
    tree = to_json(washout)
    assert json.loads(json.dumps(tree, allow_nan=False))["change"]["baseline"] == list(baseline.sources)
    assert tree["change"]["since"] is None and tree["gap"]["nominal"] == tree["change"]["gap_before"]


def test_ranking_marks_what_is_suspected(washout):
    marked = {ranked.effect for ranked in washout.ranking if ranked.suspected}
    assert marked == set(washout.suspected) & {ranked.effect for ranked in washout.ranking if ranked.parameters}


def test_page_of_a_change_says_what_its_numbers_are_of(washout):
    sections = {section.title: str(section) for section in report_page(washout).sections}
    assert "Shares are of what calibrating again leaves." in sections["What has changed"]
    assert "no fit has seen" not in sections["What has changed"] and "Before: calibrated" in sections["Parameters"]
    assert "What an effect must pass before it is named" not in sections, "a change has other rules"


def test_unknown_change_says_where_before_it_says_that_no_change_explains_it(washout):
    unknown = replace(washout, verdict="unknown", site="motor", effects=())
    assert str(summary(unknown)).startswith(
        "Something is different, most likely at the mud motor; no known change explains it. The error is "
    )


def test_page_says_that_the_baseline_is_the_same_log(washout):
    assert dict(report_page(washout).facts)["baseline"] == "before.mcap"
    split = replace(washout, change=replace(washout.change, baseline=washout.logs))
    assert dict(report_page(split).facts)["baseline"] == "the same log, before the change"


def test_short_later_log_is_refused_before_the_baseline_is_fitted(logs, monkeypatch):
    monkeypatch.setattr("slider_drilling.diagnosis.diagnose_change.fit_baseline", lambda *given: pytest.fail("fitted"))
    with pytest.raises(InputError, match="20 s of top-drive motion: at least 30 s"):
        diagnose_change([logs["before"]], [cut_time_window(logs["same"], 0.0, 20.0)], short_rig())
    with pytest.raises(InputError, match="no top-drive motion: at least 30 s"):
        diagnose_change([logs["before"]], [replace(logs["same"], top_drive=None)], short_rig())


def test_only_restricts_the_changes(baseline, logs):
    found = diagnose_change(baseline, [logs["same"]], short_rig(), only=("washout",))
    assert [ranked.effect for ranked in found.ranking] == ["washout"]
    with pytest.raises(InputError, match=r"^only stripeck: not a change that this log can show; use stribeck"):
        diagnose_change(baseline, [logs["same"]], short_rig(), only=("stripeck",))


def test_change_within_a_log_needs_log_on_both_sides(logs):
    for since in (10.0, 90.0, -5.0):
        with pytest.raises(InputError, match=f"^since {since:g}: .* holds 100 s"):
            windows_at(logs["same"], since)


def test_options_that_exclude_each_other(logs):
    log = logs["same"]
    for options, message in (
        ({"baseline": log, "since": 90.0}, "give one of them"),
        ({"since": 90.0, "until": 0.5}, "^until 0.5: not with"), ({"baseline": []}, "no baseline"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=message):
            diagnose(log, **options)
    with pytest.raises(InputError, match="splits one log; 2 are given"):
        diagnose([log, logs["worn"]], since=90.0)


@pytest.mark.parametrize("text", ["soon", "nan", "inf", ""])
def test_since_must_be_a_time(text):
    with pytest.raises(InputError, match="must be a time in s"):
        parse_since(text)


def test_since_takes_seconds_or_auto():
    assert [parse_since(text) for text in (None, "auto", "1200", "1.5e2")] == [None, "auto", 1200.0, 150.0]


def test_rig_changes_multiply_calibrated_numbers():
    values = {"pressure_gain": 1.1, "washout.loss": 0.1, "friction_1": 2.0, "friction_2": 3.0,
              "friction_drift.rate": 1.0, "friction_change.share": 0.5}  # fmt: skip
    changed = with_rig_changes(values)
    assert changed == pytest.approx(
        {"pressure_gain": 0.99, "friction_1": 3.0, "friction_2": 4.5, "friction_drift.rate": 1.0}
    )
    assert with_rig_changes({"friction_change.share": 0.2}) == pytest.approx({"friction_1": 1.2})


def test_every_rig_change_is_a_candidate():
    for change in RIG_CHANGES.values():
        effect = change.candidate()
        assert effect.parameters[0].nominal == 0.0 and change.phrase(0.1)[0].isupper()


def test_moved_number_says_by_how_much():
    share = moved_clause("pressure_gain", ChangedParameter(1.0, 0.95, (0.94, 0.96), "-"))
    assert str(share) == "circulating pressure changed by -5.0 % [-6, -4]"
    assert str(moved_clause("hook_load_offset", ChangedParameter(0.0, 8e3, (7e3, 9e3), "N"))).endswith("0 kN to 8.0 kN")


@pytest.mark.parametrize("phase", [0.0, 1.6, 3.1])
@pytest.mark.parametrize(("amplitude", "period", "at_ends"), [(0.1, 8.0, 0.0), (0.3, 14.0, 90.0), (0.5, 10.0, 90.0)])
def test_block_that_follows_a_wave_is_no_operation(amplitude, period, at_ends, phase):
    """A controller that compensates for heave moves the block as fast as a pick-up does, there and back.

    At the ends of a log half a large wave may be a pick-up.
    """
    time, wave = np.arange(0.0, 400.0, 0.1), 2.0 * np.pi / period
    speed = 0.003 + amplitude * wave * np.cos(wave * time + phase)
    block = 0.003 * time + amplitude * np.sin(wave * time + phase)
    calm = calm_times(Commands(time, 0.0 * time, 0.0 * time, block, speed, 12.0 + 0.0 * time))
    assert calm[(time >= at_ends) & (time <= 400.0 - at_ends)].all()


@pytest.mark.parametrize("operation", [(-0.05, 20.0), (0.1, 5.0), (-0.1, 40.0)])
def test_pick_up_and_slack_off_are_operations_in_a_wave_too(operation):
    moved, lasting = operation
    time, wave = np.arange(0.0, 400.0, 0.1), 2.0 * np.pi / 10.0
    speed = 0.1 * wave * np.cos(wave * time) + np.where((time >= 200.0) & (time < 200.0 + lasting), moved, 0.003)
    calm = calm_times(Commands(time, 0.0 * time, 0.0 * time, np.cumsum(speed) * 0.1, speed, 12.0 + 0.0 * time))
    assert not calm[(time > 205.0) & (time < 250.0)].any() and calm[time < 170.0].all() and calm[time > 320.0].all()


def test_operations_are_left_out():
    time = np.arange(0.0, 400.0, 0.1)
    lifted = np.where((time > 100.0) & (time < 120.0), -0.1, 0.003)
    still = np.zeros_like(time)
    calm = calm_times(Commands(time, still, still, np.cumsum(lifted) * 0.1, lifted, np.full_like(time, 10.0)))
    assert calm[time < 90.0].all() and not calm[(time > 100.0) & (time < 175.0)].any() and calm[time > 185.0].all()


def _fitted(**values):
    parameters = [Parameter(name, 1.0, 0.5, 2.0, 0.05, spread=0.02) for name in ("friction_1", "motor_gain")]
    return SimpleNamespace(parameters=parameters, values={"friction_1": 1.0, "motor_gain": 1.0, **values})


@pytest.mark.parametrize(("moved", "alone", "beside"), [
    (1.01, 1.0, ""), (1.1, 1.0, "friction_1"), (1.1, 1.09, ""), (1.1, 1.05, "friction_1"),
])  # fmt: skip
def test_name_that_needs_another_change_is_none(moved, alone, beside):
    tried = SimpleNamespace(fit=_fitted(friction_1=moved), effect=SimpleNamespace(parameters=()))
    assert changed_beside(tried, _fitted(friction_1=alone)) == beside


def _sensor(candidate):
    """A candidate beside which a standing bias of the torque sensor has moved."""
    bias = Parameter("torque_sensor_bias.bias", 50.0, -3e3, 3e3, 20.0, spread=30.0)
    found = SimpleNamespace(parameters=[bias], values={bias.name: 900.0}, cost=0.0)
    calibrated = SimpleNamespace(parameters=[bias], values={bias.name: 50.0})
    own = (replace(bias, name=candidate),)
    return TriedChange(SimpleNamespace(name=candidate, parameters=own), False, None, found, 100.0), calibrated


def test_numbers_of_standing_effects_are_narrowed_and_counted(monkeypatch):
    def within_bounds(problem, parameters, start):
        assert all(each.lower <= start[each.name] <= each.upper for each in parameters)
        return SimpleNamespace(parameters=parameters, values=start, cost=5.0)

    monkeypatch.setattr(change_search, "fit", within_bounds)
    tried, calibrated = _sensor("friction_change.share")
    assert changed_beside(tried, calibrated) == "torque_sensor_bias.bias"
    narrowed = change_search.within_wander(tried, calibrated)
    assert (changed_beside(narrowed, calibrated), narrowed.gain) == ("", 95.0)


def test_standing_effect_is_not_refused_for_its_own_number():
    assert not changed_beside(*_sensor("torque_sensor_bias.bias"))


def test_nothing_that_begins_or_grows_during_the_baseline_stands(monkeypatch):
    scanned = []
    monkeypatch.setattr(baseline_module, "scan_effects", lambda problem, found, effects: scanned.extend(effects))
    monkeypatch.setattr(baseline_module, "screen", lambda scan: [SimpleNamespace(predicted_gain=0.0)])
    baseline_module._standing_effects(None, None, list(catalogue(2000.0, 600.0)))
    missing = set(EFFECTS) - {effect.name for effect in scanned}
    assert missing == {"formation_change", "friction_drift"}


@pytest.mark.parametrize(
    ("before", "without", "refused"), [(3.0, 1.06, True), (3.0, 1.0, True), (3.0, 3.0, False), (1.1, 1.1, False)]
)
def test_name_explains_the_channel_in_which_the_change_was_seen(monkeypatch, before, without, refused):
    """Unless that channel hardly differs: then it says nothing."""
    monkeypatch.setattr(change_answer, "usual_gaps", lambda problem, gap: {"standpipe_pressure": gap})
    problem = SimpleNamespace(residuals=lambda values: [without])
    effect = SimpleNamespace(parameters=())
    tried = SimpleNamespace(problem=problem, fit=SimpleNamespace(residual=1.05, values={}), effect=effect)
    search = SimpleNamespace(problem=None, unchanged=SimpleNamespace(residual=before), seen_in="standpipe_pressure")
    assert change_answer._explains_another_channel(tried, search) == refused
    assert not change_answer._explains_another_channel(tried, SimpleNamespace(**vars(search) | {"seen_in": None}))


def _tried(name, gain, physical=True):
    effect = SimpleNamespace(name=name, is_physical=lambda values: physical)
    return TriedChange(effect, False, None, SimpleNamespace(values={}), gain)


@pytest.mark.parametrize(("gain", "physical", "behind"), [
    (840.0, True, {"dulling_bit"}), (840.0, False, set()), (670.0, True, set()), (500.0, True, set()),
])  # fmt: skip
def test_none_has_a_name_far_behind_one_that_has_none(gain, physical, behind):
    """Whatever but its sign kept the better one from a name."""
    candidates = [_tried("cuttings_bed", gain, physical), _tried("dulling_bit", 540.0)]
    assert set(change_answer.refused_behind(candidates, {"cuttings_bed": "its size is not known"})) == behind


def test_one_as_good_as_the_best_that_may_be_named_remains_of_its_group():
    candidates = [_tried("stribeck", 715.0), _tried("friction_change", 630.0), _tried("tortuosity", 562.0)]
    assert change_answer.refused_behind(candidates, {"stribeck": "its size is not known"}) == {}


def test_both_shapes_are_tried_of_candidates_of_the_right_sign():
    candidates = [
        _tried("stribeck", 20.0), _tried("plugged_nozzle", 310.0, physical=False), _tried("friction_change", 21.0),
        _tried("motor_wear", 303.0, physical=False), _tried("washout", 69.0),
    ]  # fmt: skip
    assert change_search.worth_both_shapes(candidates) == ["washout", "friction_change"]


@pytest.mark.parametrize(("moved", "wandered"), [(1.05, True), (1.07, False)])
def test_numbers_within_their_wander_are_no_change(moved, wandered):
    assert only_wandered(_fitted(friction_1=moved)) == wandered


def test_every_later_log_has_blocks_of_time_of_its_own():
    def piece(run, rows, first):
        return SimpleNamespace(run=run, rows=rows, channel=SimpleNamespace(time=first + 10.0 * np.arange(3)))

    # Two logs of 20 s whose clocks both begin at 5 s: the last sample of each is the first of its second block.
    pieces = (piece(0, slice(0, 3), 5.0), piece(0, slice(3, 6), 5.0), piece(1, slice(6, 9), 5.0))
    problem = SimpleNamespace(size=9, model=SimpleNamespace(runs=(None, None)), pieces=pieces)
    assert change_answer._time_blocks(problem).tolist() == [0, 0, 1, 0, 0, 1, 2, 2, 3]
