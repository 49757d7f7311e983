"""The catalogue: each effect of the registry as a candidate of the gap engine.

A candidate's parameters are called ``effect.parameter``, as in the rig file's ``effects`` section.
"""

from __future__ import annotations

from collections.abc import Sequence

from slider_drilling.effects import EFFECTS, SEARCH_ORDER, EffectDefinition, FitParameter, Search, SearchInputs
from slider_drilling.effects.contact import STATIC_AGING, STICK_SLIP_AGING_SEARCH
from slider_drilling.gap.model import Effect, Parameter, Values

SEA_WAVE_PERIODS_S = (6.0, 9.0, 13.0)
"""Periods at which the search for heave starts where the log's spectrum has no peaks."""


def catalogue(
    length: float,
    duration: float,
    wave_periods: Sequence[float] = SEA_WAVE_PERIODS_S,
    tool_frequencies: Sequence[float] = (),
    torque_interval: float = 0.0,
) -> tuple[Effect, ...]:
    """Returns every effect of the registry as a candidate; the arguments are those of `SearchInputs`."""
    inputs = SearchInputs(length, duration, wave_periods, tool_frequencies, torque_interval)
    return tuple(_candidate(definition, definition.search(inputs)) for definition in SEARCH_ORDER)


def static_aging_with_slip_distance() -> Effect:
    """Returns `static_aging` as it is searched for in stick-slip, see `STICK_SLIP_AGING_SEARCH`."""
    return _candidate(STATIC_AGING, STICK_SLIP_AGING_SEARCH)


def user_parameters(length: float) -> dict[str, Parameter]:
    """Returns the rig file's parameters of effects that are fitted with other ones, by name.

    Args:
        length: Length of the string, m.
    """
    parameters = (
        _parameter(definition, parameter)
        for definition in EFFECTS.values()
        for parameter in definition.reported(length)
    )
    return {parameter.name: parameter for parameter in parameters}


def to_user(values: Values, length: float) -> dict[str, float]:
    """Returns fitted values as the rig file's ``effects`` section has them.

    Args:
        values: Fitted values by ``effect.parameter``; other names are passed on.
        length: Length of the string, m.
    """
    user = dict(values)
    for definition in EFFECTS.values():
        if definition.to_rig_file is None:
            continue
        prefix = f"{definition.name}."
        fitted = {name.removeprefix(prefix): value for name, value in values.items() if name.startswith(prefix)}
        converted = definition.to_rig_file(fitted, length)
        for key in fitted.keys() - converted.keys():
            del user[prefix + key]
        user |= {prefix + key: value for key, value in converted.items()}
    return user


def _candidate(definition: EffectDefinition, search: Search) -> Effect:
    return Effect(
        definition.name, definition.site, tuple(_parameter(definition, parameter) for parameter in search.parameters),
        search.scan, search.physical, definition.nonphysical, definition.law, search.fidelity,
        {f"{definition.name}.{key}": value for key, value in definition.sizes.material.items()},
    )  # fmt: skip


def _parameter(definition: EffectDefinition, parameter: FitParameter) -> Parameter:
    return Parameter(
        f"{definition.name}.{parameter.key}", definition.neutral(parameter), parameter.lower, parameter.upper,
        parameter.step, definition.unit(parameter), equivalents=parameter.equivalents,
    )  # fmt: skip
