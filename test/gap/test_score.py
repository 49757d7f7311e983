"""Cross-validated scores."""

import numpy as np
from toy import EFFECTS, fit_toy, toy

from slider_drilling.gap.evidence.score import make_folds, score_held_out


def test_held_out_residual_exceeds_fitted_residual():
    model = toy({}, 5)
    problem, found = fit_toy(model, [effect.name for effect in EFFECTS])
    score = score_held_out(problem, found, make_folds(problem))
    assert float(np.mean(score.residual**2)) > float(np.mean(found.residual**2))
    assert score.unrefitted_folds == 0
