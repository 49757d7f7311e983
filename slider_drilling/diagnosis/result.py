"""The result of a diagnosis. Console, diagnosis.json and report.html are written from it.

None means unknown. Values are in SI units and rad; E is in multiples of the noise (docs/reference/diagnosis.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from slider_drilling.diagnosis.change import Change
from slider_drilling.diagnosis.rig_source import RigSource
from slider_drilling.gap.experiment_design.knowledge import Explanation
from slider_drilling.gap.model import Array
from slider_drilling.gap.results.breakdown import GapBreakdown
from slider_drilling.gap.results.next_manoeuvre import RecommendedManoeuvre
from slider_drilling.gap.results.whole_runs import WholeRunErrors
from slider_drilling.log_checks import LogChecks
from slider_drilling.rig import Rig
from slider_drilling.units import Text

Interval = tuple[float, float]

STAGES = ("nominal", "tuned", "with_effect")
STAGE_NAMES = {"nominal": "as given", "tuned": "calibrated", "with_effect": "with the effects"}
CHANGE_STAGE_NAMES = {"nominal": "as before", "tuned": "calibrated again", "with_effect": "with the change"}


@dataclass(frozen=True)
class FittedParameter:
    """A fitted parameter.

    Attributes:
        value: Fitted value.
        unit: Its SI unit, "-" for none.
        nominal: Value in the rig file, 1 for a multiple of it.
        interval: 95 % interval.
    """

    value: float
    unit: str
    nominal: float
    interval: Interval | None = None


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of a channel, one standard deviation.

    Attributes:
        value: As the log shows it.
        declared: As the rig file declares it.
        unit: Of both.
        method: How the log showed it.
        white: Whether what the final model leaves is white.
        excess: Measured over declared noise where the log scatters more than twice as much; the excess counts as gap.
    """

    value: float
    declared: float | None
    unit: str
    method: str
    white: bool | None = None
    excess: float | None = None


@dataclass(frozen=True)
class ChannelErrors:
    """RMS of measured minus simulated by stage; held out where parameters were fitted."""

    unit: str
    nominal: float | None
    tuned: float | None
    with_effect: float | None


@dataclass(frozen=True)
class Gap:
    """How large the gap is.

    Attributes:
        nominal: E with the rig file as given.
        tuned: E after calibration.
        with_effect: E with the effects; None without any.
        closed: Share of the calibrated gap that the effects close. None without effects, if the gap does not shrink,
            and if calibration leaves hardly more than noise.
        closed_interval: Its 95 % interval.
        threshold: E up to which nothing counts as a gap.
        noise_floor: Noise by channel.
        rms: Errors by channel.
        misfit_channels: Channels in which the final model leaves more than noise, or structure unlike noise.
        model_error: Share of what a channel moves by which the simulation may be wrong, by channel; empty
            where only a difference from a baseline is compared.
    """

    nominal: float | None = None
    tuned: float | None = None
    with_effect: float | None = None
    closed: float | None = None
    closed_interval: Interval | None = None
    threshold: float | None = None
    noise_floor: Mapping[str, ChannelNoise] = field(default_factory=dict)
    rms: Mapping[str, ChannelErrors] = field(default_factory=dict)
    misfit_channels: tuple[str, ...] = ()
    model_error: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ClosedShare:
    """Share of a gap that is closed, and its 95 % interval; None where it is too wide to say anything."""

    closed: float
    interval: Interval | None


