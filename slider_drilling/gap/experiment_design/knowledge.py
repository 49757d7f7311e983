"""What is known before an experiment is planned: nothing but the model, or the information of the logs so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from slider_drilling.gap.experiment_design.detectable_size import ProbedShape, material_amplitude, probed_shapes
from slider_drilling.gap.experiment_design.information import Information, fitted_information
from slider_drilling.gap.model import Effect, Model, Parameter, Values
from slider_drilling.gap.problem.model_error import observed_model_error, with_model_error
from slider_drilling.gap.problem.noise import noise_floors, sigmas
from slider_drilling.gap.problem.problem import Problem, build_problem
from slider_drilling.gap.search.least_squares import Fit, fit, linearised_at_its_end
from slider_drilling.gap.search.race import parameters_of
from slider_drilling.gap.search.screen import ScanPoint, scan_changes
from slider_drilling.gap.selection.calibration import lower_floors
from slider_drilling.gap.selection.state import CandidateResult, FittedModel, SearchState

# Smallest weight of an explanation that was fitted: its law, and so its likelihood, may be a little wrong.
_MIN_WEIGHT = 0.02
_MAX_EXPLANATIONS = 5


@dataclass(frozen=True)
class Explanation:
    """One explanation of the logs so far.

    Attributes:
        effects: Names of its effects; none for calibration alone.
        weight: Its posterior probability among the explanations.
        fitted: Its fitted parameter values.
        fidelity: Of the cheapest simulation that shows it.
    """

    effects: tuple[str, ...]
    weight: float
    fitted: Values
    fidelity: int = 0

    @property
    def values(self) -> dict[str, float]:
        """Its fitted values without those of single runs."""
        return {name: value for name, value in self.fitted.items() if "@" not in name}

    @property
    def name(self) -> str:
        """Its name."""
        return " and ".join(self.effects) or "calibration alone"

    @property
    def change(self) -> str:
        """Name of the change that it makes, unlike that of any parameter."""
        return f"explained by {self.name}"


@dataclass(frozen=True)
class Knowledge:
    """What is known so far.

    Attributes:
        model: The model.
        values: Parameter values around which a run is planned, without those of single runs.
        parameters: What stays free: the calibrated parameters, and those of effects that are named already.
        effects: Effects that may still show.
        candidates: Number of candidates that share the level of a test.
        noise: By channel, the noise floor of logs so far.
        information: Of the logs so far, with the changes of the effects; None before any log.
        explanations: What explains the logs so far, likeliest first; empty before any log.
        model_error: By channel, the model's error as a share of what it moves, where logs have shown it.
    """

    model: Model
    values: Values
    parameters: tuple[Parameter, ...]
    effects: tuple[Effect, ...]
    candidates: int
    noise: Mapping[str, float]
    information: Information | None = field(default=None, repr=False)
    explanations: tuple[Explanation, ...] = ()
    model_error: Mapping[str, float] = field(default_factory=dict)
    _material: dict[tuple[object, ...], float] = field(default_factory=dict, init=False, repr=False, compare=False)

    def material(self, shape: ProbedShape) -> float:
        """Smallest amplitude of a shape that an engineer acts on (`material_amplitude`), found once."""
        key = (shape.effect.name, shape.points[0])
        if key not in self._material:
            self._material[key] = material_amplitude(self.model, shape, self.values)
        return self._material[key]

    def shapes(self, most_shapes: int | None = None, most_points: int | None = None) -> list[ProbedShape]:
        """The shapes of all effects, see `probed_shapes`."""
        return [shape for effect in self.effects for shape in probed_shapes(effect, most_shapes, most_points)]


def before_any_log(model: Model, effects: Sequence[Effect] | None = None) -> Knowledge:
    """What is known before any log: the model as given.

    Args:
        model: The model; it needs no runs.
        effects: Candidate effects; the model's catalogue by default.
    """
    candidates = tuple(model.effects if effects is None else effects)
    return Knowledge(model, {}, model.nuisance, candidates, len(candidates), {})


def after_logs(state: SearchState, effects: Sequence[Effect]) -> Knowledge:
    """What a search over logs has found out.

    Args:
        state: The last state of the search.
        effects: The candidate effects that it was given.
    """
    current = state.current
    return _after(current.problem, current.fit, current.effects, effects, explanations_of(state))


def after_fit(model: Model, explanations: Sequence[Explanation]) -> Knowledge:
    """What the logs of a model tell, where a search has explained them before.

    Args:
        model: The model with its logs.
        explanations: The explanations that the search found, the answer first.
    """
    floors = noise_floors(model.runs)
    answer = explanations[0]
    named = tuple(effect for effect in model.effects if effect.name in answer.effects)
    problem = build_problem(model, [sigmas(own) for own in floors])
    parameters = parameters_of(problem, named)
    rough = fit(problem, parameters, answer.fitted, iterations=0)
    floors = list(lower_floors(problem, rough, floors))
    problem = build_problem(model, [sigmas(own) for own in floors]).at_fidelity_of(named)
    found = linearised_at_its_end(problem, fit(problem, parameters, answer.fitted, iterations=1))
    return _after(problem, found, named, model.effects, tuple(explanations))


def _after(
    problem: Problem, found: Fit, named: Sequence[Effect], effects: Sequence[Effect],
    explanations: tuple[Explanation, ...],
) -> Knowledge:  # fmt: skip
    """What logs tell at a fit that names some of the effects."""
    names = {effect.name for effect in named}
    others = tuple(effect for effect in effects if effect.name not in names)
    own = tuple(parameter for effect in named for parameter in effect.parameters)
    values = {name: value for name, value in found.values.items() if "@" not in name}
    noise = {piece.name: piece.noise for piece in problem.pieces}
    model_error = observed_model_error(problem, found)
    problem = with_model_error(problem, model_error)
    return Knowledge(
        problem.model, values, (*problem.model.nuisance, *own), others, len(effects), noise,
        _information_of(problem, found, others), explanations, model_error,
    )  # fmt: skip


def explanations_of(state: SearchState) -> tuple[Explanation, ...]:
    """The explanations that a search has fitted, with weights by their held-out log density (Box and Hill 1967)."""
    fitted: dict[tuple[str, ...], FittedModel] = {}
    results: list[CandidateResult] = [each for step in state.steps for each in step.candidates]
    for model in (state.current, state.calibrated, *(each.fitted for each in results if _is_physical(each))):
        names = tuple(sorted(model.names))
        if names not in fitted or model.score.held_out_deviance < fitted[names].score.held_out_deviance:
            fitted[names] = model
    ordered = sorted(fitted.values(), key=lambda model: model.score.held_out_deviance)[:_MAX_EXPLANATIONS]
    behind = np.array([model.score.held_out_deviance - ordered[0].score.held_out_deviance for model in ordered])
    weights = np.maximum(np.exp(-0.5 * np.minimum(behind, 100.0)), _MIN_WEIGHT)
    weights /= weights.sum()
    return tuple(
        Explanation(
            model.names, float(weight), model.fit.values,
            max((effect.fidelity for effect in model.effects), default=0),
        )
        for model, weight in zip(ordered, weights, strict=True)
    )  # fmt: skip


def _is_physical(result: CandidateResult) -> bool:
    return all(effect.is_physical(result.fitted.fit.values) for effect in result.fitted.effects)


def _information_of(problem: Problem, found: Fit, effects: Sequence[Effect]) -> Information:
    """What the logs tell at a fit, with the changes of the scan points of these effects."""
    shapes = [shape for effect in effects for shape in probed_shapes(effect)]
    named: list[tuple[str, ScanPoint]] = [
        (shape.name(point), (shape.effect, point)) for shape in shapes for point in shape.points
    ]
    points = [point for _, point in named]
    rows = scan_changes(problem, found.values, found.simulated, points, problem.options.fidelity)
    changes = {name: row for (name, _), row in zip(named, rows, strict=True)}
    return fitted_information(problem, found.simulated, found.jacobian, found.parameters, changes)
