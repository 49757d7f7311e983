"""What begins in a sealed slide: effects of the catalogue and others, as a share of their full size over time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from slider_drilling.effects import EFFECTS
from slider_drilling.rig import Rig

Values = dict[str, float]
NOTHING = "none"


@dataclass(frozen=True)
class Beginning:
    """Something that begins in a slide.

    Attributes:
        name: Effect of the catalogue or of the changes of a rig, or a law outside them.
        site: Where it acts.
        accepted: Names that are right, and what no log could distinguish from it.
        values: Share of its full size (0 to 1) and time in s since it began -> effect parameters and multiples of the
            rig's numbers.
        flow: The same -> share of the pump's flow that goes through the string.
        hook_load: The same and the true hook load in N -> the reading.
        in_catalogue: Whether a diagnosis of a change could name it.
    """

    name: str
    site: str
    accepted: tuple[str, ...]
    values: Callable[[float, float], Values] = field(default=lambda share, age: {})
    flow: Callable[[float, float], float] = field(default=lambda share, age: 1.0)
    hook_load: Callable[[float, float, float], float] = field(default=lambda share, age, load: load)
    in_catalogue: bool = True


Draw = Callable[[np.random.Generator, Rig, float], Beginning]
"""(generator, rig, onset in s) -> what begins."""


def washout(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    """A washout of 5 % of circulating pressure."""
    return _multiple("washout", "hydraulics", "pressure_gain", 0.95)


def motor_loss(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    """A motor that loses 15 % of its torque per pressure."""
    return _effect("motor_wear", {"torque_loss": 0.15})


def growing_bed(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    """A cuttings bed that grows to three times the friction."""
    return _bed(generator, rig, 3.0)


def torque_bias(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    """A torque reading that is off by 900 N m."""
    return _effect("torque_sensor_bias", {"bias": 900.0 * float(generator.choice([-1.0, 1.0]))})


def backlash(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    """A dead zone of 0.4 rad."""
    return _effect("top_drive_backlash", {"angle": 0.4})


def heave(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    """A wave of 0.1 m."""
    period = float(generator.uniform(8.0, 14.0))
    # It begins at its zero: a block does not jump.
    phase = -2.0 * math.pi * math.fmod(onset / period, 1.0)
    return _effect("heave", {"amplitude": 0.1, "period": period, "phase": phase + 2.0 * math.pi}, "amplitude")


SIX_CASES: Mapping[str, Draw] = {
    each.__name__: each for each in (washout, motor_loss, growing_bed, torque_bias, backlash, heave)
}
"""The cases that a rig's crew fears most, of fixed size."""


def _multiple(name: str, site: str, parameter: str, full: float, *others: str, known: bool = True) -> Beginning:
    """A number of the rig that is multiplied, by ``full`` in the end."""
    return Beginning(
        name, site, (name, *others), values=lambda share, age: {parameter: 1.0 + share * (full - 1.0)},
        in_catalogue=known,
    )  # fmt: skip


def _effect(name: str, full: Mapping[str, float], *growing: str) -> Beginning:
    """An effect of the catalogue; growing: its parameters that grow, all by default. The others are there at once."""
    definition = EFFECTS[name]
    neutral = definition.section()

    def values(share: float, age: float) -> Values:
        grown = growing or tuple(full)
        return {
            f"{name}.{key}": getattr(neutral, key) + share * (value - getattr(neutral, key)) if key in grown else value
            for key, value in full.items()
        }

    return Beginning(name, definition.site, (name,), values=values)


def _bed(generator: np.random.Generator, rig: Rig, factor: float) -> Beginning:
    length = rig.string.length
    top = length * float(generator.uniform(0.45, 0.75))
    bottom = top + length * float(generator.uniform(0.08, 0.15))

    def values(share: float, age: float) -> Values:
        return {"cuttings_bed.factor": 1.0 + share * (factor - 1.0), "cuttings_bed.top": top,
                "cuttings_bed.bottom": bottom}  # fmt: skip

    return Beginning("cuttings_bed", "contact", ("cuttings_bed",), values=values)


