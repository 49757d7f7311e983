"""Run the twin over one sealed slide: what it detects, names and forecasts, and what that costs."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slider_drilling.blind.slides.forecasts import ForecastErrors, ForecastLog
from slider_drilling.campaign.job import Job
from slider_drilling.log import RigLog, read_log
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.twin import Detection, Twin, diagnose_after
from slider_drilling.twin.agreement import DiagnosesOfChange
from slider_drilling.twin.ask import windows_of_change
from slider_drilling.twin.background import BackgroundDiagnosis, PickledBaseline, Question, Reply
from slider_drilling.twin.diagnoser import ASKED_AFTER_S
from slider_drilling.twin.feed import LogFeed
from slider_drilling.twin.watch import reports_of

NAMED_WITHIN_S = 180.0
"""Time after a detection within which an answer counts."""
_ASKED_DETECTIONS = 2  # of one slide; each costs some diagnoses


@dataclass(frozen=True)
class TwinAnswer:
    """One answer of the diagnosis after a detection.

    Attributes:
        answered: s of the slide: when it was asked, and the processor time that it took.
        verdict: Of the diagnosis.
        effects: Named effects.
        group: Effects that it cannot distinguish from the first of them.
        suspected: Effects that it suspects.
        site: Where it acts, None if unknown.
        failure: Why there is no answer; empty if there is one.
    """

    answered: float
    verdict: str
    effects: tuple[str, ...] = ()
    group: tuple[str, ...] = ()
    suspected: tuple[str, ...] = ()
    site: str | None = None
    failure: str = ""


@dataclass(frozen=True)
class WatchedDetection:
    """A detection of the twin, with the answers to it in their order. Fields are those of `twin.Detection`."""

    detected: float
    since: float
    interval: tuple[float, float]
    channel: str
    site: str
    kind: str
    answers: tuple[TwinAnswer, ...] = ()


@dataclass(frozen=True)
class WatchedSlide:
    """What the twin made of one slide.

    Attributes:
        log: File name.
        duration: s.
        watched: s in which the twin compared; the rest it learnt or saw an operation.
        detections: In their order.
        cpu_share: Processor time over the time of the slide, without diagnoses.
        diagnosis_cpu: s of processor time of every diagnosis, each a process of its own.
        memory: bytes that the process of the twin held at the end.
        diagnosis_memory: bytes, the most that the process of a diagnosis held; 0 without one.
        forecasts: Errors of the forecasts.
    """

    log: str
    duration: float
    watched: float
    detections: tuple[WatchedDetection, ...]
    cpu_share: float
    diagnosis_cpu: tuple[float, ...]
    memory: int
    forecasts: ForecastErrors
    diagnosis_memory: int = 0


def watch_job(log: Path, forbidden: tuple[str, ...], diagnose: bool = True) -> Job:
    """The job that watches a slide.

    Args:
        log: Of the slide.
        forbidden: Folders that it cannot open, which hold the labels.
        diagnose: Whether to ask what has changed.
    """
    call = "slider_drilling.blind.slides.watched:watch_sealed"
    options = {"diagnose": diagnose}
    return Job(call, log.stem, {"log": str(log)}, options, forbidden_folders=forbidden, new_process=True)


def watch_sealed(job: Job) -> dict[str, Any]:
    """Watch the slide of a job."""
    return asdict(watch_slide(read_log(Path(job.inputs["log"])), bool(job.options["diagnose"])))


def watch_slide(log: RigLog, diagnose: bool = True) -> WatchedSlide:
    """Run the twin over a log as if it came live; diagnoses are asked at the times at which the twin asks them."""
    rig = log.rig()
    twin, feed, forecasts = Twin(rig, ask=None), LogFeed(log), ForecastLog()
    began, watched, last = clock.process_time(), 0, 0.0
    known: list[tuple[Detection, ...]] = []  # second by second: dates of changes move while more is seen
    for report in reports_of(twin, feed):
        known.append(report.detections)
        watched += report.state == "watching"
        last = report.time
        forecasts.add(report)
    cost = clock.process_time() - began
    found = twin.latest_report()
    detections = () if found is None else found.detections
    twin.close()
    asked = detections[:_ASKED_DETECTIONS] if diagnose else ()
    answered = [_with_answers(log, each, known, each in asked) for each in detections]
    replies = [reply for _, own in answered for reply in own]
    memory = _resident_bytes()
    return WatchedSlide(
        Path(log.source).name, last, float(watched), tuple(each for each, _ in answered), cost / max(last, 1.0),
        tuple(reply.cpu for reply in replies), memory, forecasts.errors(log, rig),
        max((reply.peak for reply in replies), default=0),
    )  # fmt: skip


def _with_answers(
    log: RigLog, detection: Detection, known: Sequence[tuple[Detection, ...]], asked: bool
) -> tuple[WatchedDetection, list[Reply]]:
    """A detection with its answers, and the replies of the processes that gave them.

    Args:
        log: The whole log.
        detection: As it was known in the end.
        known: All detections as they were known, one entry a second; the last is the end of the log.
        asked: Whether there are answers.
    """
    answers: list[TwinAnswer] = []
    replies: list[Reply] = []
    diagnosed = DiagnosesOfChange()
    baseline: PickledBaseline | None = None
    first = next(second for second, all_then in enumerate(known) if len(all_then) >= detection.number)
    for after in ASKED_AFTER_S if asked else ():
        second = first + round(after)
        if after >= NAMED_WITHIN_S or second >= len(known):
            break
        then, now = known[second][detection.number - 1], detection.detected + after
        reply = _ask(log, then, now, baseline)
        baseline = reply.baseline or baseline
        replies.append(reply)
        answers.append(_answer(reply, now, diagnosed))
    low, high = detection.interval
    watched = WatchedDetection(
        detection.detected, detection.since, (low, high), detection.channel, detection.site, detection.kind,
        tuple(answers),
    )  # fmt: skip
    return watched, replies


def _ask(log: RigLog, detection: Detection, now: float, baseline: PickledBaseline | None) -> Reply:
    """Ask in a process of its own, as the twin does; baseline: of the question before about the same change."""
    windows = windows_of_change(detection.interval, detection.detected, 0.0, now)
    before = baseline or cut_time_window(log, *windows.before)
    background = BackgroundDiagnosis()
    try:
        after = cut_time_window(log, windows.after, now)
        background.start(Question(diagnose_after, before, after, log.rig(), detection.channel, nice=0))
        reply = background.wait()
    finally:
        background.close()
    assert reply is not None
    return reply


def _answer(reply: Reply, asked: float, diagnosed: DiagnosesOfChange) -> TwinAnswer:
    """What the twin makes of a reply that was asked for at a time of the slide, s."""
    answered = reply.comes_at(asked)
    if reply.tree is None:
        return TwinAnswer(answered, "failed", failure=reply.error or "")
    change = diagnosed.take(reply.tree)
    return TwinAnswer(answered, change.verdict, change.effects, change.group, change.suspected, change.site)


def _resident_bytes() -> int:
    """Memory that this process holds now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def watched_from_json(tree: dict[str, Any]) -> WatchedSlide:
    """The slide that `watch_sealed` gave."""
    detections = tuple(
        WatchedDetection(**(_tuples(each) | {"answers": tuple(TwinAnswer(**_tuples(own)) for own in each["answers"])}))
        for each in tree["detections"]
    )
    forecasts = ForecastErrors(**tree["forecasts"])
    return WatchedSlide(**(_tuples(tree) | {"detections": detections, "forecasts": forecasts}))


def _tuples(tree: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in tree.items()}
