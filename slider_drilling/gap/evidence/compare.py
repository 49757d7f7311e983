"""The only "better than": paired differences of held-out scores over blocks of time."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2, norm
from scipy.stats import t as student

from slider_drilling.gap.evidence.block_bootstrap import BlockBootstrap
from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.model import Array
from slider_drilling.gap.search.least_squares import Fit

LEVEL = 0.05
# An effect is worth a name if it closes at least this share of the gap; a floor that moves by less is the same.
LEAST_SHARE = 0.05
_ROUNDING = 1e-6  # -2 log p, that two fits of the same thing differ by


def held_out_gain(blocks: BlockBootstrap, better: HeldOutScore, worse: HeldOutScore) -> Array:
    """(RESAMPLES,) by how much ``-2 log p`` of unseen data is lower with one than with the other."""
    return blocks.resampled_sum(worse.density - better.density)


def predicts_better(blocks: BlockBootstrap, better: HeldOutScore, worse: HeldOutScore, rivals: int = 1) -> bool:
    """Whether one foretells more than the other at a level shared among so many rivals (Bonferroni)."""
    return float(np.quantile(held_out_gain(blocks, better, worse), LEVEL / rivals)) > _ROUNDING


def exceeds_evidence_threshold(better: HeldOutScore, worse: HeldOutScore, rivals: int) -> bool:
    """Whether the likelihood ratio of what was held out is above one over the level shared among so many rivals
    (Wasserman, Ramdas and Balakrishnan, PNAS 117, 2020).
    """
    return worse.held_out_deviance - better.held_out_deviance > evidence_threshold(rivals)


def fit_exceeds_evidence_threshold(found: Fit, known: Fit, rivals: int) -> bool:
    """Whether so is the likelihood ratio of the whole log, less what the added parameters gain there and would not
    foretell (Akaike, IEEE Transactions on Automatic Control 19, 1974).
    """
    added = len(found.parameters) - len(known.parameters)
    return known.cost - found.cost - 2.0 * added > evidence_threshold(rivals)


def evidence_threshold(rivals: int) -> float:
    """``-2 log`` of the level shared among so many rivals."""
    return 2.0 * float(np.log(rivals / LEVEL))


def predicts_better_among(blocks: BlockBootstrap, better: HeldOutScore, worse: HeldOutScore, rivals: int) -> bool:
    """Whether one of so many rivals foretells more for certain.

    Of half a dozen blocks no resample says that at the shared level unless every single one gains. Then the likelihood
    ratio may stand for how many rivals there are, and the blocks only for that it comes from more than one of them.
    """
    return predicts_better(blocks, better, worse, 1 if exceeds_evidence_threshold(better, worse, rivals) else rivals)


def chi2_critical(added: int, rivals: int = 1) -> float:
    """What so many free parameters gain of ``-2 log p`` on noise (Wilks), at the level shared among so many rivals."""
    return float(chi2.ppf(1.0 - LEVEL / rivals, max(added, 1)))


def passes_likelihood_ratio_test(known: Fit, found: Fit, rivals: int = 1) -> bool:
    """Whether the likelihood ratio over the whole log is more than the added parameters gain on noise (Wilks), at the
    level shared among so many rivals.
    """
    return known.cost - found.cost > chi2_critical(len(found.parameters) - len(known.parameters), rivals)


def resampled_squared_gaps(blocks: BlockBootstrap, score: HeldOutScore) -> Array:
    """(RESAMPLES,) E^2 of what was drawn."""
    return blocks.resampled_sum(score.squares) / blocks.resampled_sum(np.ones_like(score.squares))


def gap_closed(blocks: BlockBootstrap, before: HeldOutScore, after: HeldOutScore) -> tuple[float, tuple[float, float]]:
    """Share of the gap before that is closed after, and its 95 % interval; NaN where there was nothing to close. Where
    weights leave no gap they say nothing of what is closed of it.
    """
    within = _interval(share_closed(*_weighted_gaps(blocks, before, after)), blocks.block_count)
    return float(share_closed(before.gap**2, after.gap**2)), within


def shrinks(blocks: BlockBootstrap, before: HeldOutScore, after: HeldOutScore) -> bool:
    """Whether the gap shrinks for certain, and by enough for a name: what is gained of E^2 has a lower bound above
    zero, and so has the share that is closed where there is a gap to be a share of.
    """
    was, left = _weighted_gaps(blocks, before, after)
    gained, closed = (_interval(drawn, blocks.block_count)[0] for drawn in (was - left, share_closed(was, left)))
    return gained > 0.0 and not (share_closed(before.gap**2, after.gap**2) < LEAST_SHARE or closed <= 0.0)


def _weighted_gaps(blocks: BlockBootstrap, *scores: HeldOutScore) -> list[Array]:
    """(RESAMPLES,) E^2 by weight, of each."""
    size = blocks.weighted_sum(np.ones_like(scores[0].squares))
    return [blocks.weighted_sum(score.squares) / size for score in scores]


def _interval(drawn: Array, number: int) -> tuple[float, float]:
    """95 % interval of what was drawn by the weights of so many blocks, where that is a number; NaN where none is.

    Weights of a few blocks scatter less than as many new logs would: the interval is expanded as a mean's is from the
    normal distribution to Student's (Hesterberg, The American Statistician 69, 2015).
    """
    drawn, number = drawn[np.isfinite(drawn)], max(number, 2)
    if not drawn.size:
        return float("nan"), float("nan")
    wider = np.sqrt((number + 1.0) / (number - 1.0)) * student.ppf(1.0 - 0.5 * LEVEL, number - 1)
    return float(np.quantile(drawn, norm.cdf(-wider))), float(np.quantile(drawn, norm.cdf(wider)))


def share_closed(before: Array | float, after: Array | float) -> Array:
    """``1 - (after - 1) / (before - 1)`` of two E^2; NaN where there was nothing to close."""
    wide = np.asarray(before, dtype=float) - 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(wide > 0.0, 1.0 - (np.asarray(after) - 1.0) / wide, np.nan)
