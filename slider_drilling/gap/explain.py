"""Entry point of the engine: from a model and its logs to a diagnosis of the gap."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

from slider_drilling.gap.evidence.compare import gap_closed
from slider_drilling.gap.evidence.free_form_fit import FreeFormFit
from slider_drilling.gap.experiment_design.knowledge import Explanation, explanations_of
from slider_drilling.gap.model import Effect, HasConditionalNuisance, HasCoupledEffects, HasObserver, Model, Values
from slider_drilling.gap.problem.noise import MAX_NOISE_RATIO, NoiseFloor, noise_floors
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.results.breakdown import GapBreakdown, break_down_gap
from slider_drilling.gap.results.free_run import FreeRunModels, best_free_runs
from slider_drilling.gap.results.next_manoeuvre import RecommendedManoeuvre, recommend_manoeuvre, what_is_open
from slider_drilling.gap.results.sentence import VerdictFigures, verdict_sentence
from slider_drilling.gap.search.multi_start import NUISANCE_LIMIT
from slider_drilling.gap.selection.calibration import calibrate
from slider_drilling.gap.selection.evidence_tests import Evidence
from slider_drilling.gap.selection.forward_selection import SearchTask, add_effect, drop_uncertain_effects
from slider_drilling.gap.selection.naming_criteria import Kind, Stage, failed_criteria
from slider_drilling.gap.selection.nuisance_limits import outside_prior
from slider_drilling.gap.selection.state import CandidateResult, FittedModel, SearchState
from slider_drilling.gap.selection.verdict import reach_verdict, without_effects
from slider_drilling.plain_names import plain_name


@dataclass(frozen=True)
class GapDiagnosis:
    """What the engine concludes. Gaps are E, not E^2, and held out where parameters were fitted.

    Attributes:
        verdict: ``none``, ``parameters``, ``effect``, ``effect_and_unknown`` or ``unknown``.
        site: Site of the first named effect, or where an unknown cause most likely lies.
        effects: Names of the effects that the verdict rests on.
        closed: Share of the calibrated gap that all named effects close, NaN without any.
        closed_interval: 95 % interval of ``closed``.
        breakdown: Where the calibrated gap lies.
        alternative: The free form that fits as well as the effects, or that shows the shape of an unknown cause.
        remainder: The free form that predicts best what remains beside the effects.
        next_manoeuvre: The run that would distinguish the leading explanations best.
        remarks: Limits of the answer, in sentences.
        runtime: Wall-clock time, s.
        state: The last state of the search.
        free_runs: The models with the parameters whose free run is best.
        small_cause: With ``parameters``: an effect too small to act on that explains what calibration leaves.
        withdrawn: Names of effects that explain the log only while a measured channel is fed back.
    """

    verdict: str
    site: str | None
    effects: tuple[str, ...]
    closed: float
    closed_interval: tuple[float, float]
    breakdown: GapBreakdown | None
    alternative: FreeFormFit | None
    remainder: FreeFormFit | None
    next_manoeuvre: RecommendedManoeuvre | None
    remarks: tuple[str, ...]
    runtime: float
    state: SearchState = field(repr=False)
    free_runs: FreeRunModels = field(repr=False)
    withdrawn: tuple[str, ...] = ()
    small_cause: str | None = None

    @property
    def fed_back(self) -> str | None:
        """The measured channel that is fed back in the runs that E counts, None for free runs."""
        model = self.state.current.problem.model
        gain = self.state.current.problem.options.observer_gain
        return model.observed_channel if gain > 0.0 and isinstance(model, HasObserver) else None

    @property
    def gap_nominal(self) -> float:
        """E of the model as given."""
        return self.state.nominal_score.gap

    @property
    def gap_calibrated(self) -> float:
        """E of the calibrated model."""
        return self.state.calibrated.score.gap

    @property
    def gap_with_effects(self) -> float:
        """E of the model with the named effects, NaN without any."""
        return self.state.current.score.gap if self.effects else float("nan")

    @property
    def null_threshold(self) -> float:
        """E up to which nothing counts as a gap (`Adequacy.threshold`)."""
        return self.state.adequacy.threshold

    @property
    def simulation_count(self) -> int:
        """How many simulations were run."""
        return self.state.current.problem.counter.count

    @property
    def parameters(self) -> dict[str, float]:
        """All fitted parameters, by name, of the model whose free run is best."""
        return dict(self.free_runs.best.fit.values)

    @property
    def sentence(self) -> str:
        """The verdict with its figures."""
        alternative, remainder = (
            "" if form is None else form.description for form in (self.alternative, self.remainder)
        )
        return verdict_sentence(VerdictFigures(
            self.verdict, self.effects, self.indistinguishable, self.site,
            self.gap_nominal, self.gap_calibrated, self.gap_with_effects, self.null_threshold,
            self.closed, self.closed_interval, alternative, remainder,
            self.masked_effects, self.misfit_channels, self.fed_back, self.small_cause,
        ))  # fmt: skip

    @property
    def misfit_channels(self) -> tuple[str, ...]:
        """Channels of which the final model leaves more than noise, or structure that noise does not have."""
        return tuple(dict.fromkeys((*self.state.adequacy.channels_above, *self.state.adequacy.channels_structured)))

    @property
    def masked_effects(self) -> tuple[str, ...]:
        """Effects, likeliest first, that an implausible calibration may stand for. None of them closes a gap."""
        return self.state.masked_effects if self.verdict == "parameters" else ()

    @property
    def indistinguishable(self) -> dict[str, tuple[str, ...]]:
        """By effect in the model: effects outside it that the log cannot distinguish from it."""
        return self.state.indistinguishable

    @property
    def explanations(self) -> tuple[Explanation, ...]:
        """What may explain the logs: the answer first, then the others by their weight."""
        found = explanations_of(self.state)
        answer = [each for each in found if set(each.effects) == set(self.state.current.names)]
        return (*answer, *(each for each in found if each not in answer))

    @property
    def suspected(self) -> tuple[CandidateResult, ...]:
        """Effects with evidence that are too small to be named, as the last step that tested each found them.

        Those that the verdict withdrew because they leave more than they close are among them.
        """
        last = {
            candidate.effect.name: candidate for step in self.state.steps for candidate in step.candidates
        }  # fmt: skip
        return tuple(
            each for each in last.values()
            if each.effect.name not in self.effects and (each.too_small or self._withdrawn_for_size(each))
        )  # fmt: skip

    def _withdrawn_for_size(self, candidate: CandidateResult) -> bool:
        if not candidate.passed or self.effects:
            return False
        evidence = Evidence(self.state, self.state.calibrated, candidate.fitted)
        failed = failed_criteria(Stage.VERDICT, evidence)
        return bool(failed) and all(each.kind is Kind.SIZE for each in failed)

    @property
    def candidates(self) -> tuple[CandidateResult, ...]:
        """Every finalist of every step once: accepted ones first, then by held-out prediction."""
        accepted = [step.accepted for step in self.state.steps if step.accepted is not None]
        seen, others = {candidate.effect.name for candidate in accepted}, []
        for candidate in chain.from_iterable(step.candidates for step in self.state.steps):
            if candidate.effect.name not in seen:
                seen.add(candidate.effect.name)
                others.append(candidate)
        return (*accepted, *others)


def explain(
    model: Model,
    *,
    seed: int = 0,
    starts: Sequence[Values] = ({},),
    effects: Sequence[Effect] | None = None,
    progress: Progress = lambda stage, share: None,
) -> GapDiagnosis:
    """Diagnose the gap between a model and the logs that it carries.

    An interrupt (Ctrl-C) after calibration gives the diagnosis so far, marked as interrupted.

    Args:
        model: The model with its logs.
        seed: Seed of resamples and replicates. The same seed gives the same diagnosis.
        starts: Nuisance values to start calibration from.
        effects: Candidate effects; the model's catalogue by default.
        progress: Called with the stage and the share done, 0 to 1.

    Returns:
        The diagnosis.

    Raises:
        ValueError: No channel can be used.
    """
    started = time.perf_counter()
    candidates = list(model.effects if effects is None else effects)
    floors = noise_floors(model.runs)
    state = calibrate(model, candidates, floors, starts, seed, progress)
    conditional = model.conditional_nuisance if isinstance(model, HasConditionalNuisance) else ()
    task = SearchTask(candidates, coupled_effect_sets(model, candidates), conditional, seed, progress)
    try:
        while not state.done:
            state = add_effect(state, task)
            found = state.missing_nuisance
            if found is not None:
                state = _calibrated_with(found, task, floors)
                left = tuple(effect for effect in task.conditional if effect not in found.effects)
                task = replace(task, conditional=left)
        state = drop_uncertain_effects(state, candidates, seed)
    except KeyboardInterrupt:
        state = replace(state, interrupted=True)
    return _conclude(state, candidates, seed, started)


def _calibrated_with(found: FittedModel, task: SearchTask, floors: Sequence[dict[str, NoiseFloor]]) -> SearchState:
    """The first state of a search in which the conditional nuisance among a model's effects is calibrated."""
    model = found.problem.model
    assert isinstance(model, HasConditionalNuisance)
    freed = [parameter for effect in found.effects if effect in task.conditional for parameter in effect.parameters]
    of_effects = {parameter.name for effect in found.effects for parameter in effect.parameters}
    left_out = of_effects - {parameter.name for parameter in freed}
    start = {name: value for name, value in found.fit.values.items() if name not in left_out}
    counter = found.problem.counter
    return calibrate(model.with_nuisance(freed), task.effects, floors, [start], task.seed, task.report, counter)


