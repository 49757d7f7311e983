"""Comparisons of two fits: paired differences of held-out scores over blocks of time, and likelihood ratios.

Every comparison of two models in the engine is one of these. `NAMING_LEVEL` is shared among all candidates of a step
(Bonferroni), since the best of many wins by chance more often than one alone.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2, norm
from scipy.stats import t as student

from slider_drilling.gap.evidence.block_bootstrap import BlockBootstrap
from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.model import Array
from slider_drilling.gap.search.least_squares import Fit

NAMING_LEVEL = 0.05
# Difference of -2 log p that two fits of the same model may show by rounding.
_ROUNDING = 1e-6


def held_out_gain(bootstrap: BlockBootstrap, better: HeldOutScore, worse: HeldOutScore) -> Array:
    """(RESAMPLES,) by how much the held-out deviance of ``better`` is below that of ``worse``, per resample."""
    return bootstrap.resampled_sum(worse.density - better.density)


def predicts_better(bootstrap: BlockBootstrap, better: HeldOutScore, worse: HeldOutScore, candidates: int = 1) -> bool:
    """Whether ``better`` predicts held-out data better, by a block bootstrap.

    Args:
        bootstrap: Resamples of the log, the same for all comparisons.
        better: Score that is expected to be better.
        worse: Score to compare with.
        candidates: Number of candidates that share the level (Bonferroni).

    Returns:
        True if the lower bound of the gain, at ``NAMING_LEVEL / candidates``, is above zero.
    """
    return float(np.quantile(held_out_gain(bootstrap, better, worse), NAMING_LEVEL / candidates)) > _ROUNDING


def predicts_better_among(
    bootstrap: BlockBootstrap, better: HeldOutScore, worse: HeldOutScore, candidates: int
) -> bool:
    """Whether one of several candidates predicts held-out data better, in short logs too.

    With half a dozen blocks no resample can reach the shared level unless every single block gains. The held-out
    likelihood ratio may then account for the number of candidates, and the bootstrap only has to show, at the level of
    one comparison, that the gain comes from more than one block.

    Args and return value: as `predicts_better`.
    """
    sharing = 1 if exceeds_evidence_threshold(better, worse, candidates) else candidates
    return predicts_better(bootstrap, better, worse, sharing)


def evidence_threshold(candidates: int) -> float:
    """``2 log(candidates / NAMING_LEVEL)``: a likelihood ratio above it rejects at the shared level.

    By Markov's inequality, for any model (Wasserman, Ramdas and Balakrishnan, PNAS 117, 2020).
    """
    return 2.0 * float(np.log(candidates / NAMING_LEVEL))


def exceeds_evidence_threshold(better: HeldOutScore, worse: HeldOutScore, candidates: int) -> bool:
    """Whether the held-out likelihood ratio of two scores exceeds `evidence_threshold`."""
    return worse.held_out_deviance - better.held_out_deviance > evidence_threshold(candidates)


def fit_exceeds_evidence_threshold(candidate: Fit, current: Fit, candidates: int) -> bool:
    """Whether the likelihood ratio over the whole log exceeds `evidence_threshold`.

    Two units of ``-2 log p`` are subtracted per added parameter: what it gains on the data that it was fitted to and
    would not gain on new data (Akaike, IEEE Transactions on Automatic Control 19, 1974).
    """
    added = len(candidate.parameters) - len(current.parameters)
    return current.cost - candidate.cost - 2.0 * added > evidence_threshold(candidates)


def chi2_critical(added: int, candidates: int = 1, level: float = NAMING_LEVEL) -> float:
    """Gain of ``-2 log p`` that ``added`` free parameters exceed on noise alone at ``level / candidates`` (Wilks)."""
    return float(chi2.ppf(1.0 - level / candidates, max(added, 1)))


def passes_likelihood_ratio_test(current: Fit, candidate: Fit, candidates: int = 1) -> bool:
    """Whether the candidate gains more ``-2 log p`` over the whole log than its added parameters do by chance (Wilks).

    Args:
        current: Fit of the smaller model.
        candidate: Fit of the larger model, which contains the smaller one.
        candidates: Number of candidates that share the level (Bonferroni).
    """
    added = len(candidate.parameters) - len(current.parameters)
    return current.cost - candidate.cost > chi2_critical(added, candidates)


def resampled_squared_gaps(bootstrap: BlockBootstrap, score: HeldOutScore) -> Array:
    """(RESAMPLES,) E^2 of each resample."""
    return bootstrap.resampled_sum(score.squares) / bootstrap.resampled_sum(np.ones_like(score.squares))


def gap_closed(
    bootstrap: BlockBootstrap, before: HeldOutScore, after: HeldOutScore
) -> tuple[float, tuple[float, float]]:
    """Share of the gap that is closed, with its 95 % interval.

    Args:
        bootstrap: Weights of the log's blocks.
        before: Held-out score of the model without the effect.
        after: Held-out score of the model with it.

    Returns:
        ``1 - (E_after^2 - 1) / (E_before^2 - 1)`` and its interval; NaN where ``before`` leaves no gap. Weights of the
        blocks under which there is no gap do not count.
    """
    within = _interval(share_closed(*_weighted_gaps(bootstrap, before, after)), bootstrap.block_count)
    return float(share_closed(before.gap**2, after.gap**2)), within


def gap_reduction_significant(bootstrap: BlockBootstrap, before: HeldOutScore, after: HeldOutScore) -> bool:
    """Whether the gap shrinks significantly, however little.

    Returns:
        True if the 95 % interval of the reduction of E^2 lies above zero, and so does that of the share that is closed
        where there is a gap to close.
    """
    wide, narrow = _weighted_gaps(bootstrap, before, after)
    reduction, closed = (
        _interval(drawn, bootstrap.block_count)[0] for drawn in (wide - narrow, share_closed(wide, narrow))
    )
    # The share is NaN where no weights leave a gap: then only the reduction counts.
    return reduction > 0.0 and not closed <= 0.0


def share_closed(before: Array | float, after: Array | float) -> Array:
    """``1 - (after - 1) / (before - 1)`` of two E^2; NaN where ``before`` is no gap."""
    wide = np.asarray(before, dtype=float) - 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(wide > 0.0, 1.0 - (np.asarray(after) - 1.0) / wide, np.nan)


def _weighted_gaps(bootstrap: BlockBootstrap, *scores: HeldOutScore) -> list[Array]:
    """(RESAMPLES,) E^2 under the weights, of each score."""
    size = bootstrap.weighted_sum(np.ones_like(scores[0].squares))
    return [bootstrap.weighted_sum(score.squares) / size for score in scores]


def _interval(drawn: Array, blocks: int) -> tuple[float, float]:
    """95 % interval of what was drawn with weights of so many blocks, NaN where no draw is a number.

    Weights of a few blocks scatter less than as many new logs would. The interval is therefore widened as that of a
    mean is, from the normal distribution to Student's (Hesterberg, The American Statistician 69, 2015).
    """
    drawn, blocks = drawn[np.isfinite(drawn)], max(blocks, 2)
    if not drawn.size:
        return float("nan"), float("nan")
    wider = np.sqrt((blocks + 1.0) / (blocks - 1.0)) * student.ppf(1.0 - 0.5 * NAMING_LEVEL, blocks - 1)
    return float(np.quantile(drawn, norm.cdf(-wider))), float(np.quantile(drawn, norm.cdf(wider)))
