"""What a twin asks after a detection, in a process of its own: what is different now?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from slider_drilling.diagnosis.onset import Onset, Since
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig

if TYPE_CHECKING:
    from slider_drilling.diagnosis.baseline import Baseline

MIN_BASELINE_S = 150.0
"""Shortest time before a change from which it can be named: less does not show what the rig was like."""

ASKED_AFTER_S = (20.0, 60.0, 110.0, 160.0, 300.0, 460.0)
"""s after a detection at which it is asked; each answer replaces the one before."""

_BEFORE_S = 600.0  # of samples from before a change
# s before the earliest time at which it can have begun; and share of the time since then until it was seen: what is
# seen late grew slowly, and may have begun earlier than it looks.
_MARGIN_S, _MARGIN_SHARE = 10.0, 0.4
_LEAST_BEFORE_S = 300.0  # of samples, that the share leaves where the change began later
_MIN_AFTER_S = 40.0
_LONGEST_AFTER_S = 600.0  # of samples since a change whose time is not well known


@dataclass(frozen=True)
class Answer:
    """What a diagnosis of a change says.

    Attributes:
        tree: The content of diagnosis.json: verdict, site, effects, suspected and the rest.
        baseline: What the earlier samples say; it can be given in their place when the same is asked again.
    """

    tree: dict[str, Any]
    baseline: Baseline | None = None


class Ask(Protocol):
    """A question that is asked in another process; it must be picklable, as a function of a module is."""

    def __call__(
        self, before: RigLog | Baseline, after: RigLog, rig: Rig, since: Since | None, onset: Onset | None
    ) -> Answer:
        """Diagnose a change.

        Args:
            before: Samples from before the change, or the baseline of an earlier answer.
            after: Samples since, and some from before it where it was detected.
            rig: The rig file as given.
            since: What was detected; None if nothing was.
            onset: When that began in ``after``; None if nothing was detected.

        Raises:
            InputError: These samples cannot be diagnosed.
        """
        ...


@dataclass(frozen=True)
class Windows:
    """What is compared for a change. What lies between the two ends of its interval belongs to neither.

    Attributes:
        before: s, start and end of the samples from before it.
        after: s, start and end of those since.
    """

    before: tuple[float, float]
    after: tuple[float, float]

    def onset_from(self, begins: float) -> Onset:
        """When the change began in later samples whose own time is 0 at a time, s: those from before it date it."""
        return Onset(self.before[1], self.after[0]).relative_to(begins)

    @property
    def shortage(self) -> str:
        """Why this cannot be diagnosed yet; empty if it can."""
        (begin, end), (first, now) = self.before, self.after
        before, after = end - begin, now - first
        if before < MIN_BASELINE_S:
            return f"it needs {MIN_BASELINE_S:.0f} s of samples before the change, and has {max(before, 0.0):.0f} s"
        if after < _MIN_AFTER_S:
            return f"it needs {_MIN_AFTER_S:.0f} s of samples since the change, and has {max(after, 0.0):.0f} s"
        return ""


def windows_of_change(
    interval: tuple[float, float], seen: float, started: float, now: float, began: float = math.inf
) -> Windows:
    """What to compare.

    Args:
        interval: s, within which the change began.
        seen: s, when it was seen.
        started: s, of the first samples.
        now: s.
        began: s, before which samples end in any case that leaves five minutes of them.
    """
    low, high = interval
    end = min(low - max(_MARGIN_S, _MARGIN_SHARE * (seen - low)), began - _MARGIN_S)
    end = max(end, min(low - _MARGIN_S, started + _LEAST_BEFORE_S))
    first = max(min(high, now - _MIN_AFTER_S), low)
    if not Onset(end, first).known:
        first = max(first, now - _LONGEST_AFTER_S)
    return Windows((max(end - _BEFORE_S, started), end), (first, now))


def diagnose_after(
    before: RigLog | Baseline, after: RigLog, rig: Rig, since: Since | None, onset: Onset | None
) -> Answer:
    """What is different since the change, with what was before as the baseline; see `Ask`."""
    from slider_drilling.diagnosis.baseline import fit_baseline
    from slider_drilling.diagnosis.diagnose_change import diagnose_change, long_enough
    from slider_drilling.diagnosis.to_json import to_json

    baseline = before
    if isinstance(baseline, RigLog):
        baseline = fit_baseline(long_enough([baseline], MIN_BASELINE_S), rig, whole=False)
    diagnosis = diagnose_change(baseline, [after], rig, since=since, whole=(False, False), onset=onset)
    return Answer(to_json(diagnosis), baseline)
