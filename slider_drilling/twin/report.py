"""What a twin says: once a second a report, and the detections so far."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from slider_drilling.twin.samples import Array
from slider_drilling.twin.stall_watch import MotorStall


@dataclass(frozen=True)
class Trend:
    """A calibrated number now, with its 95 % interval.

    Attributes:
        value: Over the rig file's value, or in the unit.
        low, high: Limits of the interval.
        unit: `-` for a multiple of the rig file's value.
    """

    value: float
    low: float
    high: float
    unit: str = "-"


@dataclass(frozen=True)
class ChannelState:
    """One channel now. What is unknown is NaN.

    Attributes:
        name: A key of `channels.COMPARED`.
        unit: SI.
        measured: The last reading.
        expected: What the calibrated twin has at the same time.
        gap_10, gap_60, gap_300: RMS of measured minus expected over so many s, in noise levels.
        threshold: Gap over 60 s that the channel exceeds in 1 % of the time on a rig that does not change.
        noise: The noise level, in the unit.
    """

    name: str
    unit: str
    measured: float
    expected: float
    gap_10: float
    gap_60: float
    gap_300: float
    threshold: float
    noise: float


@dataclass(frozen=True)
class Forecast:
    """Free run of the calibrated twin from now on; the drives go on as they did.

    Attributes:
        made_at: s.
        time: s, (n,).
        tool_face: rad, unwrapped, (n,).
        surface_torque: N m, (n,).
    """

    made_at: float
    time: Array
    tool_face: Array
    surface_torque: Array


@dataclass(frozen=True)
class Detection:
    """A change of the rig.

    Attributes:
        number: From 1.
        detected: s, when it was noticed.
        since: s, when it began.
        interval: s, 95 % interval of that.
        channel: That shows it most.
        site: Where it lies: that of the diagnosis, before that the sensor's or the likeliest one.
        kind: ``step``, ``ramp`` or ``event``, which is over again.
        size: Change of the channel, in noise levels.
        what: One sentence.
        effects: Named by the diagnosis.
        suspected: Suspected by the diagnosis.
        verdict: Of the diagnosis; None before there is one.
        answered: s, when the diagnosis answered.
        ended: s, when the channel was back; None while it is not.
    """

    number: int
    detected: float
    since: float
    interval: tuple[float, float]
    channel: str
    site: str
    kind: str
    size: float
    what: str
    effects: tuple[str, ...] = ()
    suspected: tuple[str, ...] = ()
    verdict: str | None = None
    answered: float | None = None
    ended: float | None = None

    def as_json(self) -> dict[str, Any]:
        """The fields of `slider-drilling watch --json`."""
        return {
            "detected": self.detected, "since": self.since, "interval": list(self.interval), "site": self.site,
            "effects": list(self.effects), "suspected": list(self.suspected), "verdict": self.verdict,
            "answered": self.answered,
        }  # fmt: skip


@dataclass(frozen=True)
class TwinReport:
    """The twin after one second more of the rig.

    Attributes:
        time: s.
        state: ``learning``, ``operation`` (what happens is no slide: nothing is compared) or ``watching``.
        note: Why, in words.
        samples: (n,) s, the times of the last second.
        expected: Channel -> (n,) values of the calibrated twin then; toolface is unwrapped.
        channels: State of every compared channel that the rig has.
        trends: Calibrated numbers.
        forecast: The latest.
        detections: All so far, newest last.
        stall: The last stall of the motor; None without one.
    """

    time: float
    state: str
    note: str
    samples: Array
    expected: Mapping[str, Array]
    channels: Mapping[str, ChannelState]
    trends: Mapping[str, Trend] = field(default_factory=dict)
    forecast: Forecast | None = None
    detections: tuple[Detection, ...] = ()
    stall: MotorStall | None = None

    @property
    def compared(self) -> bool:
        """Whether the rig is learnt, so that a change would show."""
        return self.state in ("watching", "operation")

    def as_json(self) -> dict[str, Any]:
        """The line of `slider-drilling watch --json`; what is unknown is None."""
        gap = {name: _number(channel.gap_60) for name, channel in self.channels.items()}
        threshold = {name: _number(channel.threshold) for name, channel in self.channels.items()}
        detections = [detection.as_json() for detection in self.detections]
        return {"t": self.time, "gap": gap, "threshold": threshold, "detections": detections}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
