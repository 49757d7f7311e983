"""Share of its expected turn that the toolface makes, by consecutive MWD samples."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slider_drilling.control.estimation.follow_share import FollowShare


def observed(share: float, rate: float = 0.03, noise: float = 0.03) -> FollowShare:
    random = np.random.default_rng(1)
    follow = FollowShare()
    for k in range(400):
        follow.drive(0.5 * k, 0.5 * rate)
        if k % 24 == 23:
            follow.observe(0.5 * k - 4.0, math.remainder(share * rate * 0.5 * k + random.normal(0.0, noise), math.tau))
    return follow


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_share_is_measured_turn_over_expected(share: float) -> None:
    assert observed(share).share == pytest.approx(share, abs=0.15)


def test_held_bit_does_not_move() -> None:
    assert observed(0.0).mobility < 0.3
    assert observed(0.8).mobility == 1.0


def test_little_expected_turn_says_nothing() -> None:
    assert observed(0.0, rate=1e-3).mobility == 1.0


def test_sample_that_is_read_twice_counts_once() -> None:
    follow = observed(0.5)
    before = follow.share
    follow.observe(0.0, 1.0)
    assert follow.share == before


@pytest.mark.parametrize(("share", "held"), [(0.2, True), (0.58, False), (1.0, False)])
def test_filter_turns_by_measured_share(share, held):
    follow = observed(share)
    assert follow.held == held
    assert follow.mobility == pytest.approx(min(follow.share / 0.65, 1.0))
