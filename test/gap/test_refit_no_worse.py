"""Calibration never leaves a larger gap than the model as given, or than the values that a user starts from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d
from toy import SHAPES, TIME, toy

from slider_drilling.gap import Parameter, explain
from slider_drilling.gap.evidence.score import make_folds
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.selection.refit import cross_validate, least_gap, no_worse_than, score_nominal


def calibrated(level: float):
    """A toy calibrated to a level, right or wrong, with the score of the model as given."""
    problem = build_problem(toy({}, 0), [{"force": 1.0}])
    parameters = problem.expand_per_run(problem.model.nuisance)
    start = {parameter.name: parameter.nominal for parameter in parameters} | {"level": level}
    model = cross_validate(problem, fit(problem, parameters, start, iterations=0), (), make_folds(problem))
    return model, score_nominal(problem, model)


def test_better_calibration_is_kept():
    model, nominal = calibrated(1.0)
    better = replace(model, score=replace(model.score, gap=0.9 * nominal.gap))
    assert no_worse_than(better, [{}]) is better


def test_worse_calibration_becomes_the_model_as_given():
    model, nominal = calibrated(1.0)
    worse = replace(model, score=replace(model.score, gap=2.0 * nominal.gap))
    kept = no_worse_than(worse, [{}])
    assert kept.score.gap == nominal.gap
    assert all(kept.fit.values[each.name] == each.nominal for each in kept.fit.parameters)


def test_worse_calibration_becomes_the_users_start():
    model, _ = calibrated(1.0)
    starts = [{}, {"level": 1.0}, {"level": 40.0}]
    gaps = [least_gap(model.problem, [values]) for values in starts]
    best = starts[int(np.argmin(gaps))]
    worse = replace(model, score=replace(model.score, gap=2.0 * max(gaps)))
    kept = no_worse_than(worse, starts)
    assert kept.score.gap == pytest.approx(min(gaps))
    assert kept.fit.values["level"] == best.get("level", model.fit.parameters[0].nominal)


@pytest.mark.parametrize("seed", range(3))
def test_wild_logs_are_calibrated_no_worse_than_given(seed):
    """Steps that no parameter and no effect makes, tens of noise units high."""
    steps = 60.0 * np.sign(np.sin(TIME / (5.0 + seed))) * (20.0 * seed < TIME)
    answer = explain(toy({}, seed, extra=steps), effects=[])
    assert answer.gap_calibrated <= answer.gap_nominal


def test_slow_errors_count_where_they_mislead():
    """The jumps of a saw say one amplitude, its slow part another of the other sign: the gap asks for the latter."""
    slow = uniform_filter1d(SHAPES["saw"], 3)
    model = toy({}, 3, extra=40.0 * (SHAPES["saw"] - slow) - 80.0 * slow)
    answer = explain(replace(model, nuisance=(Parameter("saw", 0.0, -50.0, 50.0, 0.3, "N"),)), effects=[])
    assert answer.state.modes[0].white_discrepancy
    assert answer.parameters["saw"] < -40.0
    assert answer.gap_calibrated < 0.7 * answer.gap_nominal
