"""What has changed: between two logs, or within one from a time on."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from slider_drilling.diagnosis.catalogue import check_names
from slider_drilling.diagnosis.diagnose_change import MIN_AFTER_S, MIN_BEFORE_S, diagnose_change
from slider_drilling.diagnosis.onset import Since
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.diagnosis.rig_changes import RIG_CHANGES
from slider_drilling.effects import EFFECTS
from slider_drilling.errors import InputError
from slider_drilling.gap.progress import Progress
from slider_drilling.log import RigLog
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.rig import Rig

if TYPE_CHECKING:
    from slider_drilling.twin import Detection
    from slider_drilling.twin.ask import Ask, Windows


@dataclass(frozen=True)
class ChangeRequest:
    """What is asked.

    Attributes:
        logs: Later logs, or the one log that is split.
        baseline: Earlier logs; empty where one log is split.
        since: s from the log's start; ``"auto"`` to find it; None with a baseline.
        only: Names of the changes to consider; all if empty.
        seed: Of the bootstrap.
    """

    logs: tuple[RigLog, ...]
    baseline: tuple[RigLog, ...]
    since: float | Literal["auto"] | None
    only: tuple[str, ...] = ()
    seed: int = 0

    def check(self, until: float, with_user_effects: bool, with_after: bool) -> None:
        """Refuse what does not go together, and names that no change has.

        Raises:
            InputError: Naming the options.
        """
        if self.since is not None and self.baseline:
            raise InputError("since and baseline: give one of them: since splits one log, baseline is another")
        if self.since is not None and len(self.logs) > 1:
            raise InputError(f"since {self.since}: splits one log; {len(self.logs)} are given")
        if until != 1.0:
            raise InputError(f"until {until:g}: not with baseline or since, which fit the whole later log")
        if with_after:
            raise InputError("after: not with baseline or since, whose baseline is calibrated anew")
        if with_user_effects:
            raise InputError("effects: not with baseline or since: only the catalogue and changes of the rig there")
        check_names(self.only, (*EFFECTS, *RIG_CHANGES), "a change")


def parse_since(text: str | None) -> float | Literal["auto"] | None:
    """The value of ``--since``. Raises InputError for what is neither a time in s nor ``auto``."""
    if text is None or text == "auto":
        return text  # type: ignore[return-value]
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"--since {text}: must be a time in s from the log's start, or auto")
    return value


def find_since(log: RigLog, rig: Rig, progress: Progress) -> tuple[Since, Windows]:
    """When a change began, by a twin that follows the whole log; and what to compare for it.

    It asks its regular checks, which take longer, only where nothing else shows a change. Samples count as far as the
    twin's last question about a change reaches: later the rig may have become another one once more.

    Raises:
        InputError: It detects no change, or could detect none.
    """
    from slider_drilling.twin import diagnose_after
    from slider_drilling.twin.ask import ASKED_AFTER_S, windows_of_change

    first, not_compared = _first_change(log, rig, None, lambda done: progress("looking for a change", 0.1 * done))
    seen_in = None if first is None else first.channel  # of what checks find, none
    if first is None and not not_compared:
        first, _ = _first_change(
            log, rig, diagnose_after, lambda done: progress("looking for a change, by checks", 0.1 + 0.4 * done)
        )
    if first is not None:
        until = min(first.detected + ASKED_AFTER_S[-1], log.end)
        windows = windows_of_change(first.interval, first.detected, 0.0, until)
        return Since(first.since, first.interval, True, windows.before[0], seen_in), windows
    advice = f"{not_compared}, or" if not_compared else "no change detected; give"
    raise InputError(f"since auto: {log.source}: {advice} the time from which on to compare")


def _first_change(
    log: RigLog, rig: Rig, ask: Ask | None, progress: Callable[[float], None]
) -> tuple[Detection | None, str]:
    """The first change that a twin detects, if any, and why none could show."""
    from slider_drilling.twin import Twin
    from slider_drilling.twin.feed import LogFeed
    from slider_drilling.twin.watch import reports_of

    with contextlib.closing(Twin(rig, ask=ask, replayed=True)) as twin:
        for report in reports_of(twin, LogFeed(log)):
            progress(min(report.time / log.end, 1.0))
            if ask is not None and twin.detections:
                break  # what is asked about it now, would be asked again with the whole log
        return next(iter(twin.detections), None), twin.not_compared


def diagnose_what_changed(request: ChangeRequest, rig: Rig, progress: Progress) -> Diagnosis:
    """Diagnose a change.

    Args:
        request: What is asked.
        rig: The rig file.
        progress: Called with the stage and the share done.

    Raises:
        InputError: A log is unusable or too short, or a name is unknown.
    """
    if request.since is None:
        return diagnose_change(
            request.baseline, request.logs, rig, only=request.only, seed=request.seed, progress=progress
        )
    log = request.logs[0]
    if request.since == "auto":
        since, windows = find_since(log, rig, progress)
    else:
        windows = windows_at(log, request.since)
        since = Since(request.since, log_start=windows.before[0])
    begin = windows.before[0]
    before, after = cut_time_window(log, *windows.before), cut_time_window(log, begin, windows.after[1])
    whole = begin == 0.0
    return diagnose_change(
        [before], [after], rig, since=since, only=request.only, seed=request.seed, progress=progress,
        whole=(whole, whole), onset=windows.onset_from(begin),
    )  # fmt: skip


def windows_at(log: RigLog, since: float) -> Windows:
    """What to compare where a user says when the change began, s. Raises InputError where that leaves too little."""
    from slider_drilling.twin.ask import Windows

    if not MIN_BEFORE_S <= since <= log.end - MIN_AFTER_S:
        raise InputError(
            f"since {since:g}: {log.source} holds {log.end:.0f} s: give a time that leaves at least "
            f"{MIN_BEFORE_S:.0f} s before it and {MIN_AFTER_S:.0f} s after it"
        )
    return Windows((0.0, since), (since, log.end))
