"""A channel's tolerance: an error that nobody would act upon is no gap."""

from __future__ import annotations

from dataclasses import replace

import pytest
from toy import fit_toy, toy

from slider_drilling.gap.evidence.adequacy import NEGLIGIBLE, adequacy_of_fit, negligible_gaps
from slider_drilling.gap.evidence.score import make_folds, score_held_out
from slider_drilling.gap.problem.problem import build_problem


def problem_with(tolerance: float, noise: float = 2.0):
    model = toy({"level": 2.0, "saw": 5.0}, 5)
    (run,) = model.runs
    channels = tuple(replace(channel, tolerance=tolerance) for channel in run.channels)
    return build_problem(replace(model, runs=(replace(run, channels=channels),)), [{"force": noise}])


def test_tolerance_counts_in_noise_units():
    assert negligible_gaps(problem_with(6.0))["force"] == pytest.approx((1.0 + NEGLIGIBLE + 9.0) ** 0.5)


@pytest.mark.parametrize(("tolerance", "above"), [(0.0, ("force",)), (9.0, ())])
def test_error_within_the_tolerance_is_no_gap(tolerance, above):
    problem = problem_with(tolerance, noise=1.0)
    _, found = fit_toy(problem.model, [])
    score = score_held_out(problem, found, make_folds(problem))
    assert adequacy_of_fit(problem, found, score, 1).channels_above == above
