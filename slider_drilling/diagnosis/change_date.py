"""When a named change began: by how much of it the samples hold over time.

The simulation without the change and the one with all of it differ by what the change does to every channel. The
share of that which is in the measurements, block by block, is a matched filter: none before the change, all of it
after a step. The likelihood of a step or a ramp of that share, for every time at which it may begin, dates the change.
What share the rig seems to have of it before and after is not assumed. Shares that are not about none and all speak
against the whole picture; then nothing is dated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.diagnosis.baseline import Baseline, shared_nuisance
from slider_drilling.diagnosis.change_search import TriedChange
from slider_drilling.diagnosis.changed_string import ChangedString, compared_around
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.onset import Onset
from slider_drilling.diagnosis.start_state import fit_start_state
from slider_drilling.diagnosis.usual_error import problem_in_units
from slider_drilling.effects import EFFECTS
from slider_drilling.gap.model import Array, Channel
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import fit

_BLOCK_S = 5.0  # over which a share is taken
_ALIKE = 6  # blocks in a row whose errors go together
_EDGE = 6  # blocks on either side of the times that are tried
_MIN_SAMPLES = 100  # of a channel, before and after the change
# Shares before and after a change that is dated; and gain (`Rise.gain`) of one that is dated, and that there is at all.
_BEFORE, _AFTER, _DATED_GAIN, _LEAST_GAIN = 0.35, (0.6, 1.4), 30.0, 20.0


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
        weight: (n,) its information: the inverse of its variance if all errors were white.
    """

    time: Array
    share: Array
    weight: Array


@dataclass(frozen=True)
class Rise:
    """How the share of a change rises, as the likeliest step or ramp has it.

    Attributes:
        before, after: Share at the start and at the end.
        gain: ``-2 log p`` beyond one constant share, in units of what the shares scatter.
        begins: When it begins.
    """

    before: float
    after: float
    gain: float
    begins: ChangeDate

    @property
    def shows(self) -> bool:
        """Whether the samples since hold more of the change than those before."""
        return self.gain >= _LEAST_GAIN and self.after > self.before

    @property
    def date(self) -> ChangeDate | None:
        """When the change began; None where the share is not about none before and about all after."""
        plain = abs(self.before) <= _BEFORE and _AFTER[0] <= self.after <= _AFTER[1] and self.gain >= _DATED_GAIN
        return self.begins if plain else None


def rise_of_change(string: DrillString, baseline: Baseline, named: TriedChange, onset: Onset) -> Rise | None:
    """How a named change rises over a log.

    Args:
        string: Model of one later log that begins well before the change.
        baseline: What was before.
        named: The change.
        onset: What is known of when it began, in that log.

    Returns:
        None where no channel has samples from before and after it, or it does nothing in them.
    """
    shown = [channel.name for channel in string.runs[0].channels if _on_both_sides(channel, onset)]
    string = string.with_channels(shown)
    if all(channel.accumulates for channel in string.runs[0].channels):
        return None
    share = share_over_time(string, baseline, named, onset)
    return None if share is None else rise_of(share)


def _on_both_sides(channel: Channel, onset: Onset) -> bool:
    """Whether a channel has samples from before and from after a change."""
    before, after = channel.time < onset.unchanged_until, channel.time >= onset.changed_from
    return bool(min(np.count_nonzero(before), np.count_nonzero(after)) >= _MIN_SAMPLES)


def share_over_time(
    string: DrillString, baseline: Baseline, named: TriedChange, onset: Onset
) -> ShareOverTime | None:
    """How much of a change the samples hold; arguments as of `rise_of_change`. None where it does nothing in them."""
    own = {parameter.name for parameter in named.effect.parameters}
    fitted = {name: value for name, value in named.fit.values.items() if "@" not in name}
    shared = {**baseline.values, **{name: value for name, value in fitted.items() if name not in own}}
    model = ChangedString(string, shared, shared_nuisance(string.nuisance, baseline), (named.effect,))
    problem = problem_in_units(model, baseline.noise).at_fidelity_of((named.effect,))

    only_before = replace(model, string=compared_around(string, Onset(onset.unchanged_until, math.inf)))
    state = fit_start_state(problem_in_units(only_before, baseline.noise)).values
    state = {name: value for name, value in state.items() if "@" in name}
    change = {name: value for name, value in fitted.items() if name in own}
    only_after = replace(model, string=compared_around(string, Onset(-math.inf, onset.changed_from)))
    change |= _of_this_log(problem_in_units(only_after, baseline.noise), named, state | change)

    without, full = problem.residuals([state, state | change])
    return _shares(problem, without, without - full, onset)


