"""A diagnosis of further logs starts from the earlier answer."""

from dataclasses import replace

import pytest
from short_well import short_rig

from slider_drilling.diagnosis.catalogue import catalogue
from slider_drilling.diagnosis.diagnose import diagnose
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer, earlier_answer
from slider_drilling.diagnosis.warm_start import calibration_start, with_earlier_starts
from slider_drilling.errors import InputError
from slider_drilling.gap.experiment_design.knowledge import Explanation
from slider_drilling.rig import dump_rig, parse_rig
from slider_drilling.test_planning.drilling_plan import PlanTestOptions, plan_after

FITTED = {"friction_1": 1.1, "start_twist@0": 2.0, "heave.amplitude": 0.2, "heave.period": 9.0, "heave.phase": 1.0}
ANSWER = EarlierAnswer("before", ("a.mcap",), "effect", ("heave",), (Explanation(("heave",), 1.0, FITTED),))


def test_calibration_starts_where_the_answer_stood():
    assert calibration_start(ANSWER, ("a.mcap", "b.mcap")) == {"friction_1": 1.1, "start_twist@0": 2.0}


def test_other_logs_keep_no_start_of_their_own():
    assert calibration_start(ANSWER, ("b.mcap", "a.mcap")) == {"friction_1": 1.1}


def test_named_effect_is_looked_for_where_it_was():
    effects = with_earlier_starts(catalogue(3000.0, 240.0, runs=2), ANSWER)
    by_name = {effect.name: effect for effect in effects}
    assert by_name["heave"].scan[0] == (0.2, 9.0, 1.0, 1.0)
    assert by_name["stribeck"].scan == {e.name: e for e in catalogue(3000.0, 240.0)}["stribeck"].scan


def as_tree(**keys):
    tree = {"schema": "slider_drilling/diagnosis/3", "log": "a.mcap", "verdict": "none", "effects": [],
            "explanations": []}  # fmt: skip
    return {**tree, **keys}


def answer_with(rig):
    return earlier_answer(as_tree(rig_file=dump_rig(rig)), "monday.json")


def other_rigs():
    rig = short_rig()
    longer = replace(rig.well, hole_diameter=1.1 * rig.well.hole_diameter)
    drive = replace(rig.top_drive, max_torque=0.9 * rig.top_drive.max_torque)
    return [
        (replace(rig, well=longer), "well.hole_diameter"), (replace(rig, top_drive=drive), "top_drive.max_torque"),
        (replace(rig, well=longer, top_drive=drive), "well.hole_diameter, top_drive.max_torque"),
    ]  # fmt: skip


@pytest.mark.parametrize("number", range(3))
def test_answer_of_another_rig_is_refused_before_the_work(number):
    other, keys = other_rigs()[number]
    after = answer_with(other)
    for work in (lambda: diagnose([], short_rig(), after=after),
                 lambda: plan_after(after, [], short_rig(), PlanTestOptions())):  # fmt: skip
        with pytest.raises(InputError, match=r"^monday\.json: was made with another rig file") as refused:
            work()
        assert all(key in str(refused.value) for key in keys.split(", "))
        assert str(refused.value).endswith("give that one, or leave this diagnosis out")


def test_answer_of_the_same_rig_is_taken():
    rig = short_rig()
    answer_with(rig).check_rig(rig)
    answer_with(rig).check_rig(parse_rig(dump_rig(rig)))
    # An older version left out what has a default today.
    shorter = replace(answer_with(rig), rig_text=dump_rig(rig) + "# as another version writes it\n")
    shorter.check_rig(rig)
    assert answer_with(rig).rig() == rig


def test_answer_of_an_older_version_has_no_rig():
    answer = earlier_answer(as_tree(), "old.json")
    answer.check_rig(short_rig())
    assert answer.rig() is None


@pytest.mark.parametrize("text", [5, ["a"], {}])
def test_damaged_rig_text_is_one_line(text):
    with pytest.raises(InputError, match=r"^old\.json: explanations: damaged"):
        earlier_answer(as_tree(rig_file=text), "old.json")


def test_damaged_rig_file_of_an_answer_is_one_line():
    answer = earlier_answer(as_tree(rig_file="rig: ["), "old.json")
    with pytest.raises(InputError, match=r"^old\.json: rig_file"):
        answer.check_rig(short_rig())
