"""What a diagnosis tells: the one tree that console, diagnosis.json and page are made from.

None stands for what is not known. Values are SI and rad; E is in noise floors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from slider_drilling.gap.model import Array

Interval = tuple[float, float]


@dataclass(frozen=True)
class FittedParameter:
    """A parameter that was fitted. interval: 95 %."""

    value: float
    unit: str
    nominal: float
    interval: Interval | None = None


@dataclass(frozen=True)
class ChannelNoise:
    """The noise of a channel as the log shows it (value) and as the rig file declares it, one standard deviation.

    white: whether what is called noise is white; excess: what lies above the declared noise and is treated as gap.
    """

    value: float
    declared: float | None
    unit: str
    method: str
    white: bool | None = None
    excess: float | None = None


@dataclass(frozen=True)
class ChannelErrors:
    """RMS difference of measured and simulated, held out where parameters were fitted."""

    unit: str
    nominal: float | None
    tuned: float | None
    with_effect: float | None


@dataclass(frozen=True)
class Gap:
    """E as given, re-tuned and with what was found, and the share of the re-tuned gap that this closes.

    closed is None wherever a share says nothing: where nothing was found, where the gap does not shrink, and where
    re-tuning leaves hardly more than noise would. threshold: what noise alone stays below, 99 times of a hundred;
    stand_out: channels of which the final model leaves more than noise does, or structure that noise has not.
    """

    nominal: float | None = None
    tuned: float | None = None
    with_effect: float | None = None
    closed: float | None = None
    closed_interval: Interval | None = None
    threshold: float | None = None
    noise_floor: Mapping[str, ChannelNoise] = field(default_factory=dict)
    rms: Mapping[str, ChannelErrors] = field(default_factory=dict)
    stand_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class ClosedShare:
    """A share of the gap that is closed. interval: 95 %, None where that says nothing."""

    closed: float
    interval: Interval | None


@dataclass(frozen=True)
class RankedEffect:
    """One effect of the ranking.

    passed: it passed the tests of a single effect; in_answer: the verdict rests on it; why_not: why it does not.
    closed: the share of the gap that it closes, None where that says nothing; group: effects that this log cannot
    tell from it; other_runs: what it closes of the gap of each run by a fit to the others, None where that was not
    asked, or nothing of it; together: effects in the answer that were found at once with it, all of which close that;
    beside: effects that were known before it, the gap that these leave being the one of which it closes that.
    """

    effect: str
    site: str
    passed: bool
    in_answer: bool
    why_not: tuple[str, ...]
    closed: float | None
    interval: Interval | None
    parameters: Mapping[str, FittedParameter]
    group: tuple[str, ...]
    other_runs: ClosedShare | None = None
    together: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()


ShapeOf = Literal["unknown", "alternative", "rest"]


@dataclass(frozen=True)
class ResidualShape:
    """A disturbance without a law: in words, and as a curve y (n,) over x (n,). of: what it is the shape of, the
    unknown, an alternative that explains as much as the effects that are named, or the rest that they leave.
    """

    of: ShapeOf
    words: str
    x_label: str
    y_label: str
    x: Array
    y: Array


@dataclass(frozen=True)
class Where:
    """Shares of E^2, each mapping adds up to 1; time and depth: rows with from, to, share (and change)."""

    channel: Mapping[str, float]
    phase: Mapping[str, float]
    band: Mapping[str, float]
    time: tuple[Mapping[str, float], ...]
    depth: tuple[Mapping[str, float], ...]


@dataclass(frozen=True)
class NextManoeuvre:
    """The run that would tell two effects apart best; distances in noise floors, there and in this log."""

    description: str
    settings: Mapping[str, float]
    separates: tuple[str, str]
    distance: float
    distance_now: float
    others: Mapping[str, float]


@dataclass(frozen=True)
class ChannelTrace:
    """A channel of a run, (n,) each: measured, and simulated in one go by each stage's parameters.

    fitted_until: s, where what was fitted ends; None where all of it was.
    """

    run: int
    channel: str
    unit: str
    time: Array
    measured: Array
    simulated: Mapping[str, Array]
    fitted_until: float | None = None


@dataclass(frozen=True)
class Outcome:
    """Everything that was found; see `slider_drilling.diagnosis.sentences` for it in sentences.

    instead: effects, likeliest first, that a re-tuning which was enough, but went far from the file, may stand for;
    horizon: s by channel, how far ahead the model foretells it; foretold: channels that it foretells to the end.
    """

    verdict: str
    site: str | None = None
    effects: tuple[str, ...] = ()
    instead: tuple[str, ...] = ()
    partial: bool = False
    gap: Gap | None = None
    where: Where | None = None
    shape: ResidualShape | None = None
    ranking: tuple[RankedEffect, ...] = ()
    next_manoeuvre: NextManoeuvre | None = None
    tuned_parameters: Mapping[str, FittedParameter] = field(default_factory=dict)
    horizon: Mapping[str, float] | None = None
    foretold: tuple[str, ...] = ()
    counts: Mapping[str, int] | None = None
    remarks: tuple[str, ...] = ()
    simulated: Mapping[str, Any] | None = None
    traces: tuple[ChannelTrace, ...] = field(default=(), repr=False)
    runtime: float = 0.0

    def candidate(self, effect: str) -> RankedEffect | None:
        """The ranking's entry of an effect."""
        return next((one for one in self.ranking if one.effect == effect), None)
