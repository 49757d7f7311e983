"""Resamples and weights of blocks, and intervals of a share of the gap."""

import numpy as np
import pytest

from slider_drilling.gap.evidence.block_bootstrap import make_bootstrap
from slider_drilling.gap.evidence.compare import gap_closed, predicts_better_among
from slider_drilling.gap.evidence.score import Folds, HeldOutScore

BLOCK, BLOCKS = 30, 8


def one_run(length=BLOCK * BLOCKS, block=BLOCK):
    return Folds(np.zeros(length, dtype=int), np.arange(length), (length,), (block,))


def scored(squares):
    squares = np.asarray(squares, dtype=float)
    return HeldOutScore(squares, np.sqrt(np.abs(squares)), squares, float(np.sqrt(np.mean(squares))), {}, 0)


def two_runs():
    """The second half as long and with a channel that is twice as dense."""
    instant = np.concatenate([np.arange(50), 50 + np.arange(25), 50 + np.arange(25)])
    return Folds(np.zeros(instant.size, dtype=int), instant, (50, 25), (8, 10))


def test_resample_is_whole_blocks_of_log_length():
    folds = two_runs()
    blocks = make_bootstrap(folds, 3)
    assert blocks.block_count == 7 + 3
    values = np.random.default_rng(1).normal(size=folds.instant.size)
    at = np.bincount(folds.instant, weights=values)
    for draw in range(20):
        first = [(s + np.arange(8)) % 50 for s in blocks.starts[0][draw]]
        second = [50 + (s + np.arange(10)) % 25 for s in blocks.starts[1][draw]]
        drawn = np.concatenate([np.concatenate(first)[:50], np.concatenate(second)[:25]])
        assert blocks.resampled_sum(values)[draw] == pytest.approx(at[drawn].sum())
    assert blocks.resampled_sum(np.ones(folds.instant.size)) == pytest.approx(100.0)


def test_weights_are_positive_with_mean_one():
    blocks = make_bootstrap(two_runs(), 3)
    for weights in blocks.weights:
        assert np.all(weights > 0.0)
        assert weights.mean(axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize("length", [240, 247, 1200])
def test_weights_and_resamples_scatter_a_mean_alike(length):
    """But for n over n + 1 of n blocks: Dirichlet's weights against the multinomial's."""
    blocks = make_bootstrap(one_run(length), 5)
    values, number = np.random.default_rng(2).normal(size=length), length / BLOCK
    drawn, weighed = blocks.resampled_sum(values) / length, blocks.weighted_sum(values) / length
    assert np.mean(weighed) == pytest.approx(np.mean(values), abs=3.0 * np.std(weighed) / np.sqrt(2000.0))
    by_block = np.var(drawn) * (number / (number + 1.0))
    assert np.var(weighed) == pytest.approx(by_block, rel=0.2)


def test_block_weight_is_exponential():
    blocks = make_bootstrap(one_run(30000), 1)
    (weights,) = blocks.weights
    first = weights[:, :8].mean(axis=1)
    assert np.var(weights[:, 0]) == pytest.approx(1.0, rel=0.15)
    assert np.corrcoef(weights[:, 0], weights[:, 4])[0, 1] == pytest.approx(0.5, abs=0.08)
    assert np.corrcoef(weights[:, 0], weights[:, 8])[0, 1] == pytest.approx(0.0, abs=0.08)
    assert np.var(first) == pytest.approx(2.0 / 3.0, rel=0.15)


def in_one_stretch(size, elsewhere=1.0):
    squares = np.full(BLOCK * BLOCKS, elsewhere)
    squares[BLOCK : 2 * BLOCK] = size
    return scored(squares)


def test_gap_in_one_stretch_gives_its_share():
    blocks = make_bootstrap(one_run(), 4)
    closed, (low, high) = gap_closed(blocks, in_one_stretch(90.0), in_one_stretch(9.9))
    assert closed == pytest.approx(0.9)
    assert low == pytest.approx(0.9) and high == pytest.approx(0.9)
    assert not predicts_better_among(blocks, in_one_stretch(9.9), in_one_stretch(90.0), 1)


def test_opening_a_gap_elsewhere_closes_none_significantly():
    blocks = make_bootstrap(one_run(), 4)
    closed, (low, _) = gap_closed(blocks, in_one_stretch(10.0), in_one_stretch(2.0, elsewhere=1.5))
    assert closed == pytest.approx(1.0 - (1.0 + 7.0 * 0.5) / 9.0)
    assert low < 0.0


@pytest.mark.parametrize("number", [6, 20])
@pytest.mark.parametrize("filled", [1, 2, 6])
def test_share_interval_covers_wherever_the_gap_is(number, filled):
    """So many blocks hold a gap, of which three quarters are closed, here more and there less; noise is everywhere."""
    generator = np.random.default_rng(6)
    each, folds = np.resize([8, 7, 8, 7], 4 * number), one_run(BLOCK * number)
    inside = np.arange(4 * number) < 4 * filled
    blocks = [make_bootstrap(folds, seed) for seed in range(10)]
    held = sure = 0
    logs = 300
    for log in range(logs):
        noise = generator.normal(1.0, 0.5, inside.size)
        before = scored(np.repeat(noise + 8.0 * inside, each))
        still = 8.0 * inside * generator.normal(0.25, 0.2, inside.size) + generator.normal(0.0, 0.15, inside.size)
        low, high = gap_closed(blocks[log % 10], before, scored(np.repeat(noise + still, each)))[1]
        held += low <= 0.75 <= high
        sure += low > 0.0
    assert 0.9 < held / logs < 0.995
    assert filled == 1 or sure / logs > 0.9
