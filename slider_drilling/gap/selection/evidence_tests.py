"""What each naming criterion tests: an effect's evidence, and the thresholds that decide.

`naming_criteria` says when each test applies, and what users read when it fails.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import comb

import numpy as np

from slider_drilling.gap.evidence.compare import (
    NAMING_LEVEL,
    chi2_critical,
    exceeds_evidence_threshold,
    fit_exceeds_evidence_threshold,
    gap_reduction_significant,
    passes_likelihood_ratio_test,
    predicts_better,
    predicts_better_among,
    resampled_squared_gaps,
    share_closed,
)
from slider_drilling.gap.evidence.free_form_fit import FreeFormFit
from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.model import Effect, HasCoupledEffects
from slider_drilling.gap.problem.model_error import INDEPENDENT_ERRORS, model_error_budget, model_error_size
from slider_drilling.gap.problem.problem import Piece
from slider_drilling.gap.results.intervals import (
    ONE_SIDED_95,
    SPREAD_OF_ANSWERS,
    parameter_intervals,
    user_parameters,
    user_values,
)
from slider_drilling.gap.search.least_squares import Fit
from slider_drilling.gap.selection.refit import check_adequacy
from slider_drilling.gap.selection.state import FittedModel, SearchState

# Smallest share of the gap that an effect must close to be named. Below it, other codes for the same equations differ
# by as much, and nobody would change a model for it.
MIN_GAP_CLOSED = 0.05
# Smallest E^2 - 1 of a channel that is a gap to explain: E of 1.1. White noise of a few hundred samples leaves less.
MIN_GAP = 0.2
# Smallest share of the calibrated gap beyond the noise, E^2 - 1, that all named effects close together. A law that
# leaves more than it closes is not the cause, but something like it.
MIN_SHARE_OF_CAUSE = 0.5
# By chance a refit is worse by so much so often: as often as none lies outside a 90 % interval.
_NONE_LEVEL = 0.1


@dataclass(frozen=True)
class Evidence:
    """A model with an effect beside the same model without it: what the criteria look at.

    Attributes:
        state: State of the search. Its adequacy is that of the model without the effect, except at the stages that
            follow an acceptance (`Stage.PAIR`, `Stage.VERDICT`, `Stage.ALTERNATIVES`).
        without: Fitted model without the effect.
        fitted: Fitted model with it.
        remaining: Effects that the candidates were chosen from.
        seed: Seed of the replicates.
        free_forms: Free-form alternatives to compare with, best first.
    """

    state: SearchState
    without: FittedModel
    fitted: FittedModel
    remaining: Sequence[Effect] = ()
    seed: int = 0
    free_forms: Sequence[FreeFormFit] = ()

    @property
    def new_effects(self) -> list[Effect]:
        """Effects that the model without does not have."""
        return [effect for effect in self.fitted.effects if effect.name not in self.without.names]

    @property
    def candidates(self) -> int:
        """Number of sets of effects that share the level of a test (Bonferroni).

        Conditional nuisance is not chosen among the effects: all of it together is one set.
        """
        known, count = {effect.name for effect in self.remaining}, len(self.remaining)
        chosen = sum(effect.name in known for effect in self.new_effects)
        return max(count, comb(count, chosen))


def gap_reduction_relevant(before: HeldOutScore, after: HeldOutScore) -> bool:
    """Whether at least `MIN_GAP_CLOSED` of the gap before is closed after; true where there is no gap to close."""
    return not share_closed(before.gap**2, after.gap**2) < MIN_GAP_CLOSED


def predicts_held_out_data(evidence: Evidence) -> bool:
    with_it, without = evidence.fitted.score, evidence.without.score
    return predicts_better_among(evidence.state.bootstrap, with_it, without, evidence.candidates)


def ends_the_gap(evidence: Evidence) -> bool:
    """Whether an effect predicts better on the whole, shrinks the gap significantly, and leaves only noise.

    The likelihood allows for slow discrepancies. A slow effect therefore gains little in every stretch, and one event
    can outweigh it, while the gap shows it. Many a wrong law shrinks a gap: only one that ends it qualifies. What shows
    once in a log is missing from a third of all resamples: then the evidence must exceed its threshold, and nothing may
    be left.
    """
    state, with_it, without = evidence.state, evidence.fitted.score, evidence.without.score
    if state.adequacy.within_thresholds or with_it.held_out_deviance >= without.held_out_deviance:
        return False
    reduction = resampled_squared_gaps(state.bootstrap, without) - resampled_squared_gaps(state.bootstrap, with_it)
    everywhere = float(np.quantile(reduction, NAMING_LEVEL / evidence.candidates)) > 0.0
    if not everywhere and not exceeds_evidence_threshold(with_it, without, evidence.candidates):
        return False
    left = check_adequacy(evidence.fitted, evidence.seed)
    return left.within_thresholds if everywhere else left.adequate


def evidence_is_strong(evidence: Evidence) -> bool:
    if not evidence.state.adequacy.adequate:
        return True
    held_out = exceeds_evidence_threshold(evidence.fitted.score, evidence.without.score, evidence.candidates)
    return held_out and fit_exceeds_evidence_threshold(evidence.fitted.fit, evidence.without.fit, evidence.candidates)


def likelihood_ratio(evidence: Evidence) -> bool:
    return passes_likelihood_ratio_test(evidence.without.fit, evidence.fitted.fit, evidence.candidates)


def gap_shrinks(evidence: Evidence) -> bool:
    return gap_reduction_significant(evidence.state.bootstrap, evidence.without.score, evidence.fitted.score)


def closes_enough(evidence: Evidence) -> bool:
    return gap_reduction_relevant(evidence.without.score, evidence.fitted.score)


def _uncertainty_of_squared_gaps(model: FittedModel) -> dict[str, float]:
    """By channel, how far E^2 of white noise strays from 1: three standard deviations for its number of samples."""
    counts: dict[str, int] = {}
    for piece in model.problem.pieces:
        counts[piece.name] = counts.get(piece.name, 0) + piece.channel.time.size
    return {name: 3.0 * float(np.sqrt(2.0 / count)) for name, count in counts.items()}


def gap_to_explain(evidence: Evidence) -> bool:
    problem, fitted = evidence.without.problem, evidence.without.fit
    budget, chance = model_error_budget(problem, fitted), _uncertainty_of_squared_gaps(evidence.without)
    before = evidence.without.score.by_channel
    return any(gap**2 - 1.0 > max(MIN_GAP, budget[name], chance[name]) for name, gap in before.items())


def exceeds_model_error(evidence: Evidence) -> bool:
    problem, fitted = evidence.without.problem, evidence.without.fit
    budget, chance = model_error_budget(problem, fitted), _uncertainty_of_squared_gaps(evidence.without)
    before, after = evidence.without.score.by_channel, evidence.fitted.score.by_channel
    return any(before[name] ** 2 - after[name] ** 2 > max(budget[name], chance[name]) for name in before)


def most_channels_hold(evidence: Evidence) -> bool:
    """Whether fewer than half of the channels are further off with the effects than without, beyond white noise."""
    chance = _uncertainty_of_squared_gaps(evidence.without)
    before, after = evidence.without.score.by_channel, evidence.fitted.score.by_channel
    worse = [name for name in before if after[name] ** 2 - before[name] ** 2 > chance[name]]
    return 2 * len(worse) < len(before)


def is_material(evidence: Evidence) -> bool:
    problem, values = evidence.fitted.problem, evidence.fitted.fit.values
    fitted = user_values(problem, values)
    for effect in evidence.new_effects:
        own = {parameter.name: parameter.nominal for parameter in effect.parameters}
        if not effect.is_material(user_values(problem, values | own), fitted):
            return False
    return True


def differs_from_none(evidence: Evidence) -> bool:
    """Whether the interval of each new effect's size leaves out none, or a fit without it is clearly worse.

    The interval comes from the curvature at the fit, and is as wide as answers scatter. Where a law is not linear, or
    acts almost as another does, it says less than a fit without the effect.
    """
    sizes = _sizes_beyond(
        evidence, lambda effect: dict.fromkeys(effect.material or [effect.parameters[0].name], 0.0), SPREAD_OF_ANSWERS
    )
    added = len(evidence.fitted.fit.parameters) - len(evidence.without.fit.parameters)
    return sizes or _gain_of_independent_errors(evidence) > chi2_critical(added, level=_NONE_LEVEL)


def _gain_of_independent_errors(evidence: Evidence) -> float:
    """Gain of ``-2 log p`` by the effect, where each channel of a run holds `INDEPENDENT_ERRORS` numbers.

    That is ``m log(before / after)`` of m numbers whose variance is not known, with what the channel leaves, noise and
    the model's error in it. What accumulates is left out: its steps are no such numbers.
    """
    gain = 0.0
    for piece in evidence.fitted.problem.pieces:
        if piece.channel.accumulates:
            continue
        before, after = (_variance_left(piece, model.fit) for model in (evidence.without, evidence.fitted))
        gain += min(piece.channel.time.size, INDEPENDENT_ERRORS) * float(np.log(before / after))
    return gain


def _variance_left(piece: Piece, found: Fit) -> float:
    """Mean square, noise units squared, that a fit leaves in one channel of one run, with the model's error budget."""
    left = max(float(np.mean(found.residual[piece.rows] ** 2)), 1.0)
    return left + model_error_size(piece, found.simulated) ** 2


