"""From alarms to detections: one for each change of the rig, kept up to date while data come."""

from __future__ import annotations

from dataclasses import dataclass, replace

from slider_drilling.twin.channels import COMPARED
from slider_drilling.twin.detector import Alarm
from slider_drilling.twin.features import FEATURES
from slider_drilling.twin.report import Detection

_SAME_S = 120.0  # after a detection, in which other channels show the same change
_SAME_ONSET_S = 60.0  # between the onsets of what is one change
_GROWING_S = 900.0  # for which a ramp may go on
_REFINED_S = 240.0  # for which time and kind of a detection follow the data
_BACK = (0.5, 2.0)  # of its size, by which a change that is over went back
_MIN_EVENT_S = 15.0
_SITES = {
    ("surface_torque", "mean"): "sensor", ("surface_torque", "gain"): "contact", ("surface_torque", "lag"): "top_drive",
    ("surface_torque", "spread"): "contact", ("standpipe_pressure", "mean"): "hydraulics",
    **{("hook_load", kind): "draw_works" for kind in FEATURES},
}
_VERBS = {
    "mean": ("rose", "fell"), "gain": ("moves more", "moves less"), "lag": ("is earlier", "is later"),
    "spread": ("scatters more", "scatters less"),
}  # fmt: skip


@dataclass
class _Open:
    """A detection that still follows the data.

    Attributes:
        alarm: The strongest so far.
        seen: (channel, kind) of all features that show it.
    """

    detection: Detection
    alarm: Alarm
    seen: set[tuple[str, str]]


class DetectionLog:
    """All detections of a run."""

    def __init__(self) -> None:
        self.detections: list[Detection] = []
        self._open: _Open | None = None

    def take(self, alarm: Alarm) -> bool:
        """Take an alarm; whether it is a new detection."""
        last = self._open
        if last is not None and self._is_over(last, alarm):
            ended = replace(last.detection, kind="event", ended=alarm.change.since)
            self.change(ended)
            return False
        if last is not None and self._belongs(last, alarm):
            last.seen.add((alarm.channel, alarm.kind))
            fresh = alarm.time - last.detection.detected <= _REFINED_S
            if fresh and alarm.change.evidence > last.alarm.change.evidence:
                last.alarm = alarm
                self.change(_described(alarm, last.detection))
            return False
        number = len(self.detections) + 1
        change = alarm.change
        detection = Detection(
            number, alarm.time, change.since, change.interval, alarm.channel, "", change.kind, change.size, ""
        )
        self.detections.append(detection)
        self._open = _Open(detection, alarm, {(alarm.channel, alarm.kind)})
        self.change(_described(alarm, detection))
        return True

    def settled_change(self, now: float) -> float | None:
        """The time (s) of a change whose refinement is over: until then the past can be forgotten. None without one."""
        last = self._open
        if last is None or now - last.detection.detected <= _REFINED_S:
            return None
        return last.detection.since

    def change(self, detection: Detection) -> None:
        """Replace the detection of the same number."""
        self.detections[detection.number - 1] = detection
        if self._open is not None and self._open.detection.number == detection.number:
            self._open.detection = detection

    def _is_over(self, last: _Open, alarm: Alarm) -> bool:
        """Whether the same number went back by about as much as it had changed."""
        first, second = last.alarm.change, alarm.change
        same = (alarm.channel, alarm.kind) == (last.alarm.channel, last.alarm.kind)
        back = first.size * second.size < 0.0 and _BACK[0] < abs(second.size / first.size) < _BACK[1]
        return same and back and second.since > max(first.interval[1], first.since + _MIN_EVENT_S)

    def _belongs(self, last: _Open, alarm: Alarm) -> bool:
        """Whether an alarm shows the last change: soon after its detection, with the same onset, or as it grows."""
        age, change = alarm.time - last.detection.detected, alarm.change
        if age <= _SAME_S or abs(change.since - last.detection.since) <= _SAME_ONSET_S:
            return True
        if (alarm.channel, alarm.kind) not in last.seen or age > _GROWING_S:
            return False
        grows = last.detection.kind == "ramp" and change.size * last.alarm.change.size > 0.0
        return grows or change.since <= last.detection.detected + _SAME_S


def _described(alarm: Alarm, before: Detection) -> Detection:
    change = alarm.change
    verb = _VERBS[alarm.kind][0 if change.size > 0.0 else 1]
    title = COMPARED[alarm.channel].title
    how = "at once" if change.kind == "step" else "steadily"
    what = f"{title} {verb} than the twin expects, {how}"
    if alarm.kind == "mean":
        what = f"{title} {verb} against the twin, {how}"
    site = _SITES.get((alarm.channel, alarm.kind), COMPARED[alarm.channel].sensor_site)
    return replace(
        before, since=change.since, interval=change.interval, channel=alarm.channel, kind=change.kind,
        size=abs(change.size), what=what, site=site if before.verdict is None else before.site,
    )  # fmt: skip
