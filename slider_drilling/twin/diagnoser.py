"""When the twin asks for a diagnosis, and what it does with the answer."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.twin.agreement import DiagnosesOfChange
from slider_drilling.twin.ask import Ask, Windows, windows_of_change
from slider_drilling.twin.background import BackgroundDiagnosis, PickledBaseline, Question, Reply
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.recorded_log import recorded_log
from slider_drilling.twin.report import Detection
from slider_drilling.twin.samples import SampleBuffer

ASKED_AFTER_S = (20.0, 60.0, 110.0, 160.0, 300.0, 460.0)  # after a detection; each answer replaces the one before
_RECENT_S = 300.0  # that are compared with what was before, where nothing was detected


class Diagnoser:
    """Asks in the background.

    Args:
        ask: The question; None for no diagnosis.
        rig: The rig file.
        buffers: Samples by channel.
        log: The detections.
        replayed: The samples are of the past: a reply is waited for, and held until the time at which it would have
            come beside the rig. How busy this machine is then changes nothing.

    Attributes:
        answer: The latest, as JSON; None before the first.
        answered: s, when it came; None before.
        error: Why the last question has no answer; None if it has one.
    """

    def __init__(
        self, ask: Ask | None, rig: Rig, buffers: Mapping[str, SampleBuffer], log: DetectionLog, replayed: bool = False
    ) -> None:
        self._replayed = replayed
        self._ask, self._rig, self._buffers, self._log = ask, rig, buffers, log
        self._background: BackgroundDiagnosis | None = None
        self._asked_for: int | None = None
        self._asked_at = 0.0  # s
        self._held: Reply | None = None  # of a replay, until the time at which it would have come
        self._baseline: tuple[PickledBaseline | None, int | None, float] = (None, None, 0.0)  # of a detection, until s
        self._due: list[tuple[float, int]] = []
        self._diagnosed: defaultdict[int, DiagnosesOfChange] = defaultdict(DiagnosesOfChange)  # by detection
        self.answer: dict[str, Any] | None = None
        self.answered: float | None = None
        self.error: str | None = None

    @property
    def asking(self) -> bool:
        """Whether a question is open."""
        return self._held is not None or (self._background is not None and self._background.running)

    def detected(self, detection: Detection) -> None:
        """Plan the questions about a new detection."""
        self._due += [(detection.detected + after, detection.number) for after in ASKED_AFTER_S]

    def update(self, now: float) -> None:
        """Take an answer that has come, and ask what is due; waits in a replay only."""
        if self._held is not None and self._held.comes_at(self._asked_at) <= now:
            self._take(self._held, now)
        elif self._held is None and self._background is not None:
            reply = self._background.poll()
            if reply is not None:
                self._take(reply, now)
        if not self.asking:
            due = [entry for entry in self._due if entry[0] <= now]
            if due:
                # Only the latest question of the latest detection still matters.
                self._due = [entry for entry in self._due if entry[0] > now]
                self._start(self._log.detections[max(number for _, number in due) - 1], now)

    def ask_now(self, now: float) -> None:
        """Ask about the last detection, or without one about everything recorded.

        Raises:
            InputError: That is not possible; the message says why.
        """
        if self._ask is None:
            raise InputError("twin: diagnoses are switched off")
        if self.asking:
            raise InputError("twin: a diagnosis is under way; wait for its answer")
        last = self._log.detections[-1] if self._log.detections else None
        shortage = self._windows(last, now).shortage(now)
        if shortage:
            raise InputError(f"twin: too early for a diagnosis: {shortage}; ask later")
        self._start(last, now)

    def take_held_reply(self) -> None:
        """Take the reply that comes after the end of a replay."""
        if self._held is not None:
            self._take(self._held, self._held.comes_at(self._asked_at))

    def close(self) -> None:
        """End what is still being asked."""
        if self._background is not None:
            self._background.close()

    def _start(self, detection: Detection | None, now: float) -> None:
        if self._ask is None:
            return
        self._background = self._background or BackgroundDiagnosis()
        windows = self._windows(detection, now)
        number = None if detection is None else detection.number
        baseline, known_for, end = self._baseline
        if baseline is None or known_for != number or end > windows.before[1]:
            baseline, end = None, windows.before[1]
        before = baseline or recorded_log(self._buffers, self._rig, *windows.before)
        after = recorded_log(self._buffers, self._rig, windows.after, now)
        self._asked_for, self._asked_at, self._baseline = number, now, (baseline, number, end)
        channel = None if detection is None else detection.channel
        if not self._replayed:
            self._background.start(Question(self._ask, before, after, self._rig, channel))
            return
        self._background.start(Question(self._ask, before, after, self._rig, channel, nice=0))
        self._held = self._background.wait()

    def _windows(self, detection: Detection | None, now: float) -> Windows:
        """What to compare for a detection; without one, the recent past with what was before."""
        times = self._buffers["top_drive_angle"].time
        started = float(times[0]) if times.size else now
        middle = now - min(_RECENT_S, 0.5 * (now - started))
        interval, seen = ((middle, middle), middle) if detection is None else (detection.interval, detection.detected)
        return windows_of_change(interval, seen, started, now)

    def _take(self, reply: Reply, now: float) -> None:
        self._held, self.error = None, reply.error
        if reply.tree is None:
            return
        answer = reply.tree
        self._baseline = (reply.baseline, *self._baseline[1:])
        self.answer, self.answered = answer, now
        if self._asked_for is None:
            return
        detection = self._log.detections[self._asked_for - 1]
        change = self._diagnosed[self._asked_for].take(answer)
        self._log.change(replace(
            detection, effects=change.effects, suspected=change.suspected, verdict=change.verdict, answered=now,
            site=change.site or detection.site,
        ))  # fmt: skip
