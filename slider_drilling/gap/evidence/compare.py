"""The only "better than": paired differences of held-out scores over blocks of time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, norm
from scipy.stats import t as student

from slider_drilling.gap.evidence.score import Folds, Score
from slider_drilling.gap.model import Array

RESAMPLES = 2000
LEVEL = 0.05
_ROUNDING = 1e-6  # -2 log p, that two fits of the same thing differ by


@dataclass(frozen=True)
class Blocks:
    """Circular block bootstrap over time: counts (RESAMPLES, B) of every bin, the same for all that is compared."""

    folds: Folds
    counts: Array

    @property
    def number(self) -> int:
        """Blocks in the log."""
        pairs = zip(self.folds.bins_of, self.folds.block, strict=True)
        return sum(int(np.ceil(bins.size / block)) for bins, block in pairs)


def make_blocks(folds: Folds, seed: int) -> Blocks:
    """Draw the resamples once."""
    generator = np.random.default_rng(seed)
    total = sum(bins.size for bins in folds.bins_of)
    counts = np.zeros((RESAMPLES, total))
    for bins, block in zip(folds.bins_of, folds.block, strict=True):
        number = int(np.ceil(bins.size / block))
        starts = generator.integers(0, bins.size, size=(RESAMPLES, number))
        drawn = ((starts[:, :, None] + np.arange(block)) % bins.size).reshape(RESAMPLES, -1)[:, : bins.size]
        flat = bins[drawn] + total * np.arange(RESAMPLES)[:, None]
        counts += np.bincount(flat.ravel(), minlength=counts.size).reshape(counts.shape)
    return Blocks(folds, counts)


def advantage(blocks: Blocks, better: Score, worse: Score) -> Array:
    """(RESAMPLES,) by how much ``-2 log p`` of unseen data is lower with one than with the other."""
    difference = worse.density - better.density
    by_bin = np.bincount(blocks.folds.bins, weights=difference, minlength=blocks.counts.shape[1])
    return np.asarray(blocks.counts @ by_bin)


def beats(blocks: Blocks, better: Score, worse: Score, rivals: int = 1, level: float = LEVEL) -> bool:
    """Whether one foretells more than the other at ``level`` shared among so many rivals (Bonferroni)."""
    return float(np.quantile(advantage(blocks, better, worse), level / rivals)) > _ROUNDING


def beyond_doubt(better: Score, worse: Score, rivals: int) -> bool:
    """Whether the likelihood ratio of what was held out is above one over the level shared among so many rivals
    (Wasserman, Ramdas and Balakrishnan, PNAS 117, 2020).
    """
    gained = worse.surprise - better.surprise
    return gained > 2.0 * float(np.log(rivals / LEVEL))


def foretells_more(blocks: Blocks, better: Score, worse: Score, rivals: int) -> bool:
    """Whether one of so many rivals foretells more for certain.

    Of half a dozen blocks no resample says that at the shared level unless every single one gains. Then the likelihood
    ratio may stand for how many rivals there are, and the blocks only for that it comes from more than one of them.
    """
    return beats(blocks, better, worse, 1 if beyond_doubt(better, worse, rivals) else rivals)


def by_chance(added: int, rivals: int = 1) -> float:
    """What so many free parameters gain of ``-2 log p`` on noise (Wilks), at the level shared among so many rivals."""
    return float(chi2.ppf(1.0 - LEVEL / rivals, max(added, 1)))


def gaps(blocks: Blocks, score: Score) -> Array:
    """(RESAMPLES,) E^2."""
    bins, size = blocks.folds.bins, blocks.counts.shape[1]
    sums = blocks.counts @ np.bincount(bins, weights=score.squares, minlength=size)
    return np.asarray(sums / (blocks.counts @ np.bincount(bins, minlength=size)))


def closed_between(blocks: Blocks, before: Score, after: Score) -> tuple[float, tuple[float, float]]:
    """Share of the gap before that is closed after, and its 95 % interval; NaN where there was nothing to close.

    Resamples of a few blocks scatter less than as many new logs would: the interval is expanded as a mean's is from the
    normal distribution to Student's (Hesterberg, The American Statistician 69, 2015).
    """
    shares = share_closed(gaps(blocks, before), gaps(blocks, after))
    known = shares[np.isfinite(shares)]
    number = max(blocks.number, 2)
    beyond = float(norm.cdf(-np.sqrt(number / (number - 1.0)) * student.ppf(1.0 - 0.5 * LEVEL, number - 1)))
    ends = (beyond, 1.0 - beyond)
    low, high = (float(np.quantile(known, q)) if known.size else float("nan") for q in ends)
    return float(share_closed(before.gap**2, after.gap**2)), (low, high)


def share_closed(before: Array | float, after: Array | float) -> Array:
    """``1 - (after - 1) / (before - 1)`` of two E^2; NaN where there was nothing to close."""
    wide = np.asarray(before, dtype=float) - 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(wide > 0.0, 1.0 - (np.asarray(after) - 1.0) / wide, np.nan)