def coupled_effect_sets(model: Model, candidates: Sequence[Effect]) -> list[list[Effect]]:
    """Sets of effects that show only together, as the model says: they start together as well as alone.

    Their amplitudes stay within the physical range: beside others one could bend the other way.
    """
    if not isinstance(model, HasCoupledEffects) or not model.coupled_effects:
        return []
    chosen = [effect.within_physical_range for effect in candidates if effect.name in model.coupled_effects]
    return [chosen] if len(chosen) > 1 else []


def _conclude(state: SearchState, candidates: Sequence[Effect], seed: int, started: float) -> GapDiagnosis:
    """The diagnosis that a state supports; ``started``: time by the performance counter."""
    decision = reach_verdict(state)
    free_runs = best_free_runs(decision.state)
    withdrawn: tuple[str, ...] = ()
    if decision.effects and not free_runs.effects_close_enough:
        # What explains the log only while it is fed back is no cause that a simulator can have.
        withdrawn = decision.effects
        decision = reach_verdict(without_effects(decision.state))
        free_runs = free_runs.without_effects
    state = decision.state
    closed, interval = float("nan"), (float("nan"), float("nan"))
    if decision.effects:
        closed, interval = gap_closed(state.bootstrap, state.calibrated.score, state.current.score)
    still_open = "" if state.interrupted else what_is_open(state, decision.verdict, decision.alternative is not None)
    not_planned = []
    try:
        manoeuvre = recommend_manoeuvre(state, still_open, candidates, seed)
    except ValueError as error:
        manoeuvre, not_planned = None, [f"{still_open}, but no test can be planned: {error}"]
    return GapDiagnosis(
        verdict=decision.verdict,
        site=decision.site,
        effects=decision.effects,
        closed=closed,
        closed_interval=interval,
        breakdown=break_down_gap(state.calibrated),
        alternative=decision.alternative,
        remainder=decision.remainder,
        next_manoeuvre=manoeuvre,
        remarks=(*_noise_remarks(state), *_fit_remarks(state), *_free_run_remarks(free_runs), *not_planned),
        runtime=time.perf_counter() - started,
        state=state,
        free_runs=free_runs,
        withdrawn=withdrawn,
        small_cause=decision.small_cause,
    )


