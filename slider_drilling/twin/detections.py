"""From alarms to detections: one for each change of the rig, kept up to date while data come."""

from __future__ import annotations

from dataclasses import dataclass, replace

from slider_drilling.twin.agreement import Began, DiagnosedChange
from slider_drilling.twin.change_statistic import FeatureChange
from slider_drilling.twin.channels import COMPARED
from slider_drilling.twin.detector import Alarm
from slider_drilling.twin.features import FEATURES
from slider_drilling.twin.regular_checks import ConfirmedChange
from slider_drilling.twin.report import Detection

_SAME_S = 120.0  # after a detection, in which other channels show the same change
_SAME_ONSET_S = 60.0  # between the onsets of what is one change
_DATED_S = 30.0  # within which an onset after a detection may be that of the change that was detected
_GROWING_S = 900.0  # for which a ramp may go on
_MOVED_BY_FRICTION = {"surface_torque", "hook_load"}
_REFINED_S = 240.0  # for which time and kind of a detection follow the data
_BACK = (0.5, 2.0)  # of its size, by which a change that is over went back
_MIN_EVENT_S = 15.0
_NO_FEATURE = ""  # in the place of a feature's kind, where none shows the change
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
        began: What its diagnosis dates it to; None where it dates nothing.
    """

    detection: Detection
    alarm: Alarm
    seen: set[tuple[str, str]]
    began: Began | None = None


class DetectionLog:
    """All detections of a run."""

    def __init__(self) -> None:
        self.detections: list[Detection] = []
        self._open: list[_Open] = []

    def take(self, alarm: Alarm) -> bool:
        """Take an alarm; whether it is a new detection."""
        over = next((each for each in reversed(self._open) if _is_over(each, alarm)), None)
        if over is not None:
            self.change(replace(over.detection, kind="event", ended=alarm.change.since))
            return False
        # What began before the first of two detections belongs to that.
        shown = next((each for each in self._open if _belongs(each, alarm)), None)
        if shown is not None:
            shown.seen.add((alarm.channel, alarm.kind))
            fresh = alarm.time - shown.detection.detected <= _REFINED_S
            if fresh and _began_before(shown, alarm) and alarm.change.evidence > shown.alarm.change.evidence:
                shown.alarm = alarm
                self.change(_dated(_described(alarm, shown.detection), shown))
            return False
        change = alarm.change
        detection = Detection(
            len(self.detections) + 1, alarm.time, change.since, change.interval, alarm.channel, "", change.kind,
            change.size, "",
        )  # fmt: skip
        self._add(_described(alarm, detection), alarm)
        return True

    def take_confirmed(self, found: ConfirmedChange, dated: FeatureChange | None, now: float) -> Detection:
        """Take a change that regular checks have found at a time, s, as a new detection.

        Args:
            found: The change.
            dated: What a feature shows of it, None if none does.
            now: s.
        """
        low, high = found.interval
        since, interval = (0.5 * (low + high), (low, high)) if dated is None else (dated.since, dated.interval)
        compared = COMPARED[found.channel]
        detection = Detection(
            len(self.detections) + 1, now, since, interval, found.channel, compared.sensor_site, found.kind,
            found.size, f"two regular checks found the same change, mostly in the {compared.title}",
        )  # fmt: skip
        change = FeatureChange(0.0, since, interval, found.kind, found.size, in_operation=False)
        self._add(detection, Alarm(now, found.channel, _NO_FEATURE, change))
        return detection

    def take_diagnosis(self, number: int, diagnosed: DiagnosedChange, now: float) -> None:
        """Take what the diagnoses of a detection say at a time, s: a change that they name may have its time from them.

        Args:
            number: Of the detection.
            diagnosed: What they say.
            now: s.
        """
        shown = self._open[number - 1]
        began = diagnosed.began
        shown.began = began if began is not None and began.since <= shown.detection.detected else None
        found = replace(
            shown.detection, effects=diagnosed.effects, suspected=diagnosed.suspected, verdict=diagnosed.verdict,
            answered=now, site=diagnosed.site or _likely_site(shown.alarm),
        )  # fmt: skip
        self.change(_dated(found, shown))

    def seen(self, number: int) -> FeatureChange:
        """What features, or checks, show of a detection of this number, whatever its diagnosis dates it to."""
        return self._open[number - 1].alarm.change

    def settled_change(self, now: float) -> float | None:
        """The time (s) of a change whose refinement is over: until then the past can be forgotten. None without one."""
        last = self.detections[-1] if self.detections else None
        return None if last is None or now - last.detected <= _REFINED_S else last.since

    def _add(self, detection: Detection, alarm: Alarm) -> None:
        self.detections.append(detection)
        self._open.append(_Open(detection, alarm, {(alarm.channel, alarm.kind)}))

    def change(self, detection: Detection) -> None:
        """Replace the detection of the same number."""
        self.detections[detection.number - 1] = detection
        self._open[detection.number - 1].detection = detection


def _is_over(last: _Open, alarm: Alarm) -> bool:
    """Whether the same number went back by about as much as it had changed."""
    first, second = last.alarm.change, alarm.change
    same = (alarm.channel, alarm.kind) == (last.alarm.channel, last.alarm.kind)
    back = first.size * second.size < 0.0 and _BACK[0] < abs(second.size / first.size) < _BACK[1]
    return same and back and second.since > max(first.interval[1], first.since + _MIN_EVENT_S)


def _belongs(last: _Open, alarm: Alarm) -> bool:
    """Whether an alarm shows a detected change: soon after its detection, with the same onset, or as it grows."""
    age, seen = alarm.time - last.detection.detected, (alarm.channel, alarm.kind) in last.seen
    if age <= _SAME_S and alarm.change.interval[0] <= last.detection.detected + _DATED_S:
        return True
    if last.detection.kind == "ramp" and age <= _GROWING_S and _may_grow_with(last, alarm, seen):
        return True
    if not _began_before(last, alarm):
        return False
    if abs(alarm.change.since - last.detection.since) <= _SAME_ONSET_S:
        return True
    return seen and age <= _GROWING_S


def _may_grow_with(last: _Open, alarm: Alarm, seen: bool) -> bool:
    """Whether an alarm of a later onset may show a ramp that goes on growing.

    Its onset moves on in what has shown it. Friction that grows shows in torque and hook load, in each of their
    features at another time.
    """
    if seen:
        return alarm.change.size * last.alarm.change.size > 0.0
    return alarm.change.kind == "ramp" and {alarm.channel, last.detection.channel} <= _MOVED_BY_FRICTION


def _began_before(last: _Open, alarm: Alarm) -> bool:
    """Whether what an alarm shows began before a change was detected."""
    return alarm.change.since <= last.detection.detected


def _dated(detection: Detection, shown: _Open) -> Detection:
    """The detection with the time that its diagnosis gives it, or else with what the features say."""
    if detection.kind == "event":
        return detection
    began, alarm = shown.began or shown.alarm.change, shown.alarm
    what = detection.what if alarm.kind == _NO_FEATURE else _seen(alarm, began.kind)
    return replace(detection, since=began.since, interval=began.interval, kind=began.kind, what=what)


def _described(alarm: Alarm, before: Detection) -> Detection:
    change = alarm.change
    return replace(
        before, since=change.since, interval=change.interval, channel=alarm.channel, kind=change.kind,
        size=abs(change.size), what=_seen(alarm, change.kind),
        site=_likely_site(alarm) if before.verdict is None else before.site,
    )  # fmt: skip


def _seen(alarm: Alarm, kind: str) -> str:
    """What a feature shows of a step or a ramp, in a sentence."""
    verb = _VERBS[alarm.kind][0 if alarm.change.size > 0.0 else 1]
    against = "against the twin" if alarm.kind == "mean" else "than the twin expects"
    return f"{COMPARED[alarm.channel].title} {verb} {against}, {'at once' if kind == 'step' else 'steadily'}"


def _likely_site(alarm: Alarm) -> str:
    """Where a change lies that no diagnosis places."""
    return _SITES.get((alarm.channel, alarm.kind), COMPARED[alarm.channel].sensor_site)
