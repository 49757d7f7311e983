"""The twin's statuses in `diagnostics`: one for each site of a rig, and how the twin itself fares."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from slider_drilling.clock_time import time_of_day
from slider_drilling.messages.health import Level, Status
from slider_drilling.nodes.twin_status_relay import NOT_COMPARED
from slider_drilling.plain_names import plain_name
from slider_drilling.twin import Detection, MotorStall, TwinReport

_ANSWERS: dict[str | None, str] = {
    "none": "; a diagnosis finds nothing different", "inconclusive": "; a diagnosis allows no conclusion",
    "parameters": "; the rig's own numbers may explain it", "unknown": "; no known change explains it",
}  # fmt: skip
"""What is said of a change by the verdict of a diagnosis that names and suspects nothing."""
# Where effects act, and the hydraulics, where faults of the circulation do.
SITES = ("contact", "string", "top_drive", "draw_works", "motor", "bit", "hydraulics", "sensor")
_STALL_SHOWN_S = 60.0  # after a stall
_BEHIND_S = 10.0  # up to which a twin keeps up: samples may come late


@dataclass(frozen=True)
class TwinHealth:
    """How the twin keeps up.

    Attributes:
        behind: Newest sample less what is simulated, s.
        restarts: How often the rig's clock was set back.
        asking: Whether a diagnosis is under way.
        failure: What went wrong last; empty if nothing did.
    """

    behind: float
    restarts: int
    asking: bool
    failure: str = ""


def twin_statuses(report: TwinReport | None, start: float, health: TwinHealth) -> list[Status]:
    """The twin's own status, then one of each site.

    Args:
        report: The latest; None before the first.
        start: The twin's time 0, s of the rig's clock.
        health: How it keeps up.
    """
    if report is None:
        return [Status(Level.OK, "state", "waiting for samples of the drives")]
    by_site: dict[str, list[Detection]] = {site: [] for site in SITES}
    for detection in report.detections:
        by_site.setdefault(detection.site, []).append(detection)
    statuses = [_state(report, health), *(_site(site, found, start, report) for site, found in by_site.items())]
    stall = report.stall
    return statuses if stall is None else [_with_stall(each, stall, start, report.time) for each in statuses]


def _state(report: TwinReport, health: TwinHealth) -> Status:
    trends = [
        (f"trend_{name}{end}", f"{value:.4g}") for name, one in report.trends.items()
        for end, value in (("", one.value), ("_low", one.low), ("_high", one.high))
    ]  # fmt: skip
    behind, restarts = ("behind_s", f"{health.behind:.1f}"), ("restarts", str(health.restarts))
    values = (("state", report.state), behind, restarts, *trends)
    message = report.state + (f": {report.note}" if report.note else "")
    if health.behind > _BEHIND_S:
        message += f"; {health.behind:.0f} s behind the rig"
    if health.failure:
        return Status(Level.WARN, "state", f"{message}; {health.failure}", values)
    return Status(Level.OK, "state", message + ("; a diagnosis is under way" if health.asking else ""), values)


def _site(site: str, found: Iterable[Detection], start: float, report: TwinReport) -> Status:
    """A site: ERROR while a named effect acts there, WARN while something unnamed does.

    Of several changes it shows a named one before others, then the largest.
    """
    present = [one for one in found if one.ended is None]
    gaps = _gaps(report, {one.channel for one in present})
    if not present:
        return Status(Level.OK, site, "no change" if report.compared else NOT_COMPARED, gaps)
    worst = max(present, key=_severity)
    low, high = worst.interval
    values = (("since_s", f"{start + worst.since:.1f}"), ("since_low_s", f"{start + low:.1f}"),
              ("since_high_s", f"{start + high:.1f}"), ("detected_s", f"{start + worst.detected:.1f}"),
              ("channel", worst.channel), ("kind", worst.kind), ("size_noise_levels", f"{worst.size:.2f}"),
              ("effects", ", ".join(worst.effects)), ("suspected", ", ".join(worst.suspected)),
              ("verdict", worst.verdict or ""), ("changes", str(len(present))), *gaps)  # fmt: skip
    others = len(present) - 1
    more = f"; {others} other change{'' if others == 1 else 's'} there" if others else ""
    return Status(Level.ERROR if worst.effects else Level.WARN, site, describe(worst, start) + more, values)


def _with_stall(status: Status, stall: MotorStall, start: float, now: float) -> Status:
    """The motor's status with a stall before everything else, until some time after it."""
    if status.name != "motor" or (stall.ended is not None and now - stall.ended > _STALL_SHOWN_S):
        return status
    since, pressures = time_of_day(start + stall.since), stall.pressures()
    said = f"the motor stalls since {since}: {pressures}"
    if stall.ended is not None:
        said = f"the motor stalled from {since} to {time_of_day(start + stall.ended)}: {pressures}"
    other = f"; {status.message}" if status.level > Level.OK else ""
    values = (("stall_since_s", f"{start + stall.since:.1f}"), *status.values)
    return Status(max(status.level, Level.WARN), status.name, said + other, values)


def _severity(detection: Detection) -> tuple[bool, bool, float, int]:
    """Sorts changes: named, suspected, large, late."""
    size = detection.size if math.isfinite(detection.size) else 0.0
    return bool(detection.effects), bool(detection.suspected), size, detection.number


def describe(detection: Detection, start: float) -> str:
    """What changed, since when, and the named or suspected effect, in one line."""
    since = f"since {time_of_day(start + detection.since)}"
    if detection.effects:
        return f"{_words(detection.effects)} {since}: {detection.what}"
    if detection.suspected:
        return f"{detection.what}, {since}; suspected: {_words(detection.suspected)}"
    return f"{detection.what}, {since}" + _ANSWERS.get(detection.verdict, "")


def _words(names: Iterable[str]) -> str:
    return ", ".join(plain_name(name) for name in names)


def _gaps(report: TwinReport, channels: Iterable[str]) -> tuple[tuple[str, str], ...]:
    states: Mapping[str, object] = report.channels
    return tuple(
        (f"gap_60_{name}", f"{report.channels[name].gap_60:.2f}") for name in sorted(channels) if name in states
    )
