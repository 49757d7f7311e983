"""Blocks of time, drawn and weighed: what of a comparison is one stretch's doing.

Whether something is so for certain, resamples say (Kuensch, The Annals of Statistics 17, 1989): what one stretch alone
shows is absent from a third of them. How large a ratio is they cannot say where that stretch holds all that the ratio
is of. Weights (Rubin, The Annals of Statistics 9, 1981) leave no stretch out.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slider_drilling.gap.evidence.score import Folds
from slider_drilling.gap.model import Array

RESAMPLES = 2000
_PARTS = 8  # of a block, each with a weight of its own


@dataclass(frozen=True)
class BlockBootstrap:
    """Circular block bootstrap over time, the same for all that is compared.

    starts: per run, (RESAMPLES, blocks) the instants at which what is drawn begins, the last of each shorter so that
    all together are as long as the run; weights: per run, (RESAMPLES, parts) of equal parts of it, 1 on average.
    """

    folds: Folds
    starts: tuple[NDArray[np.int_], ...] = field(repr=False)
    weights: tuple[Array, ...] = field(repr=False)

    @property
    def block_count(self) -> int:
        """Blocks in the log."""
        return sum(starts.shape[1] for starts in self.starts)

    def resampled_sum(self, values: Array) -> Array:
        """(RESAMPLES,) sum of values (N,) over what was drawn."""
        total = np.zeros(RESAMPLES)
        for own, starts, block in zip(self._by_run(values), self.starts, self.folds.block, strict=True):
            before = np.append(0.0, np.cumsum(np.append(own, own)))
            length = np.full(starts.shape[1], block)
            length[-1] = own.size - block * (starts.shape[1] - 1)
            total += np.sum(before[starts + length] - before[starts], axis=1)
        return total

    def weighted_sum(self, values: Array) -> Array:
        """(RESAMPLES,) sum of values (N,) by weight."""
        total = np.zeros(RESAMPLES)
        for own, weights in zip(self._by_run(values), self.weights, strict=True):
            begin = np.arange(weights.shape[1]) * own.size // weights.shape[1]
            total += weights @ np.add.reduceat(own, begin)
        return total

    def _by_run(self, values: Array) -> list[Array]:
        """Per run, (instants,) the sum of values (N,) at each instant."""
        by_instant = np.bincount(self.folds.instant, weights=values, minlength=sum(self.folds.instants))
        return np.split(by_instant, np.cumsum(self.folds.instants)[:-1])


def make_bootstrap(folds: Folds, seed: int) -> BlockBootstrap:
    """Draw the resamples and the weights once."""
    generator = np.random.default_rng(seed)
    runs = list(zip(folds.instants, folds.block, strict=True))
    starts = [generator.integers(0, long, size=(RESAMPLES, int(np.ceil(long / block)))) for long, block in runs]
    return BlockBootstrap(folds, tuple(starts), tuple(_weights(generator, long, block) for long, block in runs))


def _weights(generator: np.random.Generator, instants: int, block: int) -> Array:
    """(RESAMPLES, parts) weights: of every stretch as long as a block they are exponential, and of two they are the
    more alike the more these overlap.
    """
    each = min(_PARTS, block)
    parts = max(instants * each // block, 1)
    shares = generator.gamma(1.0 / each, size=(RESAMPLES, parts))
    around = np.hstack([shares, shares[:, : each - 1]])
    weights: Array = np.lib.stride_tricks.sliding_window_view(around, each, axis=1).sum(axis=2)
    return weights / weights.mean(axis=1, keepdims=True)
