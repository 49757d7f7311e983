"""The verdict: whether what was named is a cause or only resembles one, or whether nothing known explains the gap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.evidence.compare import (
    NAMING_LEVEL,
    chi2_critical,
    gap_reduction_significant,
    predicts_better,
    predicts_better_among,
    resampled_squared_gaps,
)
from slider_drilling.gap.evidence.free_form_fit import FreeFormFit
from slider_drilling.gap.evidence.free_forms import fit_free_forms
from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.model import HasFreeForms
from slider_drilling.gap.search.least_squares import min_gain_to_catch_up
from slider_drilling.gap.selection.evidence_tests import Evidence, gap_reduction_relevant
from slider_drilling.gap.selection.naming_criteria import Stage, failures
from slider_drilling.gap.selection.refit import check_adequacy
from slider_drilling.gap.selection.state import FittedModel, SearchState


@dataclass(frozen=True)
class Decision:
    """The verdict on a state.

    Attributes:
        verdict: ``none``, ``parameters``, ``effect``, ``effect_and_unknown`` or ``unknown``.
        site: Site of the first effect, or where an unknown cause most likely lies; None without either.
        effects: Names of the effects that the verdict rests on.
        alternative: The free form that fits as well as these, or that shows the shape of the unknown cause.
        remainder: The free form that predicts best what remains beside the effects, if it closes enough of that.
        state: The state; calibrated only, where its effects are withdrawn.
        small_cause: With ``parameters``: an effect too small to act on that explains what calibration leaves.
    """

    verdict: str
    site: str | None
    effects: tuple[str, ...]
    alternative: FreeFormFit | None
    remainder: FreeFormFit | None
    state: SearchState = field(repr=False)
    small_cause: str | None = None


def reach_verdict(state: SearchState) -> Decision:
    """The verdict that a state supports, compared with every free-form alternative."""
    if state.current.effects and failures(Stage.VERDICT, Evidence(state, state.calibrated, state.current)):
        state = without_effects(state)
    adequate, effects = state.adequacy.adequate, state.current.effects
    if not effects and not adequate and (small := _small_cause(state)) is not None:
        return replace(_calibration_verdict(state), small_cause=small)
    nothing_to_compare = state.interrupted or (adequate and not effects)
    folds = state.bootstrap.folds
    forms = [] if nothing_to_compare else fit_free_forms(state.calibrated, folds, _gain_worth_finishing(state))
    evidence = Evidence(state, state.calibrated, state.current, free_forms=forms)
    if effects and failures(Stage.ALTERNATIVES, evidence):
        if state.unrestricted is not None:
            return reach_verdict(state.unrestricted)
        state = without_effects(state)
        return _calibration_verdict(state) if state.adequacy.adequate else _unknown(state, forms)
    remainder = None
    if not nothing_to_compare and not adequate:
        remainder = _structured_remainder(state, fit_free_forms(state.current, folds) if effects else forms)
    enough = adequate or (state.adequacy.within_thresholds and remainder is None)
    if not effects:
        return _calibration_verdict(state) if enough else _unknown(state, forms)
    alternative = _equally_good_form(state, forms)
    if enough and alternative is None:
        return Decision("effect", effects[0].site, state.current.names, None, None, state)
    if remainder is not None and not gap_reduction_relevant(state.current.score, remainder.score):
        # It shows that structure is left, not what it looks like.
        remainder = None
    if not state.calibrated_adequacy.adequate:
        return Decision("effect_and_unknown", effects[0].site, state.current.names, alternative, remainder, state)
    # Calibration alone leaves only noise: there is no gap that something else could close as well.
    return _calibration_verdict(without_effects(state))


def _calibration_verdict(state: SearchState) -> Decision:
    """No effect is named, and none is needed."""
    return Decision("none" if state.nominal_adequate else "parameters", None, (), None, None, state)


def _small_cause(state: SearchState) -> str | None:
    """The likeliest effect that fails by its size alone, and beside which nothing is left: no unknown is needed."""
    small = [
        candidate for step in state.steps for candidate in step.candidates
        if candidate.too_small and not candidate.beside and _in_same_noise_units(state, candidate.fitted)
    ]  # fmt: skip
    small.sort(key=lambda candidate: candidate.fitted.score.held_out_deviance)
    return next((each.effect.name for each in small if check_adequacy(each.fitted, 0).adequate), None)


def without_effects(state: SearchState) -> SearchState:
    """The state with calibration alone, whatever was accepted."""
    return replace(state, current=state.calibrated, adequacy=state.calibrated_adequacy)


def _gain_worth_finishing(state: SearchState) -> float:
    """Gain of ``-2 log p`` from which a free form is finished in fine simulations: nearly that of the named effects.

    One parameter's gain by chance, and what the last iteration of a coarse fit may gain, are allowed for.
    """
    gain = max(state.calibrated.fit.cost - state.current.fit.cost - chi2_critical(1), 0.0)
    return max(gain - min_gain_to_catch_up(gain), 0.0)


def _equally_good_form(state: SearchState, forms: Sequence[FreeFormFit]) -> FreeFormFit | None:
    """The best free form that the named effects do not outperform, None if they outperform all.

    Compared are free forms at other sites, and those at the same site that have no more coefficients than the effects
    have parameters and are not the free form of one of them. With such a form the log does not show which is the cause.
    """
    effects = state.current.effects
    sites, parameter_count = {effect.site for effect in effects}, sum(len(effect.parameters) for effect in effects)

    def is_another_cause(form: FreeFormFit) -> bool:
        if form.site not in sites:
            return True
        return form.x.size <= parameter_count and not any(form.covers(effect) for effect in effects)

    alternatives = [form for form in forms if is_another_cause(form)]
    score = state.current.score
    critical = chi2_critical(1, max(len(alternatives), 1))

    def is_outperformed(form: FreeFormFit) -> bool:
        significant = predicts_better(state.bootstrap, score, form.score, len(alternatives))
        return significant and form.score.held_out_deviance - score.held_out_deviance > critical

    return next((form for form in alternatives if not is_outperformed(form)), None)


def _structured_remainder(state: SearchState, forms: Sequence[FreeFormFit]) -> FreeFormFit | None:
    """The free form that predicts best what the final model leaves.

    If none predicts significantly better, what is left within its thresholds is coloured noise, not structure.
    """
    score = state.current.score
    return next((form for form in forms if predicts_better(state.bootstrap, form.score, score, len(forms))), None)


def _unknown(state: SearchState, forms: Sequence[FreeFormFit]) -> Decision:
    """No effect is named: the likeliest site, and the shape of a free form there that predicts significantly better."""
    site = likeliest_site(state, forms)
    shapes = (form for form in forms if form.site == site and _reduces_and_predicts(state, form.score, len(forms)))
    return Decision("unknown", site, (), next(shapes, None), None, state)


@dataclass(frozen=True)
class SiteScore:
    """A law or a free form that was cross-validated, at its site.

    Attributes:
        site: Where it acts.
        score: Its held-out score.
        sensor_channel: The channel whose reading alone would be off; None where the model is.
    """

    site: str
    score: HeldOutScore
    sensor_channel: str | None = None

    @property
    def held_out_deviance(self) -> float:
        """Held-out ``-2 log p``."""
        return self.score.held_out_deviance


def likeliest_site(state: SearchState, forms: Sequence[FreeFormFit]) -> str | None:
    """The site of the best prediction of all that was tried, whether or not it may be named.

    A law that fails a criterion, and a free form, still act where something is missing. If only one channel misfits,
    the site is that sensor, unless another explanation predicts significantly better.
    """
    finalists = [candidate for step in state.steps[:1] for candidate in step.candidates]
    tried = [
        SiteScore(candidate.effect.site, candidate.fitted.score)
        for candidate in finalists if _in_same_noise_units(state, candidate.fitted)
    ]  # fmt: skip
    tried += [SiteScore(form.site, form.score, form.sensor_channel) for form in forms]
    likely = likely_explanations(state, tried)
    best = min(likely or with_smaller_gap(state, tried) or tried, key=_deviance, default=None)
    model, adequacy = state.calibrated.problem.model, state.calibrated_adequacy
    misfits = adequacy.channels_above or adequacy.channels_structured
    if len(misfits) == 1 and isinstance(model, HasFreeForms):
        of_sensor = [each for each in likely if each.sensor_channel == misfits[0]]
        sensor = min(of_sensor, key=_deviance, default=None)
        if not likely or best is None:
            return model.sensor_site(misfits[0])
        if sensor is not None and not _significantly_better(state, best.score, sensor.score, len(tried)):
            return model.sensor_site(misfits[0])
    return None if best is None else best.site


def likely_explanations(state: SearchState, tried: Sequence[SiteScore]) -> list[SiteScore]:
    """Those that reduce the gap and predict significantly better; if there are none, those that only reduce the gap.

    Of the latter, those that predict significantly worse than calibration alone are left out. The likelihood allows for
    slow discrepancies, so that a true explanation can predict no better.
    """
    significant = [each for each in tried if _reduces_and_predicts(state, each.score, len(tried))]
    calibrated = state.calibrated.score
    return significant or [
        each for each in tried
        if not predicts_better(state.bootstrap, calibrated, each.score) and _reduces_gap(state, each.score)
    ]  # fmt: skip


def with_smaller_gap(state: SearchState, tried: Sequence[SiteScore]) -> list[SiteScore]:
    """Those that predict better on the whole and leave a smaller gap than calibration alone.

    What predicts best while the gap grows describes the residuals, and is not their cause.
    """
    calibrated = state.calibrated.score
    return [
        each for each in tried
        if each.held_out_deviance < calibrated.held_out_deviance and each.score.gap < calibrated.gap
    ]  # fmt: skip


def _deviance(each: SiteScore) -> float:
    return each.held_out_deviance


def _reduces_gap(state: SearchState, score: HeldOutScore) -> bool:
    """Whether the gap that calibration leaves shrinks significantly, and by enough to name an effect."""
    calibrated = state.calibrated.score
    significant = gap_reduction_significant(state.bootstrap, calibrated, score)
    return significant and gap_reduction_relevant(calibrated, score)


def _reduces_and_predicts(state: SearchState, score: HeldOutScore, tried: int) -> bool:
    """Whether one of so many that were tried reduces the gap, and predicts better than calibration alone."""
    better = predicts_better_among(state.bootstrap, score, state.calibrated.score, tried)
    return better and _reduces_gap(state, score)


def _significantly_better(state: SearchState, score: HeldOutScore, other: HeldOutScore, tried: int) -> bool:
    """Whether one of so many that were tried predicts better than another, or as well with a smaller gap.

    The likelihood allows for slow discrepancies, the gap does not.
    """
    if predicts_better_among(state.bootstrap, score, other, tried):
        return True
    reduction = resampled_squared_gaps(state.bootstrap, other) - resampled_squared_gaps(state.bootstrap, score)
    shrinks = float(np.quantile(reduction, NAMING_LEVEL / tried)) > 0.0
    return score.held_out_deviance <= other.held_out_deviance and shrinks


def _in_same_noise_units(state: SearchState, model: FittedModel) -> bool:
    """Whether a model was scored with the noise floors that the state has now; else densities cannot be compared."""
    now, then = (each.problem.pieces for each in (state.calibrated, model))
    return all(mine.noise == other.noise for mine, other in zip(now, then, strict=True))
