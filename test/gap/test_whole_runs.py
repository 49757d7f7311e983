"""How far ahead a model predicts."""

import numpy as np
import pytest
from toy import TIME, toy

from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.results.prediction_horizon import prediction_horizon


@pytest.mark.parametrize("lost_at", [40.0, 90.0])
def testprediction_horizon_ends_where_error_reaches_spread(lost_at):
    problem = build_problem(toy({"slope": 5.0}, 3), [{"force": 1.0}])
    spread = float(np.std(problem.pieces[0].channel.measured))
    horizon, to_end = prediction_horizon(problem, np.where(lost_at <= TIME, 1.5 * spread, 0.0))
    assert horizon["force"] == pytest.approx(lost_at, abs=12.0)
    assert to_end == ()


def test_small_error_is_predictable_to_the_end():
    problem = build_problem(toy({"slope": 5.0}, 3), [{"force": 1.0}])
    horizon, to_end = prediction_horizon(problem, np.full(TIME.size, 0.1))
    assert horizon["force"] == pytest.approx(TIME[-1] - TIME[0])
    assert to_end == ("force",)
