"""How small an effect can be and still be named half the time: a logistic curve over the logarithm of its size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, log_expit
from scipy.stats import chi2

Array = NDArray[np.float64]
_LEVEL = 0.95
# Sizes between which a limit is looked for, as multiples of the smallest and the largest tried.
_BEYOND = 8.0
_GRID = 241
# Per unit of the natural logarithm of size.
_SLOPES = np.geomspace(0.3, 30.0, 60)


@dataclass(frozen=True)
class DetectionLimit:
    """size: noise floors, named half the time, None where every size tried was named, or none; interval: 95 %, an end
    that lies beyond the sizes tried is None."""

    size: float | None
    interval: tuple[float | None, float | None]
    named: int
    total: int


def detection_limit(sizes: Sequence[float], named: Sequence[bool]) -> DetectionLimit:
    """The size at which an effect is named half the time.

    Firth's penalised likelihood, which is finite where the sizes that were named and those that were not do not
    overlap; the interval from its profile. A probability that does not grow with size is not fitted.
    """
    count, total = int(sum(named)), len(named)
    if total == 0:
        return DetectionLimit(None, (None, None), 0, 0)
    x, y = np.log(np.asarray(sizes, dtype=float)), np.asarray(named, dtype=float)
    centres = np.linspace(x.min() - np.log(_BEYOND), x.max() + np.log(_BEYOND), _GRID)
    profile = _profile(x, y, centres)
    near = centres[profile >= profile.max() - 0.5 * chi2.ppf(_LEVEL, 1)]
    ends = (
        None if near[0] <= x.min() - 1e-9 else float(np.exp(near[0])),
        None if near[-1] >= x.max() + 1e-9 else float(np.exp(near[-1])),
    )
    if count in (0, total):
        return DetectionLimit(None, ends, count, total)
    return DetectionLimit(float(np.exp(centres[int(profile.argmax())])), ends, count, total)


def _profile(x: Array, y: Array, centres: Array) -> Array:
    """(m,) the penalised log likelihood at the best slope for each centre."""
    t = _SLOPES[:, None, None] * (x - centres[:, None])
    likelihood = np.sum(y * log_expit(t) + (1.0 - y) * log_expit(-t), axis=-1)
    p = expit(t)
    weight = p * (1.0 - p)
    # Fisher's information of intercept and slope.
    a, b, c = weight.sum(-1), (weight * x).sum(-1), (weight * x * x).sum(-1)
    best: Array = (likelihood + 0.5 * np.log(np.maximum(a * c - b * b, 1e-12))).max(axis=0)
    return best