def certainly_material(evidence: Evidence) -> bool:
    """Whether the interval of each new effect's size leaves out what nobody acts on, where calibration is enough."""
    if not evidence.state.calibrated_adequacy.within_thresholds:
        return True
    return _sizes_beyond(evidence, lambda effect: effect.material)


def _sizes_beyond(
    evidence: Evidence, least: Callable[[Effect], Mapping[str, float]], spread: float = 1.0
) -> bool:
    """Whether a size of each new effect is beyond the least one, by its interval; coupled effects may not be.

    Args:
        evidence: The model with the effects.
        least: Of an effect, how far from none its sizes must be, by parameter; true if there are no such sizes.
        spread: How many times as wide as the fit's the intervals are.
    """
    problem, found = evidence.fitted.problem, evidence.fitted.fit
    together = problem.model.coupled_effects if isinstance(problem.model, HasCoupledEffects) else ()
    intervals = parameter_intervals(problem, found, spread * ONE_SIDED_95)
    parameters = user_parameters(problem, found)

    def away(name: str) -> float:
        (low, high), none = intervals[name], parameters[name].nominal
        return max(low - none, none - high)

    def is_beyond(effect: Effect) -> bool:
        sizes = least(effect)
        return not sizes or any(away(name) > size for name, size in sizes.items() if name in intervals)

    return all(effect.name in together or is_beyond(effect) for effect in evidence.new_effects)


