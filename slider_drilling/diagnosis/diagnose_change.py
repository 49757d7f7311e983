"""Diagnose what is different between earlier and later logs of one rig."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace

from slider_drilling.diagnosis.baseline import Baseline, candidates_for_change, fit_baseline, shared_nuisance
from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.catalogue import check_names
from slider_drilling.diagnosis.change import Change
from slider_drilling.diagnosis.change_answer import ChangeAnswer, answer_from
from slider_drilling.diagnosis.change_result import change_diagnosis
from slider_drilling.diagnosis.change_search import search_change
from slider_drilling.diagnosis.changed_string import ChangedString, compared_around
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.onset import Onset
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.diagnosis.rig_source import find_rig_source, rig_remarks
from slider_drilling.diagnosis.undisturbed import from_calm_start, is_calm, without_operations
from slider_drilling.errors import InputError
from slider_drilling.gap.progress import Progress
from slider_drilling.log import RigLog
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.log_checks import check_log
from slider_drilling.rig import Rig

MIN_BEFORE_S, MIN_AFTER_S = 60.0, 30.0
"""Shortest log before and after a change that can be compared."""


@dataclass(frozen=True)
class Since:
    """When a change began.

    Attributes:
        time: s of the log that the user gave.
        interval: 95 % interval, None if unknown.
        found: Whether change detection found it.
        log_start: s of that log, at which the later log begins.
        channel: In which it was seen, None if unknown.
    """

    time: float
    interval: tuple[float, float] | None = None
    found: bool = False
    log_start: float = 0.0
    channel: str | None = None


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
        after: Later logs. Each begins where the change does, or later, but for an onset.
        rig: The rig file.
        since: When the change began, for the answer.
        only: Names of the changes to consider; all if empty.
        seed: Of the bootstrap.
        progress: Called with the stage and the share done.
        whole: Whether the earlier and the later logs begin as runs do, see `check_log`.
        onset: When the change begins in the later log: what is before it shows the state in which the change finds the
            string. An operation between the two hides that; the log from the change on is then taken alone.

    Raises:
        InputError: A log is unusable, or too short.
    """
    started = clock.perf_counter()
    progress("calibrating the baseline", 0.05)
    baseline = before
    if not isinstance(baseline, Baseline):
        baseline = fit_baseline(long_enough(baseline, MIN_BEFORE_S), rig, whole[0])
    given = Since(0.0) if since is None else since
    if onset is not None and not is_calm(after[0], rig, onset.changed_from):
        given = replace(given, log_start=given.log_start + onset.changed_from)
        after, onset = [cut_time_window(log, onset.changed_from, log.end) for log in after], None
    calm = [from_calm_start(log, rig) for log in long_enough(after, MIN_AFTER_S)]
    checks = tuple(check_log(log, rig, whole[1]) for log in calm)
    for checked in checks:
        checked.raise_if_unusable()
    progress("searching what has changed", 0.5)
    prepared = build_model([checked.log for checked in checks], rig)
    string = without_operations(prepared.model.with_channels(tuple(baseline.noise)))
    model = _changed_string(compared_around(string, onset), baseline, only, onset)
    if not any(run.channels for run in model.runs):
        raise InputError(
            f"{after[0].source}: shares no channel with the baseline, which holds {', '.join(baseline.noise)}"
        )
    search = replace(search_change(model, baseline), seen_in=given.channel)
    answer = answer_from(search, baseline, seed)
    remarks = (*rig_remarks(find_rig_source(after, rig), [own.log for own in checks], rig), *prepared.remarks)
    diagnosis = change_diagnosis(after, rig, checks, search, answer, baseline, remarks)
    return replace(
        diagnosis, change=_change(answer, baseline, given, since is not None), runtime=clock.perf_counter() - started
    )


def long_enough(logs: Sequence[RigLog], least: float) -> Sequence[RigLog]:
    """The logs. Raises InputError where one has less than so many s of top-drive motion."""
    for log in logs:
        series = log.top_drive
        length = 0.0 if series is None or not series.time.size else float(series.time[-1] - series.time[0])
        if length < least:
            raise InputError(
                f"{log.source}: {length:.0f} s of top-drive motion: at least {least:.0f} s are needed here"
            )
    return logs


def _changed_string(
    string: DrillString, baseline: Baseline, only: Sequence[str], onset: Onset | None
) -> ChangedString:
    """The model of the later logs. Raises InputError for a name that is no candidate."""
    candidates = candidates_for_change(string.effects, baseline.standing, baseline.values)
    check_names(only, [effect.name for effect in candidates], "a change")
    candidates = tuple(effect for effect in candidates if not only or effect.name in only)
    return ChangedString(string, baseline.values, shared_nuisance(string.nuisance, baseline), candidates, onset=onset)


def _change(answer: ChangeAnswer, baseline: Baseline, since: Since, known: bool) -> Change:
    return Change(
        baseline.sources, since.log_start, since.time if known else None, since.interval, since.found,
        None if answer.named is None else answer.named.growing, answer.moved, answer.explained, answer.interval,
        baseline.gap, answer.gaps[0], tuple(effect.name for effect in baseline.standing), baseline.values,
    )  # fmt: skip
