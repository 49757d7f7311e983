"""When a named change began: by how much of it the samples hold over time.

The simulation without the change and the one with all of it differ by what the change does to every channel. The
share of that which is in the measurements, block by block, is a matched filter: none before the change, all of it
after a step. The likelihood of a step or a ramp of that share, for every time at which it may begin, dates the change.
What share the rig seems to have of it before and after is not assumed. Shares that are not about none and all speak
against the whole picture; then nothing is dated.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from slider_drilling.diagnosis.baseline import Baseline, shared_nuisance
from slider_drilling.diagnosis.change_search import TriedChange
from slider_drilling.diagnosis.changed_string import ChangedString, compared_around
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.onset import Onset
from slider_drilling.diagnosis.share_rise import BLOCK_S, Rise, ShareOverTime, long_enough_to_rise, rise_of
from slider_drilling.diagnosis.start_state import fit_start_state
from slider_drilling.diagnosis.usual_error import problem_in_units
from slider_drilling.effects import EFFECTS
from slider_drilling.gap.model import Array, Channel
from slider_drilling.gap.problem.problem import Problem
from slider_drilling.gap.search.least_squares import fit

_MIN_SAMPLES = 100  # of a channel, before and after the change


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
    block = ((time - begin) // BLOCK_S).astype(int)
    weight: Array = np.bincount(block, row[rows] ** 2).astype(float)
    product: Array = np.bincount(block, row[rows] * residual[rows]).astype(float)
    held = np.flatnonzero(weight > 0.0)
    if not long_enough_to_rise(held.size):
        return None
    middle = begin + BLOCK_S * (held.astype(float) + 0.5)
    return ShareOverTime(middle, product[held] / weight[held], 1.0 / weight[held])
