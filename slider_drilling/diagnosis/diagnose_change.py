"""Diagnose what is different between earlier and later logs of one rig."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.diagnosis.baseline import Baseline, candidates_for_change, fit_baseline, shared_nuisance
from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.catalogue import check_names
from slider_drilling.diagnosis.change import Change, HeldShare
from slider_drilling.diagnosis.change_answer import ChangeAnswer, answer_from
from slider_drilling.diagnosis.change_date import rise_of_change
from slider_drilling.diagnosis.change_result import change_diagnosis
from slider_drilling.diagnosis.change_search import ChangeSearch, search_change
from slider_drilling.diagnosis.changed_string import ChangedString, compared_around
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.onset import Onset, Since
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.diagnosis.rig_source import find_rig_source, rig_remarks
from slider_drilling.diagnosis.share_rise import ChangeDate, Rise
from slider_drilling.diagnosis.undisturbed import from_calm_start, is_calm, without_operations
from slider_drilling.errors import InputError
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.results.intervals import TWO_SIDED_95
from slider_drilling.log import RigLog
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.log_checks import LogChecks, check_log
from slider_drilling.rig import Rig
from slider_drilling.units import Text

MIN_BEFORE_S, MIN_AFTER_S = 60.0, 30.0
"""Shortest log before and after a change that can be compared."""
_NO_RISE = "the samples since the change hold no more of it than those before"


def diagnose_change(
    before: Sequence[RigLog] | Baseline,
    after: Sequence[RigLog],
    rig: Rig,
    *,
    since: Since | None = None,
    only: Sequence[str] = (),
    seed: int = 0,
    progress: Progress = lambda stage, share: None,
    whole: tuple[bool, bool] = (True, True),
    onset: Onset | None = None,
) -> Diagnosis:
    """Diagnose what is different in later logs.

    The rig's calibrated numbers, effects that it always had, and what no model explains are those of the earlier logs.

    Args:
        before: Earlier logs, or what `fit_baseline` made of them.
        after: Later logs. Each begins where the change does, or later, but for an onset; then it is one.
        rig: The rig file.
        since: When the change began, for the answer.
        only: Names of the changes to consider; all if empty.
        seed: Of the bootstrap.
        progress: Called with the stage and the share done.
        whole: Whether the earlier and the later logs begin as runs do, see `check_log`.
        onset: When the change begins in the later log: what is before it shows the state in which the change finds the
            string. An operation between the two hides that; the log from the change on is then taken alone. Where
            change detection found it, a change that is named is dated by its size over the whole log.

    Raises:
        InputError: A log is unusable, or too short.
    """
    started = clock.perf_counter()
    long_enough(after, MIN_AFTER_S)  # before the baseline, which takes long
    progress("calibrating the baseline", 0.05)
    baseline = before
    if not isinstance(baseline, Baseline):
        baseline = fit_baseline(long_enough(baseline, MIN_BEFORE_S), rig, whole[0])
    given = since or Since(None)
    part = _compared_part(after, rig, onset)
    calm = [from_calm_start(log, rig) for log in long_enough(part.logs, MIN_AFTER_S)]
    begin = 0.0 if len(after) > 1 else given.log_start + (calm[0].start_ns - after[0].start_ns) / 1e9
    if begin > 0.0:  # times of its checks and remarks count from there
        calm = [replace(calm[0], source=f"{calm[0].source}, from {begin:.0f} s on")]
    progress("searching what has changed", 0.5)
    later = _later_string(calm, rig, baseline, whole[1] and part.begin == 0.0)
    model = _changed_string(compared_around(later.string, part.onset), baseline, only, part.onset)
    if not any(run.channels for run in model.runs):
        raise InputError(
            f"{after[0].source}: shares no channel with the baseline, which holds {', '.join(baseline.noise)}"
        )
    search = replace(search_change(model, baseline), seen_in=given.channel)
    progress("dating the change", 0.95)
    answer, rise = _answer_that_rises(search, baseline, seed, after[0], rig, onset if given.found else None)
    remarks = (*rig_remarks(find_rig_source(after, rig), [own.log for own in later.checks], rig), *later.remarks)
    diagnosis = change_diagnosis(after, rig, later.checks, search, answer, baseline, remarks)
    change = _change(answer, baseline, given, rise, begin)
    traces = tuple(replace(trace, time=trace.time + begin) for trace in diagnosis.traces)
    return replace(diagnosis, change=change, traces=traces, runtime=clock.perf_counter() - started)


@dataclass(frozen=True)
class _Part:
    """What is compared of later logs.

    Attributes:
        logs: The logs, or the part of one.
        begin: s of the log, where that part begins.
        onset: When the change begins in it; None at its start.
    """

    logs: Sequence[RigLog]
    begin: float = 0.0
    onset: Onset | None = None


@dataclass(frozen=True)
class _LaterString:
    """The model of later logs alone, with the checks and remarks that it came with."""

    string: DrillString
    checks: tuple[LogChecks, ...]
    remarks: tuple[Text, ...]


def _compared_part(after: Sequence[RigLog], rig: Rig, onset: Onset | None) -> _Part:
    """The part of a later log in which the string is simulated up to the change, or from it on."""
    if onset is None:
        return _Part(after)
    (log,) = after
    begin = onset.simulated_from
    if begin < onset.changed_from and not is_calm(log, rig, begin, onset.changed_from):
        begin = onset.changed_from
    part = [cut_time_window(log, begin, log.end)]
    return _Part(part, begin, onset.relative_to(begin) if begin < onset.changed_from else None)


def _later_string(logs: Sequence[RigLog], rig: Rig, baseline: Baseline, whole: bool) -> _LaterString:
    """The model of later logs, with the baseline's channels. Raises InputError where a log is unusable."""
    checks = tuple(check_log(log, rig, whole) for log in logs)
    for checked in checks:
        checked.raise_if_unusable()
    prepared = build_model([checked.log for checked in checks], rig)
    string = without_operations(prepared.model.with_channels(tuple(baseline.noise)))
    return _LaterString(string, checks, tuple(prepared.remarks))


