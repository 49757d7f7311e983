"""What the page's script draws of a twin, as plain JSON; sent when it has changed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from slider_drilling.clock_time import time_of_day
from slider_drilling.live.twin_state import TwinState
from slider_drilling.plain_names import plain_name
from slider_drilling.units import SI, Units, quantities_in

_SAME_TIME = 0.5  # s, less than a text shows
_TRENDS = ("friction", "motor_gain", "circulating_pressure", "string_stiffness")


def twin_json(twin: TwinState, now: float, units: Units = SI) -> dict[str, Any]:
    """Gaps, detections and trends for the browser.

    Args:
        twin: What the twin says.
        now: Time of the latest sample, s.
        units: Of texts.
    """
    points = twin.trends()
    detections = [_detection_json(one, units) for one in twin.detections()]
    return {
        "now": round(now, 1),
        "start": round(points[0].time, 1) if points else None,
        "gaps": [_gap_json(name, *numbers) for name, numbers in twin.gaps().items()],
        "compared": twin.compared,
        "detections": [one for one in detections if one is not None],
        "trends": [
            {"name": plain_name(name),
             "points": [[round(point.time, 1), *map(_finite, point.numbers[name])]
                        for point in points if name in point.numbers]}
            for name in _TRENDS
        ],
    }  # fmt: skip


def _gap_json(name: str, quick: float, gap: float, slow: float, threshold: float) -> dict[str, Any]:
    """Gaps over 10, 60 and 300 s as shares of the threshold, and the numbers as text."""

    def share(value: float) -> float | None:
        return _finite(value / threshold) if threshold > 0.0 else None

    limit = f"of {threshold:.2f}" if math.isfinite(threshold) else "(no threshold)"
    shown = f"{_number(gap)} {limit}"
    return {
        "name": plain_name(name),
        "share": share(gap),
        "quick": share(quick),
        "slow": share(slow),
        "shown": shown,
    }


def _detection_json(one: Mapping[str, Any], units: Units) -> dict[str, Any] | None:
    """One detection for the time line; None if its times are missing."""
    times = [one.get("detected"), one.get("since")]
    interval = one.get("interval")
    if not all(isinstance(time, (int, float)) for time in times):
        return None
    if not isinstance(interval, (list, tuple)) or len(interval) != 2:
        interval = [one["since"], one["since"]]
    return {
        "detected": one["detected"], "since": one["since"], "interval": list(interval), "ended": one.get("ended"),
        "named": bool(one.get("effects")), "label": detection_label(one, units),
    }  # fmt: skip


def detection_label(one: Mapping[str, Any], units: Units = SI) -> str:
    """What a detection is called: its effects; else those suspected; else what was seen."""
    effects, suspected = (
        ", ".join(plain_name(str(name)) for name in one.get(key) or ()) for key in ("effects", "suspected")
    )
    if effects:
        return effects
    seen = units.convert_text(quantities_in(str(one.get("what") or one.get("site") or "a change")))
    return f"suspected: {suspected} ({seen})" if suspected else seen


def answer_text(twin: TwinState, units: Units = SI) -> str:
    """What the last diagnosis says by itself, and when; empty before the first."""
    answer = twin.answer()
    if answer is None:
        return ""
    start = float(twin.diagnosis().get("start") or 0.0)
    counted = f", its times counted from {time_of_day(start)}" if abs(start) > _SAME_TIME else ""
    return f"The last diagnosis, at {time_of_day(answer[0])}{counted}: {units.convert_text(quantities_in(answer[1]))}"


def _number(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _finite(value: float) -> float | None:
    return round(value, 5) if math.isfinite(value) else None
