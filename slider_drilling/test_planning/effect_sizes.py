"""The sizes of a plan in the terms of the rig file, and what a plan cannot tell."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite

from slider_drilling.effects import EFFECTS
from slider_drilling.gap.experiment_design.criterion import EffectPower, Prospect
from slider_drilling.gap.experiment_design.detectable_size import POWER, noncentrality_needed
from slider_drilling.gap.model import HasUserParameters
from slider_drilling.plain_names import plain_name
from slider_drilling.test_planning.drilling_plan import DrillingPlan
from slider_drilling.units import Quantity, Text, displayed, sentence

# An effect is listed with what a plan cannot tell if it shows only above so many times the size that matters.
OUT_OF_REACH = 2.0


@dataclass(frozen=True)
class EffectRow:
    """One effect in the table of powers.

    Attributes:
        name: Of the effect.
        parameter: The parameter in which its size is counted, by its name in the rig file.
        unit: Unit of that parameter.
        without, with_plan: Smallest value of it that is named with `POWER`; None where no value is.
        limited_by: What needs the most with the plan: evidence, size of the gap, or material.
        usual: A usual value.
        power_without, power_with: Probability that the usual value is named.
        ratio: Detectable size over the smallest one that anybody acts on.
    """

    name: str
    parameter: str
    unit: str
    without: float | None
    with_plan: float | None
    limited_by: str
    usual: float
    power_without: float
    power_with: float
    ratio: float


def effect_rows(plan: DrillingPlan) -> list[EffectRow]:
    """Every effect that may still show, the least visible first."""
    before = {each.name: each for each in plan.plan.baseline.effects}
    after = plan.plan.planned.prospect.effects
    rows = [_row(plan, before[each.name], each) for each in after]
    return sorted(rows, key=lambda row: -row.ratio)


def _row(plan: DrillingPlan, before: EffectPower, after: EffectPower) -> EffectRow:
    effect = after.shape.effect
    key = next(iter(effect.material), effect.parameters[0].name)
    definition = EFFECTS.get(effect.name)
    unit = effect.parameters[0].unit
    if definition is not None:
        section, _, name = key.partition(".")
        unit = next((p.unit for p in effect.parameters if p.name == key), _unit_in_file(section, name))
    return EffectRow(
        effect.name, key.rpartition(".")[2], unit, _value(plan, before, before.size.amplitude, key),
        _value(plan, after, after.size.amplitude, key), after.size.limited_by,
        _value(plan, after, after.size.reference, key) or 0.0, before.size.power, after.size.power, after.ratio,
    )  # fmt: skip


def _unit_in_file(effect: str, key: str) -> str:
    field = next(each for each in fields(EFFECTS[effect].section) if each.name == key)
    unit: str = field.metadata["range"].unit
    return unit


def _value(plan: DrillingPlan, power: EffectPower, distance: float, key: str) -> float | None:
    """The user's parameter at an amplitude that is so far from neutral; None if no value is far enough."""
    effect, amplitude = power.shape.effect, power.shape.effect.parameters[0]
    point = power.shape.points[0]
    sign = 1.0 if point[0] >= amplitude.nominal else -1.0
    value = amplitude.nominal + sign * distance
    if not isfinite(value) or not amplitude.lower <= value <= amplitude.upper:
        return None
    values = effect.values((value, *point[1:]))
    model = plan.plan.knowledge.model
    return float((model.to_user(values) if isinstance(model, HasUserParameters) else values)[key])


def shown_value(value: float | None, unit: str) -> Quantity | str:
    """A size for a table."""
    return "not at all" if value is None else displayed(value, unit, 2)


def cannot_tell(plan: DrillingPlan) -> list[Text]:
    """What the programme will not show, in sentences."""
    lines: list[Text] = []
    for row in effect_rows(plan):
        if row.with_plan is None:
            lines.append(sentence(f"{plain_name(row.name)}: no size of it shows."))
        elif row.ratio > OUT_OF_REACH:
            lines.append(
                sentence(f"{plain_name(row.name)}: shows from {plain_name(row.parameter)} ",
                         displayed(row.with_plan, row.unit, 2),
                         f" on, {row.ratio:.1f} times the smallest that anybody acts on.")
            )  # fmt: skip
    pairs = _alike(plan.plan.planned.prospect, plan.plan.knowledge.candidates)
    lines += [f"{first} and {second} will still look alike." for first, second in pairs]
    lines.append("A law that no effect of the catalogue has: a diagnosis will say that it is there and where it acts.")
    return lines


def _alike(prospect: Prospect, candidates: int) -> list[tuple[str, str]]:
    enough = 0.5 * noncentrality_needed(1, candidates)
    return [
        (plain_name(each.first), plain_name(each.second)) for each in prospect.separations
        if each.log_likelihood_ratio < enough
    ]  # fmt: skip


def power_in_words() -> str:
    """The power of detectable sizes, such as "9 of 10 cases"."""
    return f"{round(10 * POWER)} of 10 cases"
