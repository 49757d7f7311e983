"""What the diagnosis of a later log says beside an earlier one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from slider_drilling.diagnosis.change_answer import ChangedParameter
from slider_drilling.gap.model import Array

Span = tuple[float, float]


@dataclass(frozen=True)
class HeldShare:
    """How much of the named change the samples hold, by parts of half a minute.

    Attributes:
        time: (n,) s of the log that the user gave, middle of each part.
        share: (n,) 0 for none of it, 1 for all that is named.
        interval: (n, 2) 95 % interval of that.
    """

    time: Array
    share: Array
    interval: Array


@dataclass(frozen=True)
class Change:
    """What is different from a baseline.

    Attributes:
        baseline: Logs of the baseline.
        log_start: s of the log that the user gave, at which the compared log begins; 0 for a log of its own.
        since: s of that log, from when on it is different; None where only two whole logs were compared.
        since_interval: 95 % interval of ``since``, None if unknown.
        found: Whether ``since`` was found by change detection.
        dated: Whether ``since`` and its interval are what the size of the named change over time shows.
        gradual: Whether it came on over time, not at once, as its size shows; None where it is not `dated`.
        held: How much of the named change the samples hold over time; None without a name, or where nothing shows it.
        growing: Whether the named change grows from then on until the end of the log; None without a name.
        moved: Calibrated numbers of the rig that changed, by name.
        explained: Share of the difference that the answer explains.
        explained_interval: Its 95 % interval.
        baseline_gap: E of the calibrated model over the baseline, in the noise of the sensors.
        gap_before: E of the later log under the baseline's calibrated model; one unit is what the baseline left.
        standing: Effects that the rig had all along.
        baseline_values: Calibrated values of the baseline, by name.
    """

    baseline: tuple[str, ...]
    log_start: float = 0.0
    since: float | None = None
    since_interval: Span | None = None
    found: bool = False
    dated: bool = False
    gradual: bool | None = None
    held: HeldShare | None = None
    growing: bool | None = None
    moved: Mapping[str, ChangedParameter] = field(default_factory=dict)
    explained: float | None = None
    explained_interval: Span | None = None
    baseline_gap: float = 1.0
    gap_before: float = 1.0
    standing: tuple[str, ...] = ()
    baseline_values: Mapping[str, float] = field(default_factory=dict)
