"""The catalogue: each effect of the registry as a candidate of the gap engine.

A candidate's parameters are called ``effect.parameter``, as in the rig file's ``effects`` section.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.effects import EFFECTS, SEARCH_ORDER, EffectDefinition, FitParameter, Search, SearchInputs
from slider_drilling.effects.contact import STATIC_AGING, STICK_SLIP_AGING_SEARCH
from slider_drilling.errors import InputError
from slider_drilling.gap.model import Effect, Parameter, Values

# Before the number of the run that a parameter belongs to, from the second run on.
_MARK = "#"
SEA_WAVE_PERIODS_S = (6.0, 9.0, 13.0)
"""Periods at which the search for heave starts where the log's spectrum has no peaks."""


def catalogue(
    length: float,
    duration: float,
    wave_periods: Sequence[float] = SEA_WAVE_PERIODS_S,
    tool_frequencies: Sequence[float] = (),
    torque_interval: float = 0.0,
    runs: int = 1,
) -> tuple[Effect, ...]:
    """Returns every effect of the registry as a candidate.

    Args:
        length, duration, wave_periods, tool_frequencies, torque_interval: See `SearchInputs`.
        runs: Number of runs that are fitted together.
    """
    inputs = SearchInputs(length, duration, wave_periods, tool_frequencies, torque_interval)
    return tuple(_candidate(definition, definition.search(inputs), runs) for definition in SEARCH_ORDER)


def check_names(only: Sequence[str], known: Sequence[str], what: str = "an effect") -> None:
    """Check the names of effects or changes to consider. Raises InputError for one that is not known."""
    for name in only:
        if name not in known:
            raise InputError(f"only {name}: not {what} that this log can show; use {', '.join(known)}")


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
    user = of_run(values, 0)
    for definition in EFFECTS.values():
        if definition.to_rig_file is None:
            continue
        prefix = f"{definition.name}."
        fitted = {name.removeprefix(prefix): value for name, value in user.items() if name.startswith(prefix)}
        converted = definition.to_rig_file(fitted, length)
        for key in fitted.keys() - converted.keys():
            del user[prefix + key]
        user |= {prefix + key: value for key, value in converted.items()}
    return user


def of_run(values: Values, run: int) -> dict[str, float]:
    """Returns the values of one run: those that later runs have of their own stand under the first run's names.

    Args:
        values: Values by the names of the fit.
        run: Index of the run.
    """
    own = {name: value for name, value in values.items() if _MARK not in name}
    suffix = f"{_MARK}{run + 1}"
    return own | {name.removesuffix(suffix): value for name, value in values.items() if name.endswith(suffix)}


def _candidate(definition: EffectDefinition, search: Search, runs: int = 1) -> Effect:
    """The candidate; what belongs to a run, such as the phase of a wave, is freed once for each run."""
    parameters, scan = [_parameter(definition, parameter) for parameter in search.parameters], search.scan
    own = {index: definition.per_run[each.key] for index, each in enumerate(search.parameters)
           if each.key in definition.per_run}  # fmt: skip
    for index, shifts in own.items() if runs > 1 else ():
        later = range(2, runs + 1)
        parameters += [replace(parameters[index], name=f"{parameters[index].name}{_MARK}{run}") for run in later]
        scan = tuple((*point, *[point[index] + shift] * len(later)) for point in scan for shift in shifts)
    return Effect(
        definition.name, definition.site, tuple(parameters), scan, search.physical, definition.nonphysical,
        definition.law, search.fidelity,
        {f"{definition.name}.{key}": value for key, value in definition.sizes.material.items()},
    )  # fmt: skip


def _parameter(definition: EffectDefinition, parameter: FitParameter) -> Parameter:
    return Parameter(
        f"{definition.name}.{parameter.key}", definition.neutral(parameter), parameter.lower, parameter.upper,
        parameter.step, definition.unit(parameter), equivalents=parameter.equivalents,
    )  # fmt: skip
