"""A diagnosis of further logs starts from the answer to the earlier ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.diagnosis.catalogue import of_run
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer
from slider_drilling.gap.model import Effect, Values

# Share of a parameter's range by which a start keeps away from its bounds.
_MARGIN = 0.01


def calibration_start(answer: EarlierAnswer, logs: Sequence[str]) -> dict[str, float]:
    """Where calibration starts: the values of the answer without its effects.

    Args:
        answer: The earlier answer.
        logs: Names of the logs that are diagnosed now. What belongs to single runs is kept where the earlier logs come
            first, in their order.
    """
    if not answer.explanations:
        return {}
    same_runs = tuple(logs[: len(answer.logs)]) == answer.logs
    fitted = answer.explanations[0].fitted
    return {
        name: value for name, value in fitted.items() if "." not in name and (same_runs or "@" not in name)
    }  # fmt: skip


def with_earlier_starts(effects: Sequence[Effect], answer: EarlierAnswer) -> list[Effect]:
    """The effects; those that an explanation has fitted are looked for at its values first."""
    return [_with_starts(effect, answer) for effect in effects]


def _with_starts(effect: Effect, answer: EarlierAnswer) -> Effect:
    points = []
    for explanation in answer.explanations:
        if effect.name in explanation.effects:
            points.append(_point(effect, explanation.fitted))
    amplitude = effect.parameters[0]
    new = [point for point in points if point not in effect.scan and point[0] != amplitude.nominal]
    return replace(effect, scan=(*new, *effect.scan)) if new else effect


def _point(effect: Effect, fitted: Values) -> tuple[float, ...]:
    """The fitted values, inside the bounds; a later run starts from the first one's where it has none."""
    first, point = of_run(fitted, 0), []
    for parameter in effect.parameters:
        value = fitted.get(parameter.name, first.get(parameter.name.partition("#")[0], parameter.nominal))
        margin = _MARGIN * (parameter.upper - parameter.lower)
        point.append(min(max(value, parameter.lower + margin), parameter.upper - margin))
    return tuple(point)