def _usual(name: str, *growing: str) -> Draw:
    """An effect of the catalogue at 0.7 to 1.8 times its usual size."""

    def draw(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
        full = EFFECTS[name].sizes.values("usual", rig.string.length)
        neutral, scale = EFFECTS[name].section(), float(generator.uniform(0.7, 1.8))
        grown = growing or (next(iter(full)),)
        scaled = {
            key: getattr(neutral, key) + scale * (value - getattr(neutral, key)) if key in grown else value
            for key, value in full.items()
        }
        return _effect(name, scaled, *grown)

    return draw


def _friction(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    """Friction of the whole hole that becomes 15 to 40 % higher."""
    full = float(generator.uniform(1.15, 1.4))
    names = ("friction_change", "friction_drift")
    return Beginning(
        "friction_change", "contact", names,
        values=lambda share, age: {f"friction_{index}": 1.0 + share * (full - 1.0) for index in (1, 2)},
    )  # fmt: skip


def _rock(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    return _multiple("formation_change", "bit", "bit_stiffness", float(generator.choice([0.6, 1.5, 1.9])))


def _nozzle(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    return _multiple("plugged_nozzle", "hydraulics", "pressure_gain", float(generator.uniform(1.03, 1.08)))


CATALOGUE_CASES: Mapping[str, Draw] = {
    "stribeck": _usual("stribeck"), "viscous_drag": _usual("viscous_drag"), "static_aging": _usual("static_aging"),
    "buckling_contact": _usual("buckling_contact"), "tortuosity": _usual("tortuosity"), "friction_change": _friction,
    "torsional_compliance": _usual("torsional_compliance"), "formation_change": _rock, "plugged_nozzle": _nozzle,
    "axial_oscillation_tool": _usual("axial_oscillation_tool"), "torque_sensor_gain": _usual("torque_sensor_gain"),
    "torque_sensor_lag": _usual("torque_sensor_lag"), "torque_at_motor": _usual("torque_at_motor"),
}  # fmt: skip
"""Other changes that a diagnosis could name."""


def _dull(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    full = float(generator.uniform(0.6, 0.8))
    return _multiple("dulling_bit", "bit", "bit_aggressiveness", full, "formation_change")


def _leaking_pump(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    lost = float(generator.uniform(0.03, 0.08))
    return Beginning(
        "leaking_pump", "hydraulics", ("leaking_pump", "washout"), flow=lambda share, age: 1.0 - lost * share,
        in_catalogue=False,
    )  # fmt: skip


def _sheave(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    half, size = float(generator.uniform(15.0, 40.0)), float(generator.uniform(8e3, 2e4))

    def read(share: float, age: float, load: float) -> float:
        return load + share * size * (1.0 if (age // half) % 2.0 == 0.0 else -1.0)

    return Beginning("sticking_sheave", "draw_works", ("sticking_sheave",), hook_load=read, in_catalogue=False)


def _breathing(generator: np.random.Generator, rig: Rig, onset: float) -> Beginning:
    period, size = float(generator.uniform(50.0, 90.0)), float(generator.uniform(0.2, 0.35))

    def values(share: float, age: float) -> Values:
        factor = 1.0 + share * size * math.sin(2.0 * math.pi * age / period)
        return {f"friction_{index}": factor for index in (1, 2)}

    return Beginning("breathing_friction", "contact", ("breathing_friction",), values=values, in_catalogue=False)


OUTSIDE_CASES: Mapping[str, Draw] = {
    "dulling_bit": _dull, "leaking_pump": _leaking_pump, "sticking_sheave": _sheave, "breathing_friction": _breathing,
}  # fmt: skip
"""What acts in other ways than the catalogue's laws."""

BEGINNINGS: Mapping[str, Draw] = {**SIX_CASES, **CATALOGUE_CASES, **OUTSIDE_CASES}
"""All of them, by the name of the case."""