def _of_this_log(problem: Problem, named: TriedChange, values: dict[str, float]) -> dict[str, float]:
    """What of a change belongs to a log, such as the phase of a wave: another one in a log that begins elsewhere."""
    definition = EFFECTS.get(named.effect.name)
    keys = definition.per_run if definition is not None else {}
    found = {}
    for parameter in named.effect.parameters:
        shifts = keys.get(parameter.name.rpartition(".")[2])
        if shifts is not None and parameter.name in values:
            starts = [values | {parameter.name: values[parameter.name] + shift} for shift in shifts]
            best = min((fit(problem, [parameter], start) for start in starts), key=lambda each: each.cost)
            found[parameter.name] = best.values[parameter.name]
    return found


def _shares(problem: Problem, without: Array, difference: Array, onset: Onset) -> ShareOverTime | None:
    """The shares from the residual without the change (N,) and what all of it adds to the simulation (N,)."""
    since = np.concatenate([piece.channel.time >= onset.changed_from for piece in problem.pieces])
    _, discrepancies = problem.cost(without - difference * since)
    steady = [index for index, piece in enumerate(problem.pieces) if not piece.channel.accumulates]
    residual, (row,) = problem.whitened(without, difference[None], discrepancies)
    time = np.concatenate([problem.pieces[index].channel.time for index in steady])
    rows = np.concatenate([np.arange(problem.size)[problem.pieces[index].rows] for index in steady])
    begin = float(time.min())
    block = ((time - begin) // _BLOCK_S).astype(int)
    weight: Array = np.bincount(block, row[rows] ** 2).astype(float)
    product: Array = np.bincount(block, row[rows] * residual[rows]).astype(float)
    held = np.flatnonzero(weight > 0.0)
    if held.size <= 2 * _EDGE:
        return None
    middle = begin + _BLOCK_S * (held.astype(float) + 0.5)
    return ShareOverTime(middle, product[held] / weight[held], weight[held])


def rise_of(shares: ShareOverTime) -> Rise:
    """The likeliest step or ramp of shares, and when it begins: the posterior is over both shapes.

    Errors that go together in neighbouring blocks count as their scatter says.
    """
    time, share, weight = shares.time, shares.share, shares.weight
    begins = np.arange(time[_EDGE], time[-_EDGE], _BLOCK_S) - 0.5 * _BLOCK_S
    steps = (time[:, None] > begins).astype(float)
    ramps = np.maximum(time[:, None] - begins, 0.0)
    shapes = np.concatenate([steps, ramps / ramps[-1]], axis=1)
    # Weighted regression on a constant and one shape, for every shape.
    mean = np.average(share, weights=weight)
    centre = np.average(shapes, axis=0, weights=weight)
    variance = np.maximum(weight @ (shapes - centre) ** 2, 1e-12)
    slope = (weight * (share - mean)) @ (shapes - centre) / variance
    gain = slope**2 * variance
    best = int(np.argmax(gain))
    before = float(mean - slope[best] * centre[best])
    scatter = _scatter(share - before - slope[best] * shapes[:, best], weight)
    low, since, high = _quantiles(begins, np.exp(0.5 * (gain - gain[best]) / scatter))
    date = ChangeDate(since, (low - _BLOCK_S, high + _BLOCK_S))
    return Rise(before, before + float(slope[best]), float(gain[best]) / scatter, date)


def _scatter(error: Array, weight: Array) -> float:
    """Mean square of errors (n,) in white standard deviations, of groups of blocks; at least 1."""
    group = np.arange(error.size) // _ALIKE
    sums, weights = np.bincount(group, weight * error), np.bincount(group, weight)
    return max(float(np.mean(sums**2 / weights)), 1.0)


def _quantiles(begins: Array, likelihood: Array) -> tuple[float, float, float]:
    """Lower end, middle and upper end (95 %) of the posterior of the times (n,) by their likelihood (2 n,)."""
    share = likelihood.reshape(2, -1).sum(axis=0)
    share /= np.sum(share)
    low, middle, high = np.interp((0.025, 0.5, 0.975), np.cumsum(share) - 0.5 * share, begins)
    return float(low), float(middle), float(high)
