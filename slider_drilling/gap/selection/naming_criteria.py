"""What an effect must pass before the diagnosis names it: one table, `CRITERIA`, of all rules.

Every rule has a name, what is tested, a threshold, the message that users see when it fails, and the reason why it
exists. Significance (is the change more than chance?) and size (is it large enough to matter?) are separate rules.
Rules apply at different stages of the search (`Stage`); `failures` evaluates those of one stage. `criteria_table`
gives the table as plain strings.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from slider_drilling.gap.evidence.compare import NAMING_LEVEL
from slider_drilling.gap.problem.model_error import INDEPENDENT_ERRORS
from slider_drilling.gap.search.multi_start import NUISANCE_LIMIT
from slider_drilling.gap.selection import evidence_tests as tests
from slider_drilling.gap.selection.evidence_tests import MIN_GAP, MIN_GAP_CLOSED, MIN_SHARE_OF_CAUSE, Evidence
from slider_drilling.gap.selection.nuisance_limits import outside_prior

_PERCENT = f"{100.0 * MIN_GAP_CLOSED:g} %"
_LEVEL = f"{100.0 * NAMING_LEVEL:g} %"
_SHARED_LEVEL = f"{_LEVEL} divided by the number of candidates"


class Kind(Enum):
    """What a rule asks. An effect that fails rules of size alone has evidence, and is reported as suspected."""

    EVIDENCE = "evidence"
    MEANING = "meaning"
    SIZE = "size"


class Stage(Enum):
    """When a rule applies; the value says to what."""

    CANDIDATE = "every candidate of a step"
    OTHER_RUNS = "a candidate that passed so far, of several runs"
    SECOND_EFFECT = "a candidate that passed so far, beside effects already in the model"
    PLAUSIBLE_CALIBRATION = "a candidate, where calibration alone is enough but needs implausible values"
    REPLACES_CALIBRATION = "a candidate that passed so far, where calibration alone needs implausible values"
    STILL_NEEDED = "every earlier effect, after another one was accepted"
    PAIR = "two effects that were accepted in one step, in the place of one or none"
    END = "every effect in the model, at the end of the search"
    VERDICT = "all effects in the model together, at the end"
    ALTERNATIVES = "all effects in the model together, against every free-form alternative"


class Exemption(NamedTuple):
    """Another way to pass a criterion. It costs simulations, so it is tried only if nothing else failed."""

    threshold: str
    holds: Callable[[Evidence], bool]


@dataclass(frozen=True)
class Criterion:
    """One rule.

    Attributes:
        name: Name of the rule.
        stages: When it applies.
        test: What is tested, in words.
        threshold: The number, and where it comes from.
        message: Shown to users when the rule fails; ``{detail}`` is filled in from ``details``.
        reason: Why the rule exists.
        passes: The test.
        kind: What the rule asks.
        exemption: Another way to pass, None if there is none.
        details: What to fill in, one message for each.
    """

    name: str
    stages: tuple[Stage, ...]
    test: str
    threshold: str
    message: str
    reason: str
    passes: Callable[[Evidence], bool]
    kind: Kind = Kind.EVIDENCE
    exemption: Exemption | None = None
    details: Callable[[Evidence], Sequence[str]] = lambda evidence: ("",)

    def messages(self, evidence: Evidence) -> list[str]:
        """The message for each detail."""
        return [self.message.format(detail=detail) for detail in self.details(evidence)]


class CriteriaRow(NamedTuple):
    """One row of the table in plain words."""

    name: str
    test: str
    threshold: str
    message: str
    reason: str


def failures(stage: Stage, evidence: Evidence) -> tuple[str, ...]:
    """Messages of one stage's criteria that the evidence does not pass, in the table's order; empty if all pass."""
    return tuple(message for failed in failed_criteria(stage, evidence) for message in failed.messages(evidence))


def failed_criteria(stage: Stage, evidence: Evidence) -> tuple[Criterion, ...]:
    """Criteria of one stage that the evidence does not pass, in the table's order; empty if all pass."""
    failed = [criterion for criterion in CRITERIA if stage in criterion.stages and not criterion.passes(evidence)]
    final = [criterion for criterion in failed if criterion.exemption is None]
    for criterion in failed:
        if criterion.exemption is not None and (final or not criterion.exemption.holds(evidence)):
            final.append(criterion)
    return tuple(criterion for criterion in failed if criterion in final)


