"""Expected information of a run: detectable size of every effect, and how far the explanations differ under it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, log

import numpy as np

from slider_drilling.gap.experiment_design.detectable_size import (
    DetectableSize,
    ProbedShape,
    detectable_size,
    noncentrality_needed,
)
from slider_drilling.gap.experiment_design.information import Change, Information, run_information
from slider_drilling.gap.experiment_design.knowledge import Knowledge
from slider_drilling.gap.model import Channel, Manoeuvre
from slider_drilling.gap.problem.model_error import with_model_error
from slider_drilling.gap.problem.problem import build_problem

# Suffix of what belongs to the planned run alone.
NEXT_RUN = "next"
# Largest ratio of a detectable size to the size that matters that still counts.
_WORST_RATIO = 100.0
# Weight of alternative explanations against that of effects that have not shown.
_ALTERNATIVES = 2.0


@dataclass(frozen=True)
class EffectPower:
    """How well one effect would show: its shape of median detectable size.

    Attributes:
        name: Its name.
        shape: The shape.
        size: Its detectable size.
        ratio: That size over the smallest one that an engineer acts on, or over its smallest scan point where any size
            counts.
    """

    name: str
    shape: ProbedShape = field(repr=False)
    size: DetectableSize
    ratio: float


@dataclass(frozen=True)
class Separation:
    """How far two explanations differ.

    Attributes:
        first, second: Their names.
        weight: Product of their probabilities, over all pairs.
        log_likelihood_ratio: Expected, if one of them is the truth and the other is calibrated to follow.
    """

    first: str
    second: str
    weight: float
    log_likelihood_ratio: float


@dataclass(frozen=True)
class Prospect:
    """What is known after a run, if it goes as planned.

    Attributes:
        effects: Every effect that may still show.
        separations: Every two explanations of the logs so far.
        loss: What is left to find out: the smaller, the better the run.
    """

    effects: tuple[EffectPower, ...]
    separations: tuple[Separation, ...]
    loss: float

    def least(self) -> EffectPower | None:
        """The effect that shows least."""
        return max(self.effects, key=lambda each: each.ratio, default=None)


def planned_information(knowledge: Knowledge, manoeuvre: Manoeuvre, shapes: Sequence[ProbedShape]) -> Information:
    """What a planned run would tell beside the logs so far, with the changes of these shapes and of explanations."""
    changes = [change for shape in shapes for change in shape.changes(knowledge.values)]
    changes += [
        Change(explanation.change, explanation.values, explanation.fidelity) for explanation in knowledge.explanations
    ]
    model = manoeuvre.model
    noise = {
        channel.name: knowledge.noise.get(channel.name) or _declared_noise(channel)
        for channel in model.runs[0].channels
    }
    problem = with_model_error(build_problem(model, [noise]), knowledge.model_error)
    of_run = run_information(problem, knowledge.values, knowledge.parameters, changes, NEXT_RUN)
    return of_run if knowledge.information is None else knowledge.information + of_run


def _declared_noise(channel: Channel) -> float:
    """Noise of a channel that no log shows yet; the step of its readings counts as noise."""
    noise = float(np.hypot(channel.declared_noise or 0.0, channel.resolution / np.sqrt(12.0)))
    if noise == 0.0:
        raise ValueError(f"channel {channel.name}: no noise is declared, and no log shows it")
    return noise


def prospect(knowledge: Knowledge, information: Information, shapes: Sequence[ProbedShape]) -> Prospect:
    """What is known with this information.

    Args:
        knowledge: What is known so far.
        information: Of the logs and the planned run.
        shapes: Shapes of the effects whose changes the information holds.
    """
    schur, power = information.beyond_free()
    place = {name: index for index, name in enumerate(information.changes)}
    by_effect: dict[str, list[EffectPower]] = {}
    for shape in shapes:
        at = [place[shape.name(point)] for point in shape.points]
        own = {name: values[at] for name, values in power.items()}
        material = knowledge.material(shape)
        size = detectable_size(shape, np.diag(schur)[at], own, information, knowledge.candidates, material)
        scale = material if 0.0 < material < inf else size.reference
        by_effect.setdefault(shape.effect.name, []).append(
            EffectPower(shape.effect.name, shape, size, size.amplitude / scale)
        )
    effects = tuple(sorted(own, key=lambda each: each.ratio)[len(own) // 2] for own in by_effect.values())
    separations = _separations(knowledge, schur, place)
    return Prospect(effects, separations, _loss(effects, separations, knowledge.candidates))


def _separations(knowledge: Knowledge, schur: np.ndarray, place: dict[str, int]) -> tuple[Separation, ...]:
    explanations, found = knowledge.explanations, []
    for index, first in enumerate(explanations):
        for second in explanations[index + 1 :]:
            i, j = place[first.change], place[second.change]
            square = max(float(schur[i, i] + schur[j, j] - 2.0 * schur[i, j]), 0.0)
            found.append(Separation(first.name, second.name, first.weight * second.weight, 0.5 * square))
    total = sum(each.weight for each in found) or 1.0
    return tuple(Separation(each.first, each.second, each.weight / total, each.log_likelihood_ratio) for each in found)


def _loss(effects: Sequence[EffectPower], separations: Sequence[Separation], candidates: int) -> float:
    """Squares weigh the least sensitive effect most; what shows at the size that matters counts no more."""
    ratios = [min(max(log(each.ratio), 0.0), log(_WORST_RATIO)) if each.ratio > 0.0 else 0.0 for each in effects]
    hidden = float(np.mean(np.square(ratios))) if ratios else 0.0
    enough = 0.5 * noncentrality_needed(1, candidates)
    confused = sum(each.weight * max(1.0 - each.log_likelihood_ratio / enough, 0.0) for each in separations)
    return hidden + _ALTERNATIVES * confused
