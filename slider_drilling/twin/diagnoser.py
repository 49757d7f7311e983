"""When the twin asks for a diagnosis, and what it does with the answer."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from slider_drilling.diagnosis.onset import Onset, Since
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.twin.agreement import DiagnosedChange, DiagnosesOfChange
from slider_drilling.twin.ask import ASKED_AFTER_S, Ask, Windows, windows_of_change
from slider_drilling.twin.background import BackgroundDiagnosis, PickledBaseline, Question, Reply
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.detections import DetectionLog
from slider_drilling.twin.recorded_log import recorded_log
from slider_drilling.twin.regular_checks import RECENT_S, ConfirmedChange, RegularChecks
from slider_drilling.twin.report import Detection
from slider_drilling.twin.samples import SampleBuffer


@dataclass(frozen=True)
class AnsweredQuestion:
    """A question and what came of it.

    Attributes:
        number: Of the detection that it was about, or that it made as a regular check; None without one.
        answered: s, when the answer came.
        change: What the diagnoses of that detection say with this one; None without an answer.
        error: Why there is no answer, in one line; None if there is one.
        cpu: s of processor time that it took.
        peak: bytes, the most memory that its process held.
    """

    number: int | None
    answered: float
    change: DiagnosedChange | None
    error: str | None
    cpu: float
    peak: int


@dataclass(frozen=True)
class _Open:
    """The question that is open.

    Attributes:
        asked: s.
        number: Of the detection that it is about, None if about none.
        regular: Whether it is a regular check.
    """

    asked: float
    number: int | None
    regular: bool = False


class Diagnoser:
    """Asks in the background.

    Args:
        ask: The question; None for no diagnosis.
        rig: The rig file.
        buffers: Samples by channel.
        log: The detections.
        replayed: The samples are of the past: a reply is waited for, and held until the time at which it would have
            come beside the rig. How busy this machine is then changes nothing.
        check_every: s between two regular checks; 0 for none.
        dated: What features show of a change that began between two times, s; None where they show nothing.
        told: Called with every question that is answered.

    Attributes:
        answer: The latest, as JSON; None before the first. A regular check counts once the next one confirms it.
        answered: s, when it came; None before.
        error: Why the last question has no answer; None if it has one.
        checks: The regular checks.
    """

    def __init__(
        self, ask: Ask | None, rig: Rig, buffers: Mapping[str, SampleBuffer], log: DetectionLog, replayed: bool = False,
        check_every: float = 0.0, dated: Callable[[float, float], FeatureChange | None] = lambda low, high: None,
        told: Callable[[AnsweredQuestion], None] = lambda question: None,
    ) -> None:  # fmt: skip
        self._replayed, self._dated, self._told = replayed, dated, told
        self._ask, self._rig, self._buffers, self._log = ask, rig, buffers, log
        self.checks = RegularChecks(check_every)
        self._background: BackgroundDiagnosis | None = None
        self._open: _Open | None = None
        self._held: Reply | None = None  # of a replay, until the time at which it would have come
        self._baseline: tuple[PickledBaseline | None, int | None, float] = (None, None, 0.0)  # of a detection, until s
        self._due: list[tuple[float, int]] = []
        self._of_checks: set[int] = set()  # detections that checks have made: no single channel shows them
        self._diagnosed: defaultdict[int, DiagnosesOfChange] = defaultdict(DiagnosesOfChange)  # by detection
        self.answer: dict[str, Any] | None = None
        self.answered: float | None = None
        self.error: str | None = None

    @property
    def asking(self) -> bool:
        """Whether a question is open that somebody waits for: a regular check gives way to any other."""
        return self._open is not None and not self._open.regular

    def detected(self, detection: Detection) -> None:
        """Plan the questions about a new detection; the rig as it was is then what it is after the change."""
        self._due += [(detection.detected + after, detection.number) for after in ASKED_AFTER_S]
        self.checks.begin(detection.detected + ASKED_AFTER_S[-1])

    def update(self, now: float) -> None:
        """Take an answer that has come, and ask what is due; waits in a replay only."""
        if self._held is not None and self._open is not None:
            if self._held.comes_at(self._open.asked) <= now:
                self._take(self._held, now)
        elif self._background is not None:
            reply = self._background.poll()
            if reply is not None:
                self._take(reply, now)
        if not self.asking:
            self._ask_what_is_due(now)

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
        shortage = self._windows(last, now).shortage
        if shortage:
            raise InputError(f"twin: too early for a diagnosis: {shortage}; ask later")
        self._start(last, now)

    def take_held_reply(self) -> None:
        """Take the reply that comes after the end of a replay; a regular check is of no use any more."""
        if self._held is not None and self._open is not None and not self._open.regular:
            self._take(self._held, self._held.comes_at(self._open.asked))

    def close(self) -> None:
        """End what is still being asked."""
        if self._background is not None:
            self._background.close()

    def _ask_what_is_due(self, now: float) -> None:
        due = [entry for entry in self._due if entry[0] <= now]
        if due:
            # Only the latest question of the latest detection still matters.
            self._due = [entry for entry in self._due if entry[0] > now]
            self._start(self._log.detections[max(number for _, number in due) - 1], now)
        elif self._open is None and self._ask is not None:
            windows = self.checks.due(now)
            if windows is not None:
                before = self.checks.baseline or recorded_log(self._buffers, self._rig, *windows.before)
                later = recorded_log(self._buffers, self._rig, *windows.after)
                self._put(_Open(now, None, regular=True), before, later, None, None)

    def _start(self, detection: Detection | None, now: float) -> None:
        if self._ask is None:
            return
        windows = self._windows(detection, now)
        number = None if detection is None else detection.number
        baseline, known_for, end = self._baseline
        if baseline is None or known_for != number or end > windows.before[1]:
            baseline, end = None, windows.before[1]
        self._baseline = (baseline, number, end)
        before = baseline or recorded_log(self._buffers, self._rig, *windows.before)
        later = recorded_log(self._buffers, self._rig, (windows.after if detection is None else windows.before)[0], now)
        begins = later.start_ns * 1e-9
        onset = None if detection is None else windows.onset_from(begins)
        self._put(_Open(now, number), before, later, self._since(detection, begins), onset)

    def _since(self, detection: Detection | None, begins: float) -> Since | None:
        """What was detected, for later samples that begin at a time, s."""
        if detection is None:
            return None
        channel = None if detection.number in self._of_checks else detection.channel
        seen = self._log.seen(detection.number)
        return Since(seen.since, seen.interval, True, begins, channel)

    def _put(
        self, question: _Open, before: RigLog | PickledBaseline, later: RigLog, since: Since | None, onset: Onset | None
    ) -> None:
        """Ask in the other process."""
        assert self._ask is not None
        self._background = self._background or BackgroundDiagnosis()
        self._background.end()
        self._open, self._held = question, None
        asked = Question(self._ask, before, later, self._rig, since, onset)
        if not self._replayed:
            self._background.start(asked)
            return
        self._background.start(replace(asked, nice=0))
        self._held = self._background.wait()

    def _windows(self, detection: Detection | None, now: float) -> Windows:
        """What to compare for a detection; without one, the recent past with what was before."""
        times = self._buffers["top_drive_angle"].time
        started = float(times[0]) if times.size else now
        middle = now - min(RECENT_S, 0.5 * (now - started))
        if detection is None:
            return windows_of_change((middle, middle), middle, started, now)
        if detection.kind != "ramp":
            return windows_of_change(detection.interval, detection.detected, started, now)
        # All of what grows is there later than it began: where features see it.
        shown = self._log.seen(detection.number).interval
        return windows_of_change(shown, detection.detected, started, now, detection.interval[0])

    def _take(self, reply: Reply, now: float) -> None:
        assert self._open is not None
        question, self._open, self._held = self._open, None, None
        number, change = question.number, None
        if question.regular:
            confirmed = self.checks.take(reply, question.asked)
            if confirmed is not None:
                number, change = self._take_confirmed(confirmed, now)
        else:
            self.error = reply.error
            if reply.tree is not None:
                self._baseline = (reply.baseline, *self._baseline[1:])
                change = self._note_answer(number, reply.tree, now)
        self._told(AnsweredQuestion(number, now, change, reply.error, reply.cpu, reply.peak))

    def _take_confirmed(self, confirmed: ConfirmedChange, now: float) -> tuple[int, DiagnosedChange | None]:
        """Make what two regular checks name a detection; its number, and what they say."""
        detection = self._log.take_confirmed(confirmed, self._dated(*confirmed.interval), now)
        self._baseline = (self.checks.baseline, detection.number, 0.0)  # the change began after it
        self.detected(detection)
        self._of_checks.add(detection.number)
        changes = [self._note_answer(detection.number, tree, now) for tree in confirmed.answers]
        return detection.number, changes[-1]

    def _note_answer(self, number: int | None, tree: dict[str, Any], now: float) -> DiagnosedChange | None:
        """Keep an answer; with a detection of this number what all its diagnoses say."""
        self.answer, self.answered = tree, now
        if number is None:
            return None
        change = self._diagnosed[number].take(tree)
        self._log.take_diagnosis(number, change, now)
        return change