def _answer_that_rises(
    search: ChangeSearch, baseline: Baseline, seed: int, log: RigLog, rig: Rig, onset: Onset | None
) -> tuple[ChangeAnswer, Rise | None]:
    """The answer, and how the change that it names rises over the later log; None without a name or an onset."""
    answer = answer_from(search, baseline, seed)
    if answer.named is None or onset is None:
        return answer, None
    calm = from_calm_start(log, rig)
    begin = 1e-9 * (calm.start_ns - log.start_ns)
    string = _later_string([calm], rig, baseline, whole=False).string
    not_rising: dict[str, str] = {}
    while answer.named is not None:
        rise = rise_of_change(string, baseline, answer.named, onset.relative_to(begin))
        if rise is None:
            return answer, None
        if rise.shows:
            return answer, rise.shifted(begin)
        not_rising[answer.named.effect.name] = _NO_RISE
        answer = answer_from(search, baseline, seed, not_rising)
    return answer, None


def long_enough(logs: Sequence[RigLog], least: float) -> Sequence[RigLog]:
    """The logs. Raises InputError where one has less than so many s of top-drive motion."""
    for log in logs:
        series = log.top_drive
        length = 0.0 if series is None or not series.time.size else float(series.time[-1] - series.time[0])
        if length < least:
            held = f"{length:.0f} s of top-drive motion" if length else "no top-drive motion"
            raise InputError(f"{log.source}: {held}: at least {least:.0f} s are needed here")
    return logs


def _changed_string(
    string: DrillString, baseline: Baseline, only: Sequence[str], onset: Onset | None
) -> ChangedString:
    """The model of the later logs. Raises InputError for a name that is no candidate."""
    candidates = candidates_for_change(string.effects, baseline.standing, baseline.values)
    check_names(only, [effect.name for effect in candidates], "a change")
    candidates = tuple(effect for effect in candidates if not only or effect.name in only)
    return ChangedString(string, baseline.values, shared_nuisance(string.nuisance, baseline), candidates, onset=onset)


def _change(answer: ChangeAnswer, baseline: Baseline, since: Since, rise: Rise | None, begin: float) -> Change:
    """What the answer says of the change; the compared part begins so many s into the log that the user gave."""
    dated, gradual = _dated(rise, since), None
    if rise is not None and dated is not None:
        gradual = rise.gradual
        since = replace(since, time=dated.since, interval=dated.interval)
    return Change(
        baseline.sources, begin, since.time, since.interval, since.found, dated is not None, gradual,
        _held(rise, since), None if answer.named is None else answer.named.growing, answer.moved, answer.explained,
        answer.interval, baseline.gap, answer.gaps[0], tuple(effect.name for effect in baseline.standing),
        baseline.values,
    )  # fmt: skip


def _held(rise: Rise | None, since: Since) -> HeldShare | None:
    """How much of the named change the samples hold; s of the user's log."""
    if rise is None:
        return None
    shown = rise.shown
    half = TWO_SIDED_95 * np.sqrt(shown.variance)
    interval = np.stack([shown.share - half, shown.share + half], axis=1)
    return HeldShare(shown.time + since.log_start, shown.share, interval)


def _dated(rise: Rise | None, since: Since) -> ChangeDate | None:
    """When the named change began, where its rise says more of that than detection; s of the user's log."""
    if rise is None or rise.date is None:
        return None
    dated = rise.date.shifted(since.log_start)
    return dated if dated.says_more_than(since.interval) else None
