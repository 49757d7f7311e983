"""The budget for the model's own error: how far it widens intervals, and what it lets pass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from toy import TIME, Toy, toy

from slider_drilling.gap.evidence.likelihood import Discrepancy
from slider_drilling.gap.problem.model_error import INDEPENDENT_ERRORS, model_error_budget, model_error_covariance
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.results.intervals import parameter_intervals
from slider_drilling.gap.search.least_squares import fit


def inexact(share: float, missing: float = 10.0) -> Toy:
    """A toy that may be wrong by a share of what it moves; a sine is missing from the model."""
    exact = toy({"sine": missing}, 0)
    (run,) = exact.runs
    (channel,) = run.channels
    return replace(exact, runs=(replace(run, channels=(replace(channel, model_error=share),)),))


def fitted(share: float, missing: float = 10.0):
    problem = build_problem(inexact(share, missing), [{"force": 1.0}])
    return problem, fit(problem, problem.expand_per_run(problem.model.nuisance), {})


def width(share: float, name: str, missing: float = 10.0) -> float:
    low, high = parameter_intervals(*fitted(share, missing))[name]
    return high - low


def test_budget_is_the_share_of_the_movement():
    problem, found = fitted(0.1)
    assert model_error_budget(problem, found)["force"] == pytest.approx((0.1 * np.std(found.simulated)) ** 2)


def test_model_error_moves_parameters_as_the_fit_weighs_it():
    """Generalised least squares with the discrepancy's covariance, and an error of the model as large as said."""
    problem, found = fitted(5.0, 0.0)
    (piece,) = problem.pieces
    size, memory = 3.0, 2.0 * float(np.median(piece.interval[1:]))
    found = replace(found, discrepancy={0: Discrepancy(size, memory)})
    lag = np.abs(piece.channel.time[:, None] - piece.channel.time[None])
    inverse = np.linalg.inv(np.eye(len(lag)) + size**2 * np.exp(-lag / memory))
    _, rows = problem.whitened(found.residual, found.jacobian, found.discrepancy)
    weights = found.jacobian @ inverse
    covariance = np.linalg.inv(found.jacobian @ weights.T)
    error = (5.0 * np.std(found.simulated)) ** 2 * TIME.size / INDEPENDENT_ERRORS
    added = model_error_covariance(problem, found, rows, covariance)
    # The error of the stamps adds a little; the filter begins at the other end.
    assert added == pytest.approx(covariance @ (error * weights @ weights.T) @ covariance, rel=0.1, abs=0.05)


def test_model_error_widens_intervals_as_repeated_errors():
    """Where the fit has no discrepancy, which would weigh the samples."""

    def white_width(share: float) -> float:
        problem, found = fitted(share, 0.0)
        low, high = parameter_intervals(problem, replace(found, discrepancy={0: Discrepancy(0.0, 1.0)}))["level"]
        return high - low

    _, found = fitted(5.0, 0.0)
    repeated = 5.0 * np.std(found.simulated) * np.sqrt(TIME.size / INDEPENDENT_ERRORS)
    # The error of the stamps widens it a little more.
    assert white_width(5.0) >= white_width(0.0) * np.sqrt(1.0 + repeated**2) * 0.99


def test_what_a_fit_leaves_widens_intervals():
    assert width(0.0, "level", 10.0) > 2.0 * width(0.0, "level", 0.0)


def test_interval_covers_values_that_look_alike():
    problem, found = fitted(0.0)
    level = replace(problem.model.nuisance[0], equivalents=(-3.0, 7.0))
    named = {parameter.name: parameter for parameter in found.parameters} | {level.name: level}
    low, high = parameter_intervals(problem, replace(found, parameters=tuple(named.values())))[level.name]
    assert low <= max(-3.0, level.lower)
    assert high >= min(7.0, level.upper)


def test_a_channel_that_accumulates_has_intervals_too():
    exact = inexact(0.0, 0.0)
    (run,) = exact.runs
    (channel,) = run.channels
    summed = replace(exact, runs=(replace(run, channels=(replace(channel, accumulates=True),)),))
    problem = build_problem(summed, [{"force": 1.0}])
    found = fit(problem, problem.expand_per_run(summed.nuisance), {})
    low, high = parameter_intervals(problem, found)["level"]
    assert low < high