def _free_run_remarks(models: FreeRunModels) -> list[str]:
    """Where parameters are those of a free run and not those of the search."""
    given, calibrated, final = models.gaps
    remarks = []
    if models.refitted:
        effects = f", {final:.2f} with the effects" if models.final.effects else ""
        remarks.append(
            "the parameters written are those whose free run is best, not those that predict best with feedback; in "
            f"free runs E is {given:.2f} as given, {calibrated:.2f} calibrated{effects}"
        )
    if models.best is not models.final:
        remarks.append(
            f"in a free run the effects leave E {final:.2f}, calibration alone {calibrated:.2f}: the parameters "
            "written are those of calibration alone"
        )
    return remarks


def _noise_remarks(state: SearchState) -> list[str]:
    """Channels whose noise differs much from what is declared."""
    remarks = []
    for index, floors in enumerate(state.floors):
        run = f" in run {index + 1}" if len(state.floors) > 1 else ""
        for name, floor in floors.items():
            if floor.excess is not None:
                remarks.append(
                    f"{name}{run}: noise is {floor.excess:.1f} times the declared noise; what exceeds "
                    f"{MAX_NOISE_RATIO:g} times the declared noise counts as gap"
                )
            if floor.method == "declared" and floor.declared and floor.observed is not None:
                remarks.append(
                    f"{name}{run}: noise is only {floor.observed / floor.declared:.2g} times the declared noise; E is "
                    f"counted in 1/{MAX_NOISE_RATIO:g} of the declared noise, so that smaller differences do not show; "
                    "to see them, declare the true noise"
                )
    return remarks


