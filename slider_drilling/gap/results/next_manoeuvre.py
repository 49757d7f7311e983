"""The run to ask for next, with every verdict that leaves something open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from slider_drilling.gap.experiment_design.criterion import Prospect, Separation
from slider_drilling.gap.experiment_design.knowledge import after_logs, before_any_log
from slider_drilling.gap.experiment_design.plan import TestPlan, plan_run
from slider_drilling.gap.model import Effect, HasProgrammes, Manoeuvre, Model
from slider_drilling.gap.selection.nuisance_limits import outside_prior
from slider_drilling.gap.selection.state import SearchState
from slider_drilling.plain_names import plain_name

# Programmes that are compared: a full plan compares more (`plan-test`).
_EVALUATIONS = 24


@dataclass(frozen=True)
class RecommendedManoeuvre:
    """The recommended run.

    Attributes:
        reason: What the logs so far leave open, in words.
        manoeuvre: What to do.
        separates: Names of the two explanations that it distinguishes best by their weight; empty where it looks for
            effects that have not shown.
        log_likelihood_ratio: Expected between these two under it, 0 without two.
        detectable: By effect that may still show, the smallest size that is named in 9 of 10 cases: after the logs so
            far, and after this run, in the unit of its amplitude.
    """

    reason: str
    manoeuvre: Manoeuvre
    separates: tuple[str, ...]
    log_likelihood_ratio: float
    detectable: dict[str, tuple[float, float]]


def recommend_manoeuvre(
    state: SearchState, reason: str, effects: Sequence[Effect], seed: int = 0
) -> RecommendedManoeuvre | None:
    """Plan the next run.

    Args:
        state: The last state of the search.
        reason: What it leaves open, see `what_is_open`; nothing if empty.
        effects: The candidate effects of the search.
        seed: Of the plan.

    Returns:
        The run; None if nothing is open, or the model offers no programmes.

    Raises:
        ValueError: No programme stays within the limits.
    """
    model = state.current.problem.model
    if not reason or not isinstance(model, HasProgrammes):
        return None
    programmes = model.programmes(model.programme_duration)
    plan = plan_run(after_logs(state, effects), programmes, evaluations=_EVALUATIONS, seed=seed, compare=False)
    return recommendation(plan, reason)


def recommend_first_run(model: Model, reason: str, seed: int = 0) -> RecommendedManoeuvre | None:
    """Plan a run where the logs so far tell nothing; None if the model offers no programmes.

    Args:
        model: The model; its logs are not used.
        reason: Why they tell nothing.
        seed: Of the plan.

    Raises:
        ValueError: No programme stays within the limits.
    """
    if not isinstance(model, HasProgrammes):
        return None
    programmes = model.programmes(model.programme_duration)
    plan = plan_run(before_any_log(model), programmes, evaluations=_EVALUATIONS, seed=seed, compare=False)
    return recommendation(plan, reason)


def recommendation(plan: TestPlan, reason: str) -> RecommendedManoeuvre:
    """A plan as it is reported."""
    found = plan.planned.prospect
    pair = _best_separated(found.separations)
    before, after = (_sizes(prospect) for prospect in (plan.baseline, found))
    return RecommendedManoeuvre(
        reason, plan.planned.manoeuvre, () if pair is None else (pair.first, pair.second),
        0.0 if pair is None else pair.log_likelihood_ratio,
        {name: (before[name], size) for name, size in after.items()},
    )  # fmt: skip


def what_is_open(state: SearchState, verdict: str, has_alternative: bool) -> str:
    """What an answer leaves open, in words; empty for an answer that stands.

    Args:
        state: The last state of the search.
        verdict: The verdict.
        has_alternative: Whether a free form does as well as the named effects.
    """
    named = state.current.names
    grouped = [name for name in named if state.indistinguishable[name]]
    if verdict == "unknown":
        return "no known effect explains the gap"
    if grouped:
        others = ", ".join(plain_name(name) for name in state.indistinguishable[grouped[0]])
        return f"{plain_name(grouped[0])} cannot be distinguished from {others}"
    if verdict == "effect_and_unknown":
        return "something remains beside the named effects"
    if has_alternative:
        return "a free form does as well as the named effects"
    far = outside_prior(state.current)
    if far:
        parameter, value, deviations = far[0]
        name = plain_name(parameter.name)
        return f"{name} is calibrated to {value:.3g}, {deviations:.1f} standard deviations from the model as given"
    last = {each.effect.name: each for step in state.steps for each in step.candidates}
    suspected = [plain_name(name) for name, each in last.items() if each.too_small and name not in named]
    if suspected:
        return f"{', '.join(suspected)} suspected: the evidence is there, but the size is not"
    return ""


def _best_separated(separations: Sequence[Separation]) -> Separation | None:
    return max(separations, key=lambda each: each.weight * each.log_likelihood_ratio, default=None)


def _sizes(prospect: Prospect) -> dict[str, float]:
    return {each.name: each.size.amplitude for each in prospect.effects}
