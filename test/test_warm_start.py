"""A diagnosis of further logs starts from the earlier answer."""

from slider_drilling.diagnosis.catalogue import catalogue
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer
from slider_drilling.diagnosis.warm_start import calibration_start, with_earlier_starts
from slider_drilling.gap.experiment_design.knowledge import Explanation

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
