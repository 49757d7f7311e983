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
from slider_drilling.twin import Detection, Twin, diagnose_after
from slider_drilling.twin.diagnoser import AnsweredQuestion
from slider_drilling.twin.feed import LogFeed
from slider_drilling.twin.watch import reports_of

NAMED_WITHIN_S = 180.0
"""Time after a detection within which an answer counts."""


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
    """Run the twin over a log as if it came live."""
    rig = log.rig()
    asked: list[AnsweredQuestion] = []
    twin = Twin(rig, ask=diagnose_after if diagnose else None, replayed=True, told=asked.append)
    feed, forecasts = LogFeed(log), ForecastLog()
    began, watched, last = clock.process_time(), 0, 0.0
    for report in reports_of(twin, feed):
        watched += report.state == "watching"
        last = report.time
        forecasts.add(report)
    cost = clock.process_time() - began
    twin.take_held_answer()
    found = twin.latest_report()
    twin.close()
    detections = () if found is None else found.detections
    return WatchedSlide(
        Path(log.source).name, last, float(watched), tuple(_with_answers(each, asked) for each in detections),
        cost / max(last, 1.0), tuple(each.cpu for each in asked), _resident_bytes(), forecasts.errors(log, rig),
        max((each.peak for each in asked), default=0),
    )  # fmt: skip


def _with_answers(detection: Detection, asked: Sequence[AnsweredQuestion]) -> WatchedDetection:
    """A detection with the answers to the questions about it."""
    answers = [_answer(each) for each in asked if each.number == detection.number]
    return WatchedDetection(
        detection.detected, detection.since, detection.interval, detection.channel, detection.site, detection.kind,
        tuple(answers),
    )  # fmt: skip


def _answer(question: AnsweredQuestion) -> TwinAnswer:
    change = question.change
    if change is None:
        return TwinAnswer(question.answered, "failed", failure=question.error or "")
    return TwinAnswer(question.answered, change.verdict, change.effects, change.group, change.suspected, change.site)


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