def closes_most(evidence: Evidence) -> bool:
    """Whether less is left of the calibrated gap beyond the noise than is closed; true where there is none."""
    before = evidence.without.score.gap**2 - 1.0
    after = max(evidence.fitted.score.gap**2 - 1.0, 0.0)
    return before <= 0.0 or after <= (1.0 - MIN_SHARE_OF_CAUSE) * before


def nonphysical(evidence: Evidence) -> list[str]:
    values = evidence.fitted.fit.values
    return [effect.nonphysical for effect in evidence.new_effects if not effect.is_physical(values)]


def closes_enough_of_calibrated_gap(evidence: Evidence) -> bool:
    state = evidence.state
    if not state.adequacy.adequate:
        return True
    reduction = evidence.without.score.gap**2 - evidence.fitted.score.gap**2
    return reduction >= MIN_GAP_CLOSED * (state.calibrated.score.gap**2 - 1.0)


def nothing_left_to_find(evidence: Evidence) -> bool:
    return check_adequacy(evidence.fitted, evidence.seed, evidence.remaining).complete


def gap_of_other_runs_shrinks(evidence: Evidence) -> bool:
    before, after = evidence.without.cross_run_score, evidence.fitted.cross_run_score
    return gap_reduction_significant(evidence.state.bootstrap, before, after)


def closes_enough_in_other_runs(evidence: Evidence) -> bool:
    return gap_reduction_relevant(evidence.without.cross_run_score, evidence.fitted.cross_run_score)


def predicts_better_than_free_forms(evidence: Evidence) -> bool:
    forms = evidence.free_forms
    return not forms or predicts_better(evidence.state.bootstrap, evidence.fitted.score, forms[0].score, len(forms))


def log_supports_it_without_prior(evidence: Evidence) -> bool:
    """Whether the log alone, whatever the priors say, prefers the effect to the implausible calibration."""
    without, fitted = (each.problem.cost(each.fit.residual)[0] for each in (evidence.without, evidence.fitted))
    added = len(evidence.fitted.fit.parameters) - len(evidence.without.fit.parameters)
    predicts = evidence.fitted.score.held_out_deviance <= evidence.without.score.held_out_deviance
    return predicts and without - fitted > chi2_critical(added, len(evidence.remaining))


def still_needed(evidence: Evidence) -> bool:
    shrinks = gap_shrinks(evidence) and closes_enough(evidence)
    better = shrinks or predicts_better(evidence.state.bootstrap, evidence.fitted.score, evidence.without.score)
    return better and passes_likelihood_ratio_test(evidence.without.fit, evidence.fitted.fit)


def no_free_form_predicts_better(evidence: Evidence) -> bool:
    """Whether no free form predicts better, leaving out those of the named effects where these leave only noise.

    There a free form of a named effect only says that the cause is not quite the catalogue's law.
    """
    named = evidence.fitted.effects if evidence.state.adequacy.adequate else ()
    alternatives = [form for form in evidence.free_forms if not any(form.covers(effect) for effect in named)]
    count = len(evidence.free_forms)
    score = evidence.fitted.score
    return not any(predicts_better(evidence.state.bootstrap, form.score, score, count) for form in alternatives)


def no_form_elsewhere_is_likelier(evidence: Evidence) -> bool:
    sites = {effect.site for effect in evidence.fitted.effects}
    elsewhere = [form for form in evidence.free_forms if form.site not in sites]
    score = evidence.fitted.score
    return not any(
        score.held_out_deviance - form.score.held_out_deviance > chi2_critical(1, len(elsewhere))
        and form.score.gap < score.gap
        for form in elsewhere
    )