def _fit_remarks(state: SearchState) -> list[str]:
    """Limits of the fits: folds, implausible calibration, observer, interrupt."""
    remarks = []
    missing = state.current.score.unrefitted_folds
    if missing:
        stretches = "1 held-out stretch" if missing == 1 else f"{missing} held-out stretches"
        remarks.append(f"{stretches} could not be refitted: scored by the fit to the whole log")
    for parameter, value, deviations in outside_prior(state.unrestricted.current) if state.unrestricted else ():
        remarks.append(
            f"calibration alone also fits this log, but only with {parameter.name} at {value:.3g}, {deviations:.1f} "
            f"standard deviations from the model's {parameter.nominal:.3g}; the log supports the effect more; the gap "
            f"is counted from a calibration within {NUISANCE_LIMIT:g} standard deviations"
        )
    remarks += [
        f"{parameter.name} is calibrated to {value:.3g}, {deviations:.1f} standard deviations from the model's "
        f"{parameter.nominal:.3g}: it may hide an effect that acts alike"
        for parameter, value, deviations in outside_prior(state.current)
    ]
    for parameter in (each for effect in state.current.effects for each in effect.parameters):
        value, others = state.current.fit.values[parameter.name], sorted(parameter.equivalents)
        if len(others) > 1:
            listed = ", ".join(f"{other:.4g}" for other in others)
            remarks.append(
                f"{parameter.name} = {value:.4g} {parameter.unit} cannot be distinguished from its aliases: the log is "
                f"sampled too slowly, and shows {listed} {parameter.unit} alike"
            )
    model = state.current.problem.model
    if state.current.problem.options.observer_gain > 0.0 and isinstance(model, HasObserver):
        channel = plain_name(model.observed_channel)
        remarks.append(
            f"scored with the measured {channel} fed back weakly, which predicts better: E, and errors given with it, "
            f"are those of predictions from the {channel} measured so far"
        )
    if state.interrupted:
        remarks.append("interrupted: not every effect was tried")
    return remarks
