"""A change that needs no second one beside it may be named, however far a free fit moves the rest."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from toy import EFFECTS, fit_toy, toy

from slider_drilling.diagnosis.change_answer import differs_from_none, moved_parameters, refused_by_channel
from slider_drilling.diagnosis.change_search import TriedChange, changed_beside, within_wander
from slider_drilling.gap.model import Parameter
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit


@pytest.mark.parametrize(("sine", "within"), [(4.0, True), (0.3, False)])
def test_number_that_a_fit_moves_for_little_is_no_second_change(sine, within):
    """The level is 1.2 in both logs, farther than it wanders: beside a large change that hardly matters."""
    level = Parameter("level", 0.0, -50.0, 50.0, 0.3, "N", spread=0.2)
    log = toy({"level": 1.2, "sine": sine}, seed=1)
    problem = build_problem(replace(log, nuisance=(level,)), [{"force": 1.0}])
    effect = next(each for each in EFFECTS if each.name == "sine")
    calibrated = fit(problem, [replace(level, spread=0.01)], {"level": 0.0}, iterations=0)
    calibrated = replace(calibrated, parameters=(level,))
    found = fit(problem, [level, *effect.parameters], {})
    tried = TriedChange(effect, False, problem, found, calibrated.cost - found.cost)
    assert changed_beside(tried, calibrated) == "level"
    limited = within_wander(tried, calibrated)
    assert (changed_beside(limited, calibrated) == "") == within
    assert abs(limited.fit.values["sine"] - sine) < 0.3 and limited.gain <= tried.gain + 1e-6


@pytest.mark.parametrize(("step", "differs"), [(3.0, True), (0.05, False)])
def test_size_that_may_be_none_beside_what_is_not_known_is_no_change(step, differs):
    """Slope and level of the log are not known, and look much like a step."""
    problem, found = fit_toy(toy({"level": 2.0, "slope": 1.0, "step": step}, seed=1), {"step"})
    effect = next(each for each in EFFECTS if each.name == "step")
    assert differs_from_none(TriedChange(effect, False, problem, found, 100.0)) == differs


@pytest.mark.parametrize(("level", "moved"), [(2.0, True), (0.08, False)])
def test_number_has_changed_if_its_interval_leaves_out_what_it_was(level, moved):
    """The level was 0 and wanders by 0.01; the later log shows it to within 0.13."""
    problem, found = fit_toy(toy({"level": level}, seed=3), ())
    was = SimpleNamespace(parameters={"level": SimpleNamespace(value=0.0, spread=0.01)})
    assert ("level" in moved_parameters(problem, found, was)) == moved


@pytest.mark.parametrize(("gain", "named"), [(300.0, set()), (80.0, {"bend", "saw"})])
def test_next_best_is_no_name_where_the_best_explains_another_channel(gain, named):
    gains = {"bend": 100.0, "saw": 90.0, "sine": gain}
    tried = [SimpleNamespace(effect=SimpleNamespace(name=name), gain=each) for name, each in gains.items()]
    reasons = refused_by_channel(tried, tried[2:], "hook load")
    assert set(gains) - set(reasons) == named and reasons["sine"].startswith("does not explain the hook load")
