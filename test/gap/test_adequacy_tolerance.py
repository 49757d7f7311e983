"""A channel's tolerance: an error that nobody would act upon is no gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from toy import TIME, Toy, fit_toy, toy

from slider_drilling.gap.evidence.adequacy import NEGLIGIBLE, adequacy_of_fit, negligible_gaps
from slider_drilling.gap.evidence.score import make_folds, score_held_out
from slider_drilling.gap.problem.problem import build_problem


def problem_with(tolerance: float, noise: float = 2.0):
    model = toy({"level": 2.0, "saw": 5.0}, 5)
    (run,) = model.runs
    channels = tuple(replace(channel, tolerance=tolerance) for channel in run.channels)
    return build_problem(replace(model, runs=(replace(run, channels=channels),)), [{"force": noise}])


def test_tolerance_counts_in_noise_units():
    problem = problem_with(6.0)
    _, found = fit_toy(problem.model, [])
    assert negligible_gaps(problem, found)["force"] == pytest.approx((1.0 + NEGLIGIBLE + 9.0) ** 0.5)


@pytest.mark.parametrize(("share", "enough"), [(0.0, False), (0.5, True)])
def test_what_the_models_error_may_hold_is_no_gap(share, enough):
    left = 2.0 * np.sin(TIME)
    (run,) = toy({"level": 2.0, "saw": 9.0}, 5, extra=left).runs
    channels = tuple(replace(channel, model_error=share) for channel in run.channels)
    problem, found = fit_toy(Toy((replace(run, channels=channels),)), ["saw"])
    adequacy = adequacy_of_fit(problem, found, score_held_out(problem, found, make_folds(problem)), 1)
    assert adequacy.adequate == adequacy.negligible == enough


@pytest.mark.parametrize(("tolerance", "above"), [(0.0, ("force",)), (9.0, ())])
def test_error_within_the_tolerance_is_no_gap(tolerance, above):
    problem = problem_with(tolerance, noise=1.0)
    _, found = fit_toy(problem.model, [])
    score = score_held_out(problem, found, make_folds(problem))
    assert adequacy_of_fit(problem, found, score, 1).channels_above == above
