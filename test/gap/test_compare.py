"""Comparisons of two fits, on the linear toy and on scores whose answers are known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2
from toy import TIME, fit_toy, toy

from slider_drilling.gap.evidence.block_bootstrap import make_bootstrap
from slider_drilling.gap.evidence.compare import (
    NAMING_LEVEL,
    fit_exceeds_evidence_threshold,
    gap_closed,
    passes_likelihood_ratio_test,
    predicts_better,
    predicts_better_among,
    share_closed,
)
from slider_drilling.gap.evidence.score import Folds, HeldOutScore, make_folds, score_held_out
from slider_drilling.gap.problem.problem import build_problem


def test_truth_predicts_better_and_equals_do_not():
    wins = draws = 0
    for seed in range(20):
        model = toy({"level": 1.0, "saw": 4.0}, seed)
        scores = {}
        for names in ((), ("saw",), ("saw", "bend")):
            problem, found = fit_toy(model, names)
            folds = make_folds(problem)
            scores[names] = score_held_out(problem, found, folds)
        blocks = make_bootstrap(folds, 0)
        wins += predicts_better(blocks, scores["saw",], scores[()])
        draws += predicts_better(blocks, scores["saw", "bend"], scores["saw",])
        assert not predicts_better(blocks, scores["saw",], scores["saw",])
    assert wins == 20
    assert draws <= 4


def test_share_closed_is_relative_to_noise():
    assert float(share_closed(5.0, 1.0)) == 1.0
    assert float(share_closed(5.0, 7.0)) == pytest.approx(-0.5)
    assert np.isnan(share_closed(0.9, 0.8))


@pytest.mark.parametrize("number", [6, 20])
def test_share_interval_covers_with_few_blocks(number):
    """What is left differs from place to place, four of which are a block; a share of three quarters is closed."""
    per_block, each = 4, 5
    size = number * per_block * each
    folds = Folds(np.zeros(size, dtype=int), np.arange(size), (size,), (per_block * each,))
    generator = np.random.default_rng(5)
    before = HeldOutScore(np.zeros(size), np.zeros(size), np.full(size, 5.0), np.sqrt(5.0), {}, 0)
    blocks = [make_bootstrap(folds, seed) for seed in range(10)]
    held, logs = 0, 400
    for log in range(logs):
        squares = np.repeat(generator.normal(2.0, 0.3, number * per_block), each)
        after = replace(before, squares=squares, gap=float(np.sqrt(np.mean(squares))))
        low, high = gap_closed(blocks[log % 10], before, after)[1]
        held += low <= 0.75 <= high
    assert 0.92 < held / logs < 0.98


CANDIDATES = 12


def fit_of(cost, parameters):
    return SimpleNamespace(cost=cost, parameters=("nuisance",) * parameters)


@pytest.mark.parametrize("added", [1, 3])
def test_gain_by_chance_fails_the_likelihood_ratio_test(added):
    least = chi2.ppf(1.0 - NAMING_LEVEL / CANDIDATES, added)
    known = fit_of(1000.0, 5)
    assert not passes_likelihood_ratio_test(known, fit_of(1000.0 - 0.99 * least, 5 + added), CANDIDATES)
    assert passes_likelihood_ratio_test(known, fit_of(1000.0 - 1.01 * least, 5 + added), CANDIDATES)


def test_more_parameters_need_more_gain():
    known = fit_of(1000.0, 5)
    assert passes_likelihood_ratio_test(known, fit_of(990.0, 6), CANDIDATES)
    assert not passes_likelihood_ratio_test(known, fit_of(990.0, 8), CANDIDATES)


@pytest.mark.parametrize("added", [1, 3])
def test_evidence_threshold_counts_candidates_and_parameters(added):
    """Twice the logarithm of candidates over level, and two of `-2 log p` for each parameter that was fitted to it."""
    least = 2.0 * np.log(CANDIDATES / NAMING_LEVEL) + 2.0 * added
    known = fit_of(1000.0, 5)
    assert not fit_exceeds_evidence_threshold(fit_of(1000.01 - least, 5 + added), known, CANDIDATES)
    assert fit_exceeds_evidence_threshold(fit_of(999.99 - least, 5 + added), known, CANDIDATES)


def scored(squares, density):
    squares, density = np.broadcast_to(squares, TIME.shape), np.broadcast_to(density, TIME.shape)
    return HeldOutScore(density, np.sqrt(squares), squares, float(np.sqrt(np.mean(squares))), {}, 0)


def test_few_blocks_rely_on_the_likelihood_ratio():
    few = make_bootstrap(make_folds(build_problem(toy({}, 1), [{"force": 1.0}])), 0)
    # Of six blocks one gets worse, as by an event that no simulation can time.
    gained = np.where(TIME < 20.0, -1.0, 1.0)
    much, little = scored(1.0, 2.0 - gained), scored(1.0, 2.0 - 0.05 * gained)
    known = scored(1.0, 2.0)
    assert not predicts_better(few, much, known, CANDIDATES) and predicts_better(few, much, known)
    assert predicts_better_among(few, much, known, CANDIDATES)
    assert not predicts_better_among(few, little, known, CANDIDATES)
    once = scored(1.0, 2.0 - np.where(TIME < 12.0, 3.0, 0.0))
    assert not predicts_better_among(few, once, known, CANDIDATES)
