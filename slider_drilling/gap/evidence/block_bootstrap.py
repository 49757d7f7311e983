"""Blocks of time, resampled and weighted: how much of a comparison comes from one stretch of the log.

Resamples (Kuensch, The Annals of Statistics 17, 1989) decide whether a difference is significant: what one stretch
alone shows is absent from a third of them. They cannot give the size of a ratio whose denominator lies in one stretch.
Weights (Rubin, The Annals of Statistics 9, 1981) leave no stretch out, and give its interval.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.evidence.score import Folds
from slider_drilling.gap.model import Array

RESAMPLES = 2000
# Parts of a block, each with a weight of its own.
_PARTS = 8


@dataclass(frozen=True)
class BlockBootstrap:
    """Circular block bootstrap over time, the same for all that is compared.

    Attributes:
        folds: Instants and blocks of every run.
        starts: Per run, (RESAMPLES, blocks) first instant of each drawn block. The last block of each resample is
            shorter, so that all together are as long as the run.
        weights: Per run, (RESAMPLES, parts) weights of equal parts of it, 1 on average.
    """

    folds: Folds
    starts: tuple[NDArray[np.int_], ...] = field(repr=False)
    weights: tuple[Array, ...] = field(repr=False)

    @property
    def block_count(self) -> int:
        """Number of blocks in all runs."""
        return sum(starts.shape[1] for starts in self.starts)

    def resampled_sum(self, values: Array) -> Array:
        """(RESAMPLES,) sum of values (N,) over each resample."""
        total = np.zeros(RESAMPLES)
        for own, starts, block in zip(self._by_run(values), self.starts, self.folds.block, strict=True):
            # Sums over blocks as differences of cumulative sums; the run is laid end to end for blocks that wrap.
            before = np.append(0.0, np.cumsum(np.append(own, own)))
            length = np.full(starts.shape[1], block)
            length[-1] = own.size - block * (starts.shape[1] - 1)
            total += np.sum(before[starts + length] - before[starts], axis=1)
        return total

    def weighted_sum(self, values: Array) -> Array:
        """(RESAMPLES,) sum of values (N,) under each set of weights."""
        total = np.zeros(RESAMPLES)
        for own, weights in zip(self._by_run(values), self.weights, strict=True):
            begin = np.arange(weights.shape[1]) * own.size // weights.shape[1]
            total += weights @ np.add.reduceat(own, begin)
        return total

    def _by_run(self, values: Array) -> list[Array]:
        """Per run, (instants,) sum of values (N,) at each instant."""
        by_instant = np.bincount(self.folds.instant, weights=values, minlength=sum(self.folds.instants))
        return np.split(by_instant, np.cumsum(self.folds.instants)[:-1])


def make_bootstrap(folds: Folds, seed: int) -> BlockBootstrap:
    """Draw resamples and weights."""
    generator = np.random.default_rng(seed)
    runs = list(zip(folds.instants, folds.block, strict=True))
    starts = [
        generator.integers(0, instants, size=(RESAMPLES, int(np.ceil(instants / block)))) for instants, block in runs
    ]
    return BlockBootstrap(folds, tuple(starts), tuple(_weights(generator, instants, block) for instants, block in runs))


def _weights(generator: np.random.Generator, instants: int, block: int) -> Array:
    """(RESAMPLES, parts) weights, exponential for every stretch as long as a block, and smooth in time.

    Each part's weight is a moving sum of gamma variates: the more two stretches overlap, the more alike their weights.
    """
    each = min(_PARTS, block)
    parts = max(instants * each // block, 1)
    shares = generator.gamma(1.0 / each, size=(RESAMPLES, parts))
    around = np.hstack([shares, shares[:, : each - 1]])
    weights: Array = np.lib.stride_tricks.sliding_window_view(around, each, axis=1).sum(axis=2)
    return weights / weights.mean(axis=1, keepdims=True)