@dataclass(frozen=True)
class RankedEffect:
    """One effect of the ranking.

    Attributes:
        effect: Its name.
        site: Where it acts.
        passed: It passed all criteria for a single effect.
        in_answer: The verdict rests on it.
        why_not: Why it is not in the answer.
        closed: Share of the gap that it closes, None where that says nothing.
        interval: Its 95 % interval.
        parameters: Fitted parameters by full name; empty if it was not fitted.
        group: Effects that this log cannot distinguish from it.
        other_runs: Share that it closes in runs that its fit has not seen, with several runs.
        accepted_with: Effects of the answer that were found together with it; `closed` is that of all of them.
        known_before: Effects found before it; `closed` is a share of the gap that these leave.
        suspected: There is evidence of it, but not of a size that may be named.
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
    accepted_with: tuple[str, ...] = ()
    known_before: tuple[str, ...] = ()
    suspected: bool = False


@dataclass(frozen=True)
class ResidualShape:
    """A free-form disturbance: a curve without a law.

    Attributes:
        of: What has this shape: the ``unknown``, an ``alternative`` that explains as much as the named effects, or the
            ``rest`` that they leave.
        disturbance: In words: "friction over depth".
        x: (n,) in `x_unit`.
        y: (n,) deviation from the model in `y_unit`; "-" is a share of the model's value.
        x_unit: SI unit, "-" for none.
        y_unit: Likewise.
    """

    of: Literal["unknown", "alternative", "rest"]
    disturbance: str
    x: Array
    y: Array
    x_unit: str
    y_unit: str


@dataclass(frozen=True)
class ChannelTrace:
    """A channel of one run.

    Attributes:
        run: Index of the run.
        channel: Its name.
        unit: SI unit of the values.
        time: (n,) s.
        measured: (n,).
        simulated: (n,) by stage: one simulation of the whole run.
        fitted_until: s; later samples were not fitted. None if all were.
    """

    run: int
    channel: str
    unit: str
    time: Array
    measured: Array
    simulated: Mapping[str, Array]
    fitted_until: float | None = None


@dataclass(frozen=True)
class Diagnosis:
    """What a diagnosis says about logs of one rig.

    Attributes:
        logs: Their paths.
        rig: The rig file as given.
        rig_source: Where it came from.
        log_checks: What the checks before any fit report.
        verdict: none, parameters, effect, effect_and_unknown, unknown or inconclusive (docs/reference/diagnosis.md).
        site: Where the gap lies.
        effects: The effects that the verdict rests on.
        suspected: Effects with evidence that are too small to be named.
        masked_effects: Effects that a far calibration may hide, most likely first.
        small_cause: With parameters: the suspected effect that explains what calibration leaves; None if nothing needs
            explaining.
        interrupted: The search was stopped before its end.
        gap: How large the gap is; None if nothing was fitted.
        breakdown: Where the gap lies, by channel, phase, frequency, time and depth.
        residual_shape: Shape of what no effect explains.
        ranking: All effects: those in the answer, those that were fitted, those that were not.
        next_manoeuvre: The run to ask for next; None where the answer stands.
        explanations: What may explain the logs, the answer first.
        tuned_parameters: Everything that was fitted in the final model.
        whole_run_errors: Errors of one free simulation of the whole log.
        fed_back: The measured channel that is fed back in the runs that `gap` counts; None for free runs.
        traces: Measured and simulated channels.
        simulations: How many simulations the search took.
        not_refitted: Held-out stretches that could not be refitted.
        remarks: What a reader must know besides.
        missing_channels: Channels that would help, one sentence each.
        runtime: s.
        change: What is different from a baseline; None for logs without one. With it, "as given" is the baseline's
            calibrated model, and E counts what that left over the baseline.
    """

    logs: tuple[str, ...]
    rig: Rig
    rig_source: RigSource
    log_checks: tuple[LogChecks, ...]
    verdict: str
    site: str | None = None
    effects: tuple[str, ...] = ()
    suspected: tuple[str, ...] = ()
    masked_effects: tuple[str, ...] = ()
    small_cause: str | None = None
    interrupted: bool = False
    gap: Gap | None = None
    breakdown: GapBreakdown | None = None
    residual_shape: ResidualShape | None = None
    ranking: tuple[RankedEffect, ...] = ()
    next_manoeuvre: RecommendedManoeuvre | None = None
    explanations: tuple[Explanation, ...] = ()
    tuned_parameters: Mapping[str, FittedParameter] = field(default_factory=dict)
    whole_run_errors: WholeRunErrors | None = None
    fed_back: str | None = None
    traces: tuple[ChannelTrace, ...] = field(default=(), repr=False)
    simulations: int = 0
    not_refitted: int = 0
    remarks: tuple[Text, ...] = ()
    missing_channels: tuple[str, ...] = ()
    runtime: float = 0.0
    change: Change | None = None

    @property
    def stage_names(self) -> Mapping[str, str]:
        """What the stages are called."""
        return STAGE_NAMES if self.change is None else CHANGE_STAGE_NAMES

    def candidate(self, effect: str) -> RankedEffect | None:
        """The ranking's entry of an effect."""
        return next((candidate for candidate in self.ranking if candidate.effect == effect), None)
