"""When the share of a change begins to rise.

A regression of the shares on a constant and a step or a ramp, for every time at which it may begin. Errors of the
shares are white, and wander besides with a memory: a Gaussian process (Rasmussen and Williams, 2006, section 2.7). How
much they wander, and for how long, is not known; the likelihood of each counts with what it says of the onset.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.special import logsumexp

from slider_drilling.gap.model import Array

BLOCK_S = 5.0
"""s over which one share is taken."""
_EDGE = 6  # blocks on either side of the times that are tried
# s that a change takes to grow to all of it, and the prior of each: steps count as much as all ramps together, one of
# which goes on to the end.
_GROWTHS_S = (0.0, *np.geomspace(60.0, 900.0, 9), math.inf)
_PRIOR = np.array([0.5, *np.full(len(_GROWTHS_S) - 1, 0.5 / (len(_GROWTHS_S) - 1))])
# Sizes (shares) and memories (s) that a wander may have; every pair is as likely.
_WANDERS = tuple(itertools.product((0.03, 0.1, 0.2, 0.4, 0.8), (20.0, 60.0, 200.0, 600.0)))
_SHOWN_BLOCKS = 6  # that make one dot of a picture
# Shares before and after a change that is dated; and how much likelier a rise is then (`Rise.evidence`): 20 to 1.
_BEFORE, _AFTER, _DATED_EVIDENCE = 0.35, (0.6, 1.4), 6.0


@dataclass(frozen=True)
class ChangeDate:
    """When a change began.

    Attributes:
        since: s from the log's start.
        interval: s, 95 % interval of that.
    """

    since: float
    interval: tuple[float, float]

    def shifted(self, later: float) -> ChangeDate:
        """The same, so many s later: in a log in which this one begins then."""
        low, high = self.interval
        return ChangeDate(self.since + later, (low + later, high + later))

    def says_more_than(self, interval: tuple[float, float] | None) -> bool:
        """Whether it is narrower than another interval (s) that it agrees with. One that it contradicts is wrong: what
        single numbers show late, as one does behind an operation, looks as if it had begun then."""
        if interval is None:
            return True
        (low, high), (first, last) = self.interval, interval
        return high < first or low > last or high - low <= last - first


@dataclass(frozen=True)
class ShareOverTime:
    """How much of a change the samples hold, by blocks of time without those that hold nothing of it.

    Attributes:
        time: (n,) s, middle of each block.
        share: (n,) least-squares amplitude of the change in each.
        variance: (n,) of that.
    """

    time: Array
    share: Array
    variance: Array

    def in_groups(self, size: int) -> ShareOverTime:
        """The same by groups of so many blocks."""
        group = np.arange(self.share.size) // size
        weight: Array = np.bincount(group, 1.0 / self.variance).astype(float)
        time, share = (np.bincount(group, each / self.variance) / weight for each in (self.time, self.share))
        return ShareOverTime(time, share, 1.0 / weight)


@dataclass(frozen=True)
class Rise:
    """How the share of a change rises: the mean over all steps and ramps as likely as they are.

    Attributes:
        before, after: Share at the start and at the end.
        evidence: Twice the logarithm of how much likelier a rise is than one constant share.
        begins: When it begins.
        gradual: Whether a ramp is likelier than a step.
        shown: The shares by half minutes, with the variance of their wander, too.
    """

    before: float
    after: float
    evidence: float
    begins: ChangeDate
    gradual: bool
    shown: ShareOverTime

    def shifted(self, later: float) -> Rise:
        """The same, so many s later: in a log in which this one begins then."""
        shown = replace(self.shown, time=self.shown.time + later)
        return replace(self, begins=self.begins.shifted(later), shown=shown)

    @property
    def shows(self) -> bool:
        """Whether the samples since hold more of the change than those before."""
        return self.evidence > 0.0 and self.after > self.before

    @property
    def date(self) -> ChangeDate | None:
        """When the change began; None where the share is not about none before and about all after."""
        from_none_to_all = abs(self.before) <= _BEFORE and _AFTER[0] <= self.after <= _AFTER[1]
        return self.begins if from_none_to_all and self.evidence >= _DATED_EVIDENCE else None


@dataclass(frozen=True)
class _Regression:
    """Shares on a constant and one of m shapes.

    Attributes:
        likelihood: (m,) logarithm, with the constant and the height integrated out.
        without: The same without any shape.
        before: (m,) the constant.
        height: (m,) of the shape.
    """

    likelihood: Array
    without: float
    before: Array
    height: Array


def long_enough_to_rise(blocks: int) -> bool:
    """Whether so many blocks leave a time to try."""
    return blocks > 2 * _EDGE


def rise_of(shares: ShareOverTime) -> Rise:
    """How shares rise, by a step or a ramp that begins at any time, beside a wander of any size."""
    begins = np.arange(shares.time[_EDGE], shares.time[-_EDGE], BLOCK_S) - 0.5 * BLOCK_S
    shapes = np.concatenate([_growing(shares.time, begins, growth) for growth in _GROWTHS_S], axis=1)
    apart, white = np.abs(shares.time[:, None] - shares.time), np.diag(shares.variance)
    fits = [_regress(shares.share, size**2 * np.exp(-apart / memory) + white, shapes) for size, memory in _WANDERS]
    likelihood = np.array([each.likelihood for each in fits]).reshape(len(fits), len(_GROWTHS_S), begins.size)
    likelihood += np.log(_PRIOR / begins.size)[:, None]
    total = logsumexp(likelihood)
    posterior, without = np.exp(likelihood - total), logsumexp([each.without for each in fits])
    low, since, high = _quantiles(begins, posterior.sum(axis=(0, 1)))
    size = math.sqrt(np.average([size**2 for size, _ in _WANDERS], weights=posterior.sum(axis=(1, 2))))
    before, height = (
        float(np.average([getattr(each, name) for each in fits], weights=posterior.reshape(len(fits), -1)))
        for name in ("before", "height")
    )
    shown = shares.in_groups(_SHOWN_BLOCKS)
    return Rise(
        before, before + height, 2.0 * float(total - without), ChangeDate(since, (low - BLOCK_S, high + BLOCK_S)),
        bool(posterior[:, 0].sum() < 0.5), replace(shown, variance=shown.variance + size**2),
    )  # fmt: skip


def _growing(time: Array, begins: Array, growth: float) -> Array:
    """(n, m) share of a change at times (n,) that begins at each of (m,), and takes so many s to grow to all of it."""
    since = time[:, None] - begins
    if growth == 0.0:
        return (since > 0.0).astype(float)
    return np.clip(since / np.minimum(growth, since[-1]), 0.0, 1.0)


def _regress(shares: Array, covariance: Array, shapes: Array) -> _Regression:
    """Generalised least squares of shares (n,) with errors of this covariance (n, n) on a constant and each of the
    shapes (n, m)."""
    factor = cholesky(covariance, lower=True)
    columns = np.column_stack([np.ones_like(shares), shares, shapes])
    one, share, *rows = solve_triangular(factor, columns, lower=True).T
    shape, constant = np.array(rows), one @ one
    mean, overlap = share @ one / constant, shape @ one / constant
    share, shape = share - mean * one, shape - overlap[:, None] * one
    # The height is a share: its prior is normal, of size 1.
    information = np.einsum("ij,ij->i", shape, shape) + 1.0
    height = shape @ share / information
    without = -np.sum(np.log(np.diag(factor))) - 0.5 * (np.log(constant) + share @ share)
    likelihood = without + 0.5 * (height**2 * information - np.log(information))
    return _Regression(likelihood, float(without), mean - overlap * height, height)


def _quantiles(begins: Array, posterior: Array) -> tuple[float, float, float]:
    """Lower end, middle and upper end (95 %) of a posterior (n,), whose sum is 1, of times (n,), s."""
    low, middle, high = np.interp((0.025, 0.5, 0.975), np.cumsum(posterior) - 0.5 * posterior, begins)
    return float(low), float(middle), float(high)
