"""An effect that ends the gap for certain is taken at that, whatever one event weighs."""

from types import SimpleNamespace

import numpy as np
import pytest
from toy import TIME, toy

from slider_drilling.gap.evidence.block_bootstrap import make_bootstrap
from slider_drilling.gap.evidence.compare import predicts_better, predicts_better_among
from slider_drilling.gap.evidence.score import HeldOutScore, make_folds
from slider_drilling.gap.problem.problem import build_problem
from slider_drilling.gap.selection import candidates as judge

CANDIDATES = 16


@pytest.fixture
def blocks():
    return make_bootstrap(make_folds(build_problem(toy({}, 1), [{"force": 1.0}])), 0)


def scored(squares, density):
    squares, density = np.broadcast_to(squares, TIME.shape), np.broadcast_to(density, TIME.shape)
    return HeldOutScore(density, np.sqrt(squares), squares, float(np.sqrt(np.mean(squares))), {}, 0)


def judged(blocks, monkeypatch, known, found, *, reaches_noise=True, ends=False, known_reaches_noise=False):
    monkeypatch.setattr(
        judge, "check_adequacy", lambda *given: SimpleNamespace(within_thresholds=reaches_noise, adequate=ends)
    )
    state = SimpleNamespace(
        bootstrap=blocks,
        current=SimpleNamespace(score=known),
        adequacy=SimpleNamespace(within_thresholds=known_reaches_noise),
    )
    explained = SimpleNamespace(score=found, problem=None, fit=None)
    return judge._suffices(state, explained, CANDIDATES, seed=0)


# What a slow effect gains is little everywhere; one event at the end outweighs many a stretch.
EVENT = np.where(TIME > 115.0, 6.0, 0.0)
KNOWN, FOUND = scored(3.0, 2.0), scored(1.1, 1.5 + EVENT)


def test_a_gain_that_one_event_makes_uncertain(blocks, monkeypatch):
    assert not predicts_better(blocks, FOUND, KNOWN, CANDIDATES)
    assert judged(blocks, monkeypatch, KNOWN, FOUND)


def test_a_law_that_shrinks_a_gap_and_does_not_end_it_is_not_taken(blocks, monkeypatch):
    assert not judged(blocks, monkeypatch, KNOWN, FOUND, reaches_noise=False)


def test_where_nothing_is_left_to_explain_nothing_is_taken_for_the_gap_alone(blocks, monkeypatch):
    assert not judged(blocks, monkeypatch, KNOWN, FOUND, known_reaches_noise=True)


def test_what_foretells_less_on_the_whole_is_not_taken(blocks, monkeypatch):
    assert not judged(blocks, monkeypatch, KNOWN, scored(1.1, 2.1))


def test_a_gap_that_shrinks_by_chance_is_not_taken(blocks, monkeypatch):
    squares = 2.9 + np.sin(TIME / 7.0)
    assert not judged(blocks, monkeypatch, KNOWN, scored(squares, 1.5))


# A log that shows its cause once: most resamples do not hold it.
ONCE, WITHOUT = scored(1.0 + EVENT, 2.0 + EVENT), scored(1.0, 2.0)


def test_what_shows_once_is_taken_where_the_likelihood_ratio_is_beyond_doubt_and_nothing_is_left(blocks, monkeypatch):
    assert not predicts_better(blocks, WITHOUT, ONCE, CANDIDATES)
    assert judged(blocks, monkeypatch, ONCE, WITHOUT, ends=True)
    assert not judged(blocks, monkeypatch, ONCE, WITHOUT)
    little = scored(1.0 + EVENT, 2.0 + 0.15 * EVENT)
    assert not judged(blocks, monkeypatch, little, WITHOUT, ends=True)


def test_few_blocks_and_many_candidates_leave_it_to_the_likelihood_ratio():
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
