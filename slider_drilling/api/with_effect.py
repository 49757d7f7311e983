"""`with_effect`: a rig with an effect of the catalogue switched on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

from slider_drilling.effects import Effects
from slider_drilling.errors import InputError
from slider_drilling.rig import Rig
from slider_drilling.schema.changes import parse_number

USUAL_SIZES: dict[str, Callable[[float], dict[str, float]]] = {
    "stribeck": lambda length: {"drop": 0.3, "speed": 0.05},
    "viscous_drag": lambda length: {"coefficient": 25.0},
    "static_aging": lambda length: {"growth": 0.5, "time": 5.0},
    "buckling_contact": lambda length: {"factor": 1.5},
    "cuttings_bed": lambda length: {"factor": 1.9, "top": 0.65 * length, "bottom": 0.8 * length},
    "tortuosity": lambda length: {"curvature": 6e-4},
    "friction_drift": lambda length: {"rate": 4e-4},
    "top_drive_backlash": lambda length: {"angle": 0.4},
    "torsional_compliance": lambda length: {"extra": 0.12},
    "axial_oscillation_tool": lambda length: {"force": 2e3, "frequency": 15.0, "depth": 0.7 * length},
    "heave": lambda length: {"amplitude": 0.08, "period": 10.0},
    "motor_wear": lambda length: {"torque_loss": 0.28, "extra_leak": 0.2},
    "formation_change": lambda length: {"factor": 1.4, "time": 150.0},
    "torque_sensor_gain": lambda length: {"gain": 0.1},
    "torque_sensor_lag": lambda length: {"lag": 0.5},
    "torque_sensor_bias": lambda length: {"bias": 500.0},
    "torque_at_motor": lambda length: {"inertia": 900.0, "friction": 200.0},
}
"""A usual size of each effect, given the string's length in m; units as in the rig file."""


def with_effect(rig: Rig, effect: str) -> Rig:
    """A copy of the rig with an effect switched on.

    Args:
        rig: The rig.
        effect: ``"stribeck"``, or with values ``"stribeck:drop=0.4,speed=0.05"``. Values that are not given have
            their usual size.

    Raises:
        InputError: The effect or a value is unknown.
    """
    name, colon, given = effect.partition(":")
    known = [field.name for field in fields(Effects)]
    before_equals = name.partition("=")[0]
    if before_equals in known and name not in known:
        raise InputError(f"effect = {effect!r}: give its values by their keys, as in {before_equals}:KEY=VALUE")
    if name not in known:
        raise InputError(f"effect = {name!r}: no such effect; one of {', '.join(known)}")
    if name not in USUAL_SIZES and not colon:
        raise InputError(f"effect = {name!r}: has no usual size; give its values, as in {name}:KEY=VALUE")
    values = USUAL_SIZES[name](rig.string.length) if name in USUAL_SIZES else {}
    for pair in given.split(",") if colon else ():
        key, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"effect = {effect!r}: {pair!r} is not KEY=VALUE")
        values[key.strip()] = parse_number(text, f"effect {name}: {key.strip()}")
    return rig.with_({f"effects.{name}": values})
