"""Distinguishes the publishers of one topic: parts of one signal are joined, a second one that sends zeros is left out.

A log does not name publishers. What distinguishes them is the channel (some recorders make one for each), the texts and
array lengths of their messages, and their sequence numbers. Groups of messages that follow each other in time, or
whose values agree where they overlap, are one signal in several parts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slider_drilling.errors import InputError
from slider_drilling.log.timestamps import MAX_STEP_BACK, Array, Integers, Mask, StampedSamples, time_order

# Groups that differ in their texts are compared up to this number; more are no publishers.
_MAX_GROUPS = 30
# A value agrees with another group within so many of that group's own steps.
_STEPS = 3.0
# Two groups are one signal if this fraction of the values agrees.
_MIN_AGREEING = 0.5
# Zeros are a second publisher's if this fraction of them lies between samples that are not interrupted by them.
_MIN_BETWEEN = 0.8
_MIN_ZEROS = 3
# Samples this many usual steps apart are not interrupted: a sample is missing at two steps.
_UNINTERRUPTED = 1.5
_REGULAR = 0.6  # of the usual step, at least
# A signal is away from zero if it is so many times its own steps from it.
_AWAY = 10.0
_TWO_RUNS = "the same times twice, with other values: two runs in one log; `slider-drilling recover` splits it"


def keep_one_publisher(track: StampedSamples, topic: str, source: str, notes: list[str]) -> StampedSamples:
    """The samples of one publisher.

    Args:
        track: Samples of a topic in the order of the log.
        topic: Its name, for notes.
        source: The log, for messages.
        notes: Gets a sentence for what is left out.

    Raises:
        InputError: Two publishers send different values at the same time, and neither sends zeros only.
    """
    track = _without_zeros_between(track, topic, notes)
    groups = split_signals(track)
    return track if len(groups) == 1 else _without_idle_groups(track, groups, topic, source, notes)


def split_signals(track: StampedSamples) -> list[Mask]:
    """Masks (n,) of the parts of a topic that cannot be one signal, the largest first."""
    chains = _sequence_chains(track)
    if _is_constant(track.channel) and _is_constant(track.layout) and not chains:
        return [np.ones(len(track.stamp), dtype=np.bool_)]
    marks = np.column_stack([track.channel, track.layout, *chains])
    publisher = np.unique(marks, axis=0, return_inverse=True)[1].reshape(-1)
    numbers, counts = np.unique(publisher, return_counts=True)
    if len(numbers) == 1 or len(numbers) > _MAX_GROUPS:
        return [np.ones(len(publisher), dtype=np.bool_)]
    signals: list[Mask] = []
    for number in numbers[np.argsort(-counts, kind="stable")]:
        group = publisher == number
        for index, signal in enumerate(signals):
            if _can_be_one(track.select(signal), track.select(group)):
                signals[index] = signal | group
                break
        else:
            signals.append(group)
    return signals


def _is_constant(numbers: Integers) -> bool:
    return bool((numbers == numbers[0]).all())


def _sequence_chains(track: StampedSamples) -> list[Integers]:
    """Number of the chain that each sample continues, where the sequence numbers of a channel do not only grow."""
    chain = np.zeros(len(track.sequence), dtype=np.int64)
    if (np.diff(track.sequence) >= 0).all():
        return []
    for channel in np.unique(track.channel):
        own = np.flatnonzero(track.channel == channel)
        if np.diff(track.logged[own]).min(initial=0) < -MAX_STEP_BACK:
            continue  # the channel holds two runs, or its chunks are out of order
        own = own[np.argsort(track.logged[own], kind="stable")]
        sequence = track.sequence[own]
        if not sequence.any() or (np.diff(sequence) >= 0).all():
            continue
        chain[own] = _follow(sequence.tolist())
    return [chain] if chain.any() else []


def _follow(sequence: list[int]) -> list[int]:
    """Number of the chain that each number continues: of those it is greater than, the nearest."""
    last: list[int] = []
    chains = []
    for number in sequence:
        before = [k for k in range(len(last)) if last[k] < number]
        chain = max(before, key=lambda k: last[k], default=len(last))
        if chain == len(last):
            last.append(number)
            if len(last) > _MAX_GROUPS:
                return [0] * len(sequence)
        last[chain] = number
        chains.append(chain)
    return chains


def _can_be_one(signal: StampedSamples, group: StampedSamples) -> bool:
    """Whether two sets of samples can be one signal: they do not overlap in time, or agree where they do."""
    if len(signal.logged) < len(group.logged):
        signal, group = group, signal
    signal = signal.select(np.argsort(signal.logged, kind="stable"))
    inside = (group.logged > signal.logged[0]) & (group.logged < signal.logged[-1])
    if not inside.any():
        return True
    # Relative times: 1e18 ns lose their last digits as floats.
    start = signal.logged[0]
    time, at = (signal.logged - start).astype(np.float64), (group.logged[inside] - start).astype(np.float64)
    return all(
        _agrees(time, signal.values[:, k], at, group.values[inside, k]) for k in range(signal.values.shape[1])
    )


def _agrees(time: Array, signal: Array, at: Array, group: Array) -> bool:
    """Whether the values of a group lie on a signal, as far as its own steps tell; those not given agree."""
    known, given = ~np.isnan(signal), ~np.isnan(group)
    if np.count_nonzero(known) < 2 or not given.any():
        return True
    time, signal, at, group = time[known], signal[known], at[given], group[given]
    steps = np.abs(np.diff(signal))
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    allowed = _STEPS * (steps[after - 1] + np.quantile(steps, 0.95)) + 1e-9 * np.abs(group)
    agreeing = np.abs(group - np.interp(at, time, signal)) <= allowed
    return bool(np.mean(agreeing) >= _MIN_AGREEING)


def _without_idle_groups(
    track: StampedSamples, groups: list[Mask], topic: str, source: str, notes: list[str]
) -> StampedSamples:
    """Without groups that hold zeros only. Raises InputError where several others are left."""
    idle = [group for group in groups if not np.nan_to_num(track.values[group]).any()]
    live = [group for group in groups if not any(group is other for other in idle)]
    if not live:
        return track
    if len(live) > 1:
        one, two = live[:2]
        if _follow_each_other(one, two):
            raise InputError(f"{source}: {topic}: {_TWO_RUNS}")
        names = (_name(track, one), _name(track, two))
        advice = (
            f"at the same time ({', '.join(names)}); choose one with `channel` in a file for --topics"
            if names[0] != names[1]
            else "in one channel; record one of them, or each on a topic of its own"
        )
        raise InputError(f"{source}: {topic}: two publishers send different values {advice}")
    for group in idle:
        notes.append(_idle_note(track, group, topic))
    return track.select(live[0])


def _idle_note(track: StampedSamples, idle: Mask, topic: str) -> str:
    """What is said of samples of zeros that are left out."""
    marks = np.column_stack([track.channel, track.layout])
    count = np.count_nonzero(idle)
    if {*map(tuple, marks[idle].tolist())} & {*map(tuple, marks[~idle].tolist())}:
        return (
            f"{topic}: {count} samples of zeros between the others were left out: a second publisher sends them, or a "
            "sensor that drops out"
        )
    return f"{topic}: a second publisher ({_name(track, idle)}) sends zeros only; its {count} samples were left out"


def _follow_each_other(one: Mask, two: Mask) -> bool:
    """Whether one group ends in the log before the other begins."""
    first, second = np.flatnonzero(one), np.flatnonzero(two)
    return bool(first[-1] < second[0] or second[-1] < first[0])


def _name(track: StampedSamples, group: Mask) -> str:
    """What a publisher can be called."""
    channels = np.unique(track.channel[group]).tolist()
    return f"channel {', '.join(map(str, channels))}"


def _without_zeros_between(track: StampedSamples, topic: str, notes: list[str]) -> StampedSamples:
    """Without samples, and without single numbers, of zero between those of a signal that goes on undisturbed."""
    some = ~(track.values != 0.0).any(axis=1, where=~np.isnan(track.values))
    zero = some & ~np.isnan(track.values).all(axis=1) if some.any() else some
    if _is_second(track.logged, track.values, zero):
        notes.append(_idle_note(track, zero, topic))
        track = track.select(~zero)
    for k in range(track.values.shape[1]):
        zero = track.values[:, k] == 0.0
        if _is_second(track.logged, track.values[:, k : k + 1], zero):
            values = track.values.copy()
            values[zero, k] = np.nan
            track = replace(track, values=values)
            count = np.count_nonzero(zero)
            notes.append(f"{topic}: {count} zeros between other numbers were left out: a second publisher sends them")
    return track


def _is_second(logged: Integers, values: Array, zero: Mask) -> bool:
    """Whether zeros are a second publisher's: they lie in a regular signal that is far from zero before and behind.

    Args:
        logged: Log time of each sample, ns, (n,).
        values: Its numbers, (n, m).
        zero: Which samples are zeros, (n,).
    """
    count = np.count_nonzero(zero)
    if count < _MIN_ZEROS or count > len(zero) - _MIN_ZEROS:
        return False
    known = ~np.isnan(values).all(axis=1) & ~zero
    if np.count_nonzero(known) < _MIN_ZEROS:
        return False
    order = time_order(logged)
    live = np.flatnonzero(known) if order is None else order[known[order]]
    time = logged[live]
    gaps = np.diff(time)
    usual = float(np.median(gaps))
    # A coarse number that alternates with zero does so irregularly.
    if np.mean((gaps >= _REGULAR * usual) & (gaps <= _UNINTERRUPTED * usual)) < _MIN_BETWEEN:
        return False
    after = np.searchsorted(time, logged[zero], side="right")
    inside = (after > 0) & (after < len(time))
    after = np.clip(after, 1, len(time) - 1)
    undisturbed = gaps[after - 1] <= _UNINTERRUPTED * usual
    low, high = values[live[after - 1]], values[live[after]]
    with np.errstate(invalid="ignore"):
        away = (np.minimum(np.abs(low), np.abs(high)) > _AWAY * np.abs(high - low)).any(axis=1)
    between = np.count_nonzero(inside & undisturbed & away)
    return bool(between >= max(_MIN_ZEROS, _MIN_BETWEEN * np.count_nonzero(inside)))
