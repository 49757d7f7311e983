"""Each effect as a driller would say it, with the numbers that were fitted."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from slider_drilling.units import KINDS, format_number

# Readings over true values where ft lbf were taken for N m, and the other way round.
_FOOT_POUNDS = KINDS["torque"]["ft lbf"]

SITES = {
    "sensor": "the surface sensors",
    "top_drive": "the top drive",
    "draw_works": "the drawworks",
    "string": "the string",
    "contact": "the contact between string and hole",
    "motor": "the mud motor",
    "bit": "the bit and the rock",
    "hydraulics": "the hydraulics",
}

# SI unit -> the unit that a driller reads, as `slider_drilling.units` calls it.
_READ = {"N m": "kN m", "N": "kN", "Pa": "bar", "rad": "deg"}


def display_unit(unit: str) -> tuple[str, float]:
    """The unit that a driller reads in place of an SI unit, and what a value is multiplied by."""
    read = _READ.get(unit, unit)
    return read, next((units[unit] / units[read] for units in KINDS.values() if unit in units and read in units), 1.0)


def format_quantity(value: float, unit: str, digits: int = 3) -> str:
    """A value of an SI unit in the unit that a driller reads: "12.3 kN m"."""
    read, factor = display_unit(unit)
    return f"{format_number(value * factor, digits)} {'' if read == '-' else read}".rstrip()


def effect_phrase(effect: str, values: Mapping[str, float]) -> str:
    """What the effect with these parameters (by their short names) means, one clause beginning with a capital: the
    first of them, and of the others those that are given.
    """
    make = _PHRASES.get(effect)
    if make is None:
        settings = ", ".join(f"{name} {format_number(value)}" for name, value in values.items())
        return f"{effect.replace('_', ' ').capitalize()} ({settings})"
    return make(values)


def _percent(share: float) -> str:
    return f"{format_number(100.0 * abs(share), 2)} %"


def _stribeck(v: Mapping[str, float]) -> str:
    more = "more" if v["drop"] > 0.0 else "less"
    where = f" (the change lies around {format_number(v['speed'], 2)} m/s)" if "speed" in v else ""
    return f"Friction of a string that hardly moves is {_percent(v['drop'])} {more} than of one that slides fast{where}"


def _static_aging(v: Mapping[str, float]) -> str:
    grows = "grows" if v["growth"] > 0.0 else "falls"
    within = f", within some {format_number(v['time'], 2)} s" if "time" in v else ""
    return f"Friction {grows} by {_percent(v['growth'])} while the string rests{within}"


def _cuttings_bed(v: Mapping[str, float]) -> str:
    # Of what is tuned there, which need not be the file's.
    where = f"between {v['top']:.0f} and {v['bottom']:.0f} m"
    return f"Something makes friction {format_number(v['factor'])} times as high {where}"


def _tortuosity(v: Mapping[str, float]) -> str:
    degrees = math.degrees(v["curvature"]) * 30.0
    return f"The open hole is more crooked than the survey shows, by {format_number(degrees, 2)} deg per 30 m"


def _friction_drift(v: Mapping[str, float]) -> str:
    way = "rises" if v["rate"] > 0.0 else "falls"
    return f"Friction {way} by {_percent(60.0 * v['rate'])} a minute"


def _compliance(v: Mapping[str, float]) -> str:
    more = "more" if v["extra"] > 0.0 else "less"
    return f"The string twists {_percent(v['extra'])} {more} per torque than its sections say"


def _oscillation_tool(v: Mapping[str, float]) -> str:
    rate = f" at {format_number(v['frequency'])} Hz" if "frequency" in v else ""
    depth = f", {v['depth']:.0f} m down" if "depth" in v else ""
    return f"Something shakes the string with {format_quantity(v['force'], 'N', 2)}{rate}{depth}"


def _heave(v: Mapping[str, float]) -> str:
    period = f" every {format_number(v['period'])} s" if "period" in v else ""
    return f"The block moves {format_number(abs(v['amplitude']), 2)} m up and down{period}, which no command shows"


def _motor_wear(v: Mapping[str, float]) -> str:
    loss, leak = v.get("torque_loss", 0.0), v.get("extra_leak", 0.0)
    parts = []
    if abs(loss) >= 0.005 or abs(leak) < 0.005:
        parts.append(
            f"gives {_percent(loss)} {'less' if loss >= 0.0 else 'more'} torque per pressure than the file says"
        )
    if abs(leak) >= 0.005:
        way = "loses" if leak > 0.0 else "keeps"
        parts.append(f"{way} {_percent(leak)} more of its speed at full pressure")
    return f"The motor {' and '.join(parts)}"


def _formation_change(v: Mapping[str, float]) -> str:
    begins = f"From {v['time']:.0f} s on the" if "time" in v else "The"
    return f"{begins} rock takes {format_number(v['factor'])} times the weight for the same cut"


def _sensor_gain(v: Mapping[str, float]) -> str:
    gain = v["gain"]
    text = f"The torque reading is {_percent(gain)} too {'high' if gain > 0.0 else 'low'}"
    for ratio, mistake in ((1.0 / _FOOT_POUNDS, "ft lbf were read as N m"), (_FOOT_POUNDS, "N m were read as ft lbf")):
        if abs((1.0 + gain) / ratio - 1.0) < 0.02:
            text += f", as if {mistake}"
    return text


def _sensor_bias(v: Mapping[str, float]) -> str:
    return f"The torque reading is {format_quantity(abs(v['bias']), 'N m')} too {'high' if v['bias'] > 0.0 else 'low'}"


def _at_motor(v: Mapping[str, float]) -> str:
    friction = f" and a friction of {format_quantity(v['friction'], 'N m')}" if v.get("friction", 0.0) > 0.0 else ""
    return (
        "The torque is read at the drive's motor and holds what turns the drive itself: an inertia of "
        f"{format_number(v['inertia'])} kg m2{friction}"
    )


_PHRASES: dict[str, Callable[[Mapping[str, float]], str]] = {
    "stribeck": _stribeck,
    "viscous_drag": lambda v: (
        f"Mud drags at the moving pipe with {format_number(v['coefficient'])} N per metre and m/s"
    ),
    "static_aging": _static_aging,
    "buckling_contact": lambda v: (
        f"Pipe under compression presses on the wall with {format_number(v['factor'])} times the force of a helix"
    ),
    "cuttings_bed": _cuttings_bed,
    "tortuosity": _tortuosity,
    "friction_drift": _friction_drift,
    "top_drive_backlash": lambda v: (
        f"There is {format_quantity(v['angle'], 'rad', 2)} of play between top drive and string"
    ),
    "torsional_compliance": _compliance,
    "axial_oscillation_tool": _oscillation_tool,
    "heave": _heave,
    "motor_wear": _motor_wear,
    "formation_change": _formation_change,
    "torque_sensor_gain": _sensor_gain,
    "torque_sensor_lag": lambda v: f"The torque reading follows {format_number(v['lag'], 2)} s late",
    "torque_sensor_bias": _sensor_bias,
    "torque_at_motor": _at_motor,
}
