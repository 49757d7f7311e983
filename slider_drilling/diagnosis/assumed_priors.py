"""Priors of a diagnosis from the assumed numbers of a rig file: their spreads."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import getitem
from typing import Any

from slider_drilling.gap.model import Parameter
from slider_drilling.rig import Rig
from slider_drilling.schema.changes import key_steps
from slider_drilling.schema.fields import to_tree

_SIGMAS = 3.0  # within which a fit may look
_MAX_LEAK_AT_STALL = 0.9

# Key of the rig file -> the parameter of `nuisance_parameters` that multiplies it.
_CALIBRATED = {
    "string.axial_damping": "axial_damping",
    "string.torsional_damping": "torsional_damping",
    "string.shear_modulus": "torsional_stiffness",
    "bit.depth_of_cut_stiffness": "bit_stiffness",
    "motor.torque_per_pressure": "motor_gain",
    "hydraulics.reference_pressure": "pressure_gain",
    "hydraulics.lag": "pressure_lag",
    "string.weight_factor": "string_weight",
    "string.contact_radius_factor": "contact_radius",
}
_FRICTION = re.compile(r"well\.friction_intervals\[(\d+)\]\.factor")


@dataclass(frozen=True)
class _OnlyAssumed:
    """A multiple that is calibrated only where its key is assumed: its name, and the channels that show it."""

    name: str
    channels: frozenset[str]


_ONLY_ASSUMED = {
    "bit.aggressiveness": _OnlyAssumed("bit_aggressiveness", frozenset({"standpipe_pressure", "tool_face"})),
    "motor.leak": _OnlyAssumed("motor_leak", frozenset({"standpipe_pressure"})),
}


def with_assumed_spreads(parameters: Sequence[Parameter], rig: Rig) -> tuple[Parameter, ...]:
    """Parameters with the spreads of the rig file where it marks their numbers as assumed; limits are widened to them.

    Args:
        parameters: Multiples of the rig file's values.
        rig: The rig.
    """
    spreads = {_parameter_of(key): spread for key, spread in _relative_spreads(rig).items()}
    return tuple(_with_spread(item, spreads[item.name]) if item.name in spreads else item for item in parameters)


def assumed_parameters(rig: Rig, channels: Sequence[str]) -> tuple[Parameter, ...]:
    """Multiples of numbers that only a rig file which assumes them leaves to calibrate.

    Args:
        rig: The rig.
        channels: That the log holds.
    """
    spreads, parameters = _relative_spreads(rig), []
    for key, kind in _ONLY_ASSUMED.items():
        spread = spreads.get(key)
        if spread is None or not kind.channels & set(channels):
            continue
        upper = 1.0 + _SIGMAS * spread
        if kind.name == "motor_leak":
            upper = min(upper, _MAX_LEAK_AT_STALL / rig.motor.leak_at_stall)
        lower = max(1.0 - _SIGMAS * spread, 0.1)
        if upper > 1.0:
            parameters.append(Parameter(kind.name, 1.0, lower, upper, 0.3 * spread, spread=spread))
    return tuple(parameters)


def _parameter_of(key: str) -> str:
    match = _FRICTION.fullmatch(key)
    return f"friction_{int(match[1]) + 1}" if match is not None else _CALIBRATED.get(key, key)


def _relative_spreads(rig: Rig) -> dict[str, float]:
    """Key -> spread over value of the assumed numbers that are not zero."""
    tree: Any = to_tree(rig)
    values = {item.key: reduce(getitem, key_steps(item.key), tree) for item in rig.assumed}
    return {item.key: item.spread / abs(values[item.key]) for item in rig.assumed
            if isinstance(values[item.key], float) and values[item.key] != 0.0}  # fmt: skip


def _with_spread(parameter: Parameter, spread: float) -> Parameter:
    lower = min(parameter.lower, max(parameter.nominal - _SIGMAS * spread, 0.1 * parameter.nominal))
    upper = max(parameter.upper, parameter.nominal + _SIGMAS * spread)
    return replace(parameter, spread=spread, lower=lower, upper=upper)