def criterion(name: str) -> Criterion:
    """The criterion of that name.

    Raises:
        KeyError: No criterion has that name.
    """
    return {each.name: each for each in CRITERIA}[name]


def criteria_table() -> list[CriteriaRow]:
    """The table as plain strings, for documents and pages, in the order in which failures are reported."""
    rows = []
    for each in CRITERIA:
        applies = "; ".join(stage.value for stage in each.stages)
        threshold = each.threshold + (f"; or {each.exemption.threshold}" if each.exemption is not None else "")
        message = each.message.format(detail="...")
        rows.append(CriteriaRow(each.name, f"{each.test} (applies to: {applies})", threshold, message, each.reason))
    return rows


CRITERIA: tuple[Criterion, ...] = (
    Criterion(
        name="predicts held-out data",
        stages=(Stage.CANDIDATE,),
        test="held-out log density with and without the effect, paired over blocks of time (block bootstrap)",
        threshold=f"lower bound of the gain above zero at {_SHARED_LEVEL} (Bonferroni); at {_LEVEL} where the held-out "
        f"likelihood ratio exceeds 2 log(candidates / {NAMING_LEVEL:g})",
        message="does not predict held-out data significantly better, at the level shared among all candidates",
        reason="A larger model always fits better. Only data that the fit has not seen show whether it found something "
        "that repeats, and the best of many candidates wins by chance more often than one alone.",
        passes=tests.predicts_held_out_data,
        exemption=Exemption(
            "it predicts better on the whole, shrinks the gap significantly and leaves no more than noise",
            tests.ends_the_gap,
        ),
    ),
    Criterion(
        name="strong evidence where noise is enough",
        stages=(Stage.CANDIDATE,),
        test="likelihood ratio, held out and over the whole log, where the model without the effect is adequate",
        threshold=f"2 log(candidates / {NAMING_LEVEL:g}) (Markov's inequality); over the whole log plus 2 for each "
        "parameter (Akaike)",
        message="the model without it already leaves only noise, and the log does not show the effect strongly enough",
        reason="Where nothing is left to explain, a name needs evidence that no noise model could produce.",
        passes=tests.evidence_is_strong,
    ),
    Criterion(
        name="likelihood ratio",
        stages=(Stage.CANDIDATE,),
        test="likelihood ratio over the whole log (Wilks)",
        threshold=f"chi-squared quantile of the added parameters at {_SHARED_LEVEL}",
        message="does not make the whole log likelier than its free parameters would by chance",
        reason="Held-out stretches alone can favour an effect by what the refits without it happened to do there.",
        passes=tests.likelihood_ratio,
    ),
    Criterion(
        name="gap reduction significant",
        stages=(Stage.CANDIDATE, Stage.VERDICT),
        test="reduction of held-out E^2, and of the share closed (weighted blocks)",
        threshold=f"{100.0 - 100.0 * NAMING_LEVEL:g} % interval above zero",
        message="the gap does not shrink significantly",
        reason="An effect can make the log likelier and leave the gap as it was: then it describes noise.",
        passes=tests.gap_shrinks,
    ),
    Criterion(
        name="a gap to explain",
        stages=(Stage.CANDIDATE,),
        test="gap of every channel without the effect",
        threshold=f"E^2 - 1 of one channel above {MIN_GAP:g} (MIN_GAP), above three standard deviations of white "
        "noise, and above the model's own error",
        message="no gap to explain: without it every channel is at the noise, or within the model's own error",
        reason="An effect beside which nothing was left to explain is a correction of the model, not a cause.",
        passes=tests.gap_to_explain,
        kind=Kind.SIZE,
    ),
    Criterion(
        name="beyond the model's error",
        stages=(Stage.CANDIDATE,),
        test="reduction of E^2 in every channel",
        threshold="in one channel more than the model's own error may hold (Channel.model_error), and more than three "
        "standard deviations of white noise",
        message="too small: closes less than the model's own error may hold",
        reason="No simulator is exact. What an effect closes must exceed what mesh, laws and sensors are wrong by.",
        passes=tests.exceeds_model_error,
        kind=Kind.SIZE,
    ),
    Criterion(
        name="material",
        stages=(Stage.CANDIDATE,),
        test="fitted parameters of every new effect",
        threshold="one parameter differs from neutral by the smallest amount that an engineer acts on (registry)",
        message="too small: by less than anybody would act on",
        reason="People act on a named effect.",
        passes=tests.is_material,
        kind=Kind.SIZE,
    ),
    Criterion(
        name="gap reduction relevant",
        stages=(Stage.CANDIDATE, Stage.VERDICT),
        test="share of the held-out gap that the effect closes",
        threshold=f"at least {_PERCENT} (MIN_GAP_CLOSED)",
        message=f"too small: closes less than {_PERCENT} of the gap",
        reason="In a long log a tiny change is significant. No simulator is exact, and nobody acts on so little.",
        passes=tests.closes_enough,
        kind=Kind.SIZE,
    ),
    Criterion(
        name="closes most of the gap",
        stages=(Stage.VERDICT,),
        test="E^2 - 1 that calibration leaves, with and without all named effects",
        threshold=f"at least {100.0 * MIN_SHARE_OF_CAUSE:g} % closed (MIN_SHARE_OF_CAUSE)",
        message="leaves more of the gap than it closes",
        reason="A law that acts at the right place but in another way closes part of a gap. Its name would be wrong.",
        passes=tests.closes_most,
        kind=Kind.SIZE,
    ),
    Criterion(
        name="most channels no worse",
        stages=(Stage.VERDICT,),
        test="E of every channel, with and without all named effects",
        threshold="worse, by more than three standard deviations of white noise, in fewer than half of the channels",
        message="half of the channels or more are further off with it",
        reason="A cause brings the simulation nearer to the log. What trades one channel for another is none.",
        passes=tests.most_channels_hold,
    ),
    Criterion(
        name="sign and size physical",
        stages=(Stage.CANDIDATE,),
        test="fitted amplitude of every new effect",
        threshold="the physical range that the catalogue gives",
        message="its fitted value is not physical: it would be {detail}",
        reason="With the wrong sign an effect is another cause than its name says.",
        passes=lambda evidence: not tests.nonphysical(evidence),
        kind=Kind.MEANING,
        details=tests.nonphysical,
    ),
    Criterion(
        name="relevant after calibration",
        stages=(Stage.CANDIDATE,),
        test="share that the effect closes of the gap left after calibration, where the model without it is adequate",
        threshold=f"at least {_PERCENT} (MIN_GAP_CLOSED)",
        message=f"too small: closes less than {_PERCENT} of the gap left after calibration",
        reason="Where the model is adequate already, a large share of what remains can be next to nothing.",
        passes=tests.closes_enough_of_calibrated_gap,
        kind=Kind.SIZE,
        exemption=Exemption(
            "with it the gap is negligible and no effect is visible in the residuals", tests.nothing_left_to_find
        ),
    ),
    Criterion(
        name="gap reduction significant in other runs",
        stages=(Stage.OTHER_RUNS,),
        test="reduction of the gap of each run under a fit to the other runs",
        threshold=f"{100.0 - 100.0 * NAMING_LEVEL:g} % interval above zero",
        message="in runs that its fit has not seen, the gap does not shrink significantly",
        reason="Another excitation separates causes that more of the same cannot: a near relative of the cause fails.",
        passes=tests.gap_of_other_runs_shrinks,
    ),
    Criterion(
        name="gap reduction relevant in other runs",
        stages=(Stage.OTHER_RUNS,),
        test="share that the effect closes of the gap of each run under a fit to the other runs",
        threshold=f"at least {_PERCENT} (MIN_GAP_CLOSED)",
        message=f"in runs that its fit has not seen, it closes less than {_PERCENT} of the gap",
        reason="As in the runs that were fitted: nobody acts on so little.",
        passes=tests.closes_enough_in_other_runs,
        kind=Kind.SIZE,
    ),
    Criterion(
        name="no free form of a known effect",
        stages=(Stage.SECOND_EFFECT,),
        test="held-out log density against the free forms of the effects already in the model (block bootstrap)",
        threshold=f"lower bound of the gain above zero at {_LEVEL} divided by the number of free forms",
        message="a free form of an effect already in the model fits as well: {detail}",
        reason="A cause that differs a little from the catalogue's law leaves a residual that some other effect fits.",
        passes=tests.predicts_better_than_free_forms,
        details=lambda evidence: [evidence.free_forms[0].description],
    ),
    Criterion(
        name="plausible calibration",
        stages=(Stage.PLAUSIBLE_CALIBRATION,),
        test="distance of the calibrated parameters from the model as given, with the effect",
        threshold=f"at most {NUISANCE_LIMIT:g} standard deviations of their priors",
        message="beside it, calibration still needs implausible values",
        reason="An effect that replaces an implausible calibration must make it plausible.",
        passes=lambda evidence: not outside_prior(evidence.fitted),
    ),
    Criterion(
        name="supported without priors",
        stages=(Stage.REPLACES_CALIBRATION,),
        test="likelihood ratio against the implausible calibration, without priors, and held-out log density",
        threshold=f"chi-squared quantile of the added parameters at {_SHARED_LEVEL}; held-out deviance no larger",
        message="the log alone does not prefer it to an implausible calibration",
        reason="Otherwise only the prior of the calibration speaks for the effect. It is reported as suspected.",
        passes=tests.log_supports_it_without_prior,
    ),
    Criterion(
        name="still needed",
        stages=(Stage.STILL_NEEDED,),
        test="the model with the effect against a refit without it: likelihood ratio, and gap or held-out log density",
        threshold=f"chi-squared quantile at {_LEVEL}, and either the gap grows significantly and by "
        f"{_PERCENT} without it, or held-out data are predicted better with it",
        message="no longer needed beside the other effects",
        reason="A later effect can explain what an earlier one was accepted for.",
        passes=tests.still_needed,
    ),
    Criterion(
        name="pair ends the gap",
        stages=(Stage.PAIR,),
        test="adequacy of the model with both effects, each of them needed",
        threshold="within the null thresholds, without structure in the residuals",
        message="the two effects together leave more than noise",
        reason="Among so many pairs some wrong one shrinks most gaps.",
        passes=lambda evidence: evidence.state.adequacy.adequate and len(evidence.fitted.effects) >= 2,
    ),
    Criterion(
        name="more than none",
        stages=(Stage.END,),
        test="90 % interval of the effect's size, twice as wide as the fit's own: as answers scatter; or a refit "
        "without it",
        threshold="leaves out none; or the refit is worse than by chance at 10 %, each channel of a run counting as "
        f"{INDEPENDENT_ERRORS} numbers; effects that show only together (HasCoupledEffects) need not",
        message="beside the others its size is not significantly different from zero",
        reason="An effect can fit what the model's own error leaves. Its size is then not determined.",
        passes=tests.differs_from_none,
    ),
    Criterion(
        name="certainly material",
        stages=(Stage.END,),
        test="90 % interval of the effect's size, where calibration alone leaves no gap",
        threshold="leaves out what nobody acts on (registry)",
        message="calibration is enough, and its size may be one that nobody would act on",
        reason="What any system wanders by can look like a small effect. Without a gap a name must surely matter.",
        passes=tests.certainly_material,
        kind=Kind.SIZE,
    ),
    Criterion(
        name="no free form predicts better",
        stages=(Stage.ALTERNATIVES,),
        test="held-out log density of every free-form alternative against the named effects (block bootstrap)",
        threshold=f"gain not above zero at {_LEVEL} divided by the number of alternatives",
        message="a free-form alternative predicts held-out data significantly better",
        reason="What a law cannot follow and a free form can is not that law's cause.",
        passes=tests.no_free_form_predicts_better,
    ),
    Criterion(
        name="no free form at another site is likelier",
        stages=(Stage.ALTERNATIVES,),
        test="held-out deviance and gap of every free-form alternative at another site",
        threshold=f"gain of held-out deviance not above the chi-squared quantile at {_LEVEL} divided by "
        "their number, or a gap no smaller",
        message="a free-form alternative at another site is likelier",
        reason="An effect is no cause unless it predicts more than a disturbance elsewhere; this need not be "
        "significant.",
        passes=tests.no_form_elsewhere_is_likelier,
    ),
)
