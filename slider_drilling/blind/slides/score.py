"""Score what the twin made of a sealed slide against its label."""

from __future__ import annotations

from dataclasses import dataclass

from slider_drilling.blind.slides.beginnings import NOTHING
from slider_drilling.blind.slides.label import SlideLabel
from slider_drilling.blind.slides.watched import NAMED_WITHIN_S, TwinAnswer, WatchedDetection, WatchedSlide

ONSET_TOLERANCE_S = 30.0
"""Error up to which the onset of a step counts as right."""
_EARLY_S = 30.0  # before an onset, from which a detection may be of it: onsets are estimated, and updates are coarse


@dataclass(frozen=True)
class ScoredSlide:
    """One slide.

    Attributes:
        log: File name of the log.
        case: Key of `beginnings.BEGINNINGS`, or ``none``.
        truth: Name of what began.
        step: Whether it began at once.
        size: Largest size, in noise levels.
        visible: Whether it reached 1.5 noise levels.
        false_alarms: Detections without a cause.
        quiet_s: s without anything, in which they may occur.
        detected: Whether a detection followed the beginning.
        delay: s between 1.5 noise levels and the detection, at least 0; None without one.
        onset_error: s between the onset that the detection gives and the true one; None without one.
        named: Names that the last answer in time gives, with those that it cannot distinguish.
        suspected: Names that it suspects.
        right: Whether one of them, or of the group, is right.
        wrong: Whether it names something, and none of it is right.
        site: Site of the answer, or of the detection without one.
        verdict: Of that answer, empty without one.
        cpu_share: Processor time of the twin over the time of the slide.
        memory: bytes.
    """

    log: str
    case: str
    truth: str
    step: bool
    size: float
    visible: bool
    false_alarms: int
    quiet_s: float
    detected: bool
    delay: float | None
    onset_error: float | None
    named: tuple[str, ...]
    suspected: tuple[str, ...]
    right: bool
    wrong: bool
    site: str | None
    verdict: str
    cpu_share: float
    memory: int


def score_slide(label: SlideLabel, watched: WatchedSlide) -> ScoredSlide:
    """The score of one slide."""
    onset = label.onset
    found = None if onset is None else _first_after(watched.detections, onset - _EARLY_S)
    early = [each for each in watched.detections if onset is None or each.detected < onset - _EARLY_S]
    answer = None if found is None else last_answer(found)
    named = () if answer is None else (*answer.effects, *(answer.group if answer.effects else ()))
    right = _is_right(label, named, answer)
    delay = None
    if found is not None and label.reached is not None:
        delay = max(found.detected - label.reached, 0.0)
    site = None if found is None else (answer.site if answer is not None and answer.site else found.site)
    return ScoredSlide(
        watched.log, label.case, label.name, label.name != NOTHING and label.growth == 0.0, label.size,
        label.reached is not None, len(early), watched.duration if onset is None else onset, found is not None, delay,
        None if found is None or onset is None else found.since - onset, named,
        () if answer is None else answer.suspected, right, bool(named) and not right, site,
        "" if answer is None else answer.verdict, watched.cpu_share, watched.memory,
    )  # fmt: skip


def last_answer(detection: WatchedDetection) -> TwinAnswer | None:
    """The last answer that came in time; None without one."""
    until = detection.detected + NAMED_WITHIN_S
    in_time = [each for each in detection.answers if each.answered <= until and not each.failure]
    return in_time[-1] if in_time else None


def _first_after(detections: tuple[WatchedDetection, ...], time: float) -> WatchedDetection | None:
    return next((each for each in detections if each.detected >= time), None)


def _is_right(label: SlideLabel, named: tuple[str, ...], answer: TwinAnswer | None) -> bool:
    """Whether a name is right. What is outside every catalogue is right where nothing is named, or at its site."""
    if answer is None or label.onset is None:
        return False
    if set(named) & set(label.accepted):
        return True
    if label.in_catalogue:
        return False
    return answer.verdict == "unknown" if not named else answer.site == label.site
