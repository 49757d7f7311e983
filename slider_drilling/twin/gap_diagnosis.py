"""What a twin has found so far as one JSON object: the content of the topic `gap/diagnosis`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from slider_drilling.twin.report import Detection, TwinReport

SCHEMA = "slider_drilling/gap_diagnosis/1"


def gap_diagnosis(
    report: TwinReport, start: float, answer: Mapping[str, Any] | None, answered: float | None
) -> dict[str, Any]:
    """State, detections and the last answer; times are s of the rig's clock, but those of the answer s since `start`.

    Args:
        report: The latest.
        start: The twin's time 0, s of the rig's clock.
        answer: Of the last diagnosis, as diagnosis.json has it; None before the first.
        answered: Time of the answer, s since the twin's start.
    """
    return {
        "schema": SCHEMA,
        "start": start,
        "state": report.state,
        "note": report.note,
        "compared": report.compared,
        "detections": [_detection(one, start) for one in report.detections],
        "answered": None if answered is None else start + answered,
        "answer": answer,
    }


def _detection(detection: Detection, start: float) -> dict[str, Any]:
    """A detection as in `slider-drilling watch --json`, and the rest of it."""
    low, high = detection.interval
    return {
        **detection.as_json(),
        "detected": start + detection.detected,
        "since": start + detection.since,
        "interval": [start + low, start + high],
        "answered": None if detection.answered is None else start + detection.answered,
        "ended": None if detection.ended is None else start + detection.ended,
        "number": detection.number,
        "channel": detection.channel,
        "kind": detection.kind,
        "size": detection.size if math.isfinite(detection.size) else None,
        "what": detection.what,
    }
