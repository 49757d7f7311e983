"""Calibration never leaves a larger gap than the model as given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from toy import TIME, toy

from slider_drilling.gap import explain
from slider_drilling.gap.evidence.score import make_folds
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.search.least_squares import fit
from slider_drilling.gap.selection.refit import cross_validate, no_worse_than_given, score_nominal


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
    assert no_worse_than_given(better, nominal) is better


def test_worse_calibration_becomes_the_model_as_given():
    model, nominal = calibrated(1.0)
    worse = replace(model, score=replace(model.score, gap=2.0 * nominal.gap))
    kept = no_worse_than_given(worse, nominal)
    assert kept.score is nominal
    assert all(kept.fit.values[each.name] == each.nominal for each in kept.fit.parameters)


@pytest.mark.parametrize("seed", range(3))
def test_wild_logs_are_calibrated_no_worse_than_given(seed):
    """Steps that no parameter and no effect makes, tens of noise units high."""
    steps = 60.0 * np.sign(np.sin(TIME / (5.0 + seed))) * (20.0 * seed < TIME)
    answer = explain(toy({}, seed, extra=steps), effects=[])
    assert answer.gap_calibrated <= answer.gap_nominal
