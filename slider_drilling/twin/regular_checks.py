"""Regular checks: without a detection the twin asks now and then whether the rig still is as it was.

A diagnosis compares all channels at once with what every simulated change would do to them. So it finds changes that
are small in each feature by itself. Nothing else speaks for a change then, so it has to be plain: calibrated numbers
that wander leave a channel unlike before, the change closes half of what they leave, and two checks in a row name it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from slider_drilling.twin.ask import Windows
from slider_drilling.twin.background import PickledBaseline, Reply
from slider_drilling.twin.channels import SURFACE

RECENT_S = 300.0
"""s of samples that a check compares with the rig as it was."""
_SETTLING_S = 60.0  # after the twin began to follow, before the rig shows how it is
_BASELINE_S, _APART_S = 640.0, 20.0  # of samples that show the rig as it was; between them and the recent ones
_TRIED = 2  # checks in a row without an answer, after which later samples show the rig as it was
_CLOSED = 0.5  # share of the squared gap after calibration that a change closes, at least
_RENEWED_S = 1800.0  # after which the rig as it was is that of later samples: a rig wanders


@dataclass(frozen=True)
class ConfirmedChange:
    """A change that two checks in a row name.

    Attributes:
        answers: Of both, as diagnosis.json has them.
        interval: s, within which it began.
        channel: That it explains best.
        kind: ``step`` or ``ramp``.
        size: RMS of what it explains there, in noise levels.
    """

    answers: tuple[dict[str, Any], dict[str, Any]]
    interval: tuple[float, float]
    channel: str
    kind: str
    size: float


class RegularChecks:
    """When the twin checks, and what it makes of the answers.

    Args:
        every: s between two checks; 0 for none.

    Attributes:
        baseline: The rig as it was, once a check has fitted it.
    """

    def __init__(self, every: float) -> None:
        self._every = every
        self.begin(math.inf)

    def follow_from(self, time: float) -> None:
        """The twin follows the rig since a time, s: it is as it was a minute later."""
        self.begin(time + _SETTLING_S)

    def begin(self, start: float) -> None:
        """Forget the rig as it was: from now on it is that of the samples from `start` on, s."""
        self.baseline: PickledBaseline | None = None
        self._failed = 0  # checks in a row without an answer
        self._start, self._next = start, start + _BASELINE_S + _APART_S + RECENT_S
        self._named: tuple[dict[str, Any], float] | None = None  # the last check, if it names a change; s
        self._unnamed_at = start + _BASELINE_S + RECENT_S  # s, of the last check that names none

    def due(self, now: float) -> Windows | None:
        """What to compare at a time, s; None if no check is due."""
        if self._every == 0.0 or now < self._next:
            return None
        if now - self._start > _RENEWED_S + _BASELINE_S and self._named is None:
            self.begin(now - RECENT_S - _APART_S - _BASELINE_S)
        self._next = now + self._every
        return Windows((self._start, self._start + _BASELINE_S), (now - RECENT_S, now))

    def take(self, reply: Reply, asked: float) -> ConfirmedChange | None:
        """Take the reply to the check that was asked at a time, s; the change that it confirms, if any."""
        if reply.tree is None:
            self._failed += 1
            if self.baseline is None and self._failed >= _TRIED:
                self.begin(self._start + self._every)
            return None
        self.baseline, self._failed = reply.baseline or self.baseline, 0
        if not reply.tree["effects"] or not is_plain(reply.tree["gap"]):
            self._named, self._unnamed_at = None, asked
            return None
        before, self._named = self._named, (reply.tree, asked)
        if before is None or not set(before[0]["effects"]) & set(reply.tree["effects"]):
            return None
        tree, first = before
        channel, size = _best_explained(reply.tree["gap"])
        kind = "ramp" if reply.tree["change"]["growing"] else "step"
        return ConfirmedChange((tree, reply.tree), (self._unnamed_at - RECENT_S, first), channel, kind, size)


def is_plain(gap: Mapping[str, Any]) -> bool:
    """Whether calibrated numbers that wander leave a channel unlike before, and the named change closes half of it.

    Args:
        gap: Of diagnosis.json, of an answer that names a change.
    """
    left = max(errors["tuned"] / gap["noise_floor"][name]["value"] for name, errors in _at_surface(gap))
    tuned, closed = gap["tuned"] ** 2 - 1.0, gap["tuned"] ** 2 - gap["with_effect"] ** 2
    return bool(left > gap["threshold"] and tuned > 0.0 and closed >= _CLOSED * tuned)


def _at_surface(gap: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    return [(name, gap["rms"][name]) for name in SURFACE if name in gap["rms"]]


def _best_explained(gap: Mapping[str, Any]) -> tuple[str, float]:
    """Channel at surface whose error the named change lowers most beside calibration; and by how much (RMS), in noise
    levels."""
    lowered = {}
    for name, errors in _at_surface(gap):
        square = errors["tuned"] ** 2 - errors["with_effect"] ** 2
        lowered[name] = math.sqrt(max(square, 0.0)) / gap["noise_floor"][name]["value"]
    best = max(lowered, key=lambda name: lowered[name])
    return best, lowered[best]
