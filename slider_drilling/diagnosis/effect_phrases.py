"""Each effect in a driller's words, with the numbers that were fitted."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from slider_drilling.diagnosis.display_units import displayed
from slider_drilling.units import KINDS, Quantity, Sentence, Text, format_number, sentence

Values = Mapping[str, float]

_FOOT_POUND = KINDS["torque"]["ft lbf"]  # N m
_MIN_MOTOR_CHANGE = 0.005  # a share below this is not worth a word

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


def effect_phrase(effect: str, values: Values) -> Sentence:
    """What an effect of this size means: one clause that begins with a capital.

    Args:
        effect: Name in the catalogue, or of a user's effect.
        values: Fitted parameters by their short names. The amplitude must be there; others are mentioned if given.
    """
    phrase = _PHRASES.get(effect)
    if phrase is None:
        settings = ", ".join(f"{name} {format_number(value)}" for name, value in values.items())
        return sentence(f"{effect.replace('_', ' ').capitalize()} ({settings})")
    return sentence(phrase(values))


def _percent(share: float) -> str:
    return f"{format_number(100.0 * abs(share), 2)} %"


def _stribeck(v: Values) -> Text:
    more = "higher" if v["drop"] > 0.0 else "lower"
    change = f"Friction of a string that hardly moves is {_percent(v['drop'])} {more} than of one that slides fast"
    if "speed" not in v:
        return change
    return sentence(change, " (it changes around ", Quantity(v["speed"], "m/s", 2), ")")


def _viscous_drag(v: Values) -> Text:
    return f"The mud drags at the moving pipe: {format_number(v['coefficient'])} N s/m2"


def _static_aging(v: Values) -> Text:
    grows = "grows" if v["growth"] > 0.0 else "falls"
    within = f", within about {format_number(v['time'], 2)} s" if "time" in v else ""
    return f"Friction {grows} by {_percent(v['growth'])} while the string rests{within}"


def _buckling_contact(v: Values) -> Text:
    return f"Compressed pipe presses on the wall with {format_number(v['factor'])} times the force of a helix"


def _cuttings_bed(v: Values) -> Text:
    top, bottom = (Quantity(round(v[end]), "m") for end in ("top", "bottom"))
    factor = format_number(v["factor"])
    return sentence(f"Something makes friction {factor} times as high between ", top, " and ", bottom)


def _tortuosity(v: Values) -> Text:
    degrees = format_number(math.degrees(v["curvature"]) * 30.0, 2)
    return sentence(f"The open hole is more crooked than the survey shows, by {degrees} deg per ", Quantity(30, "m", 2))


def _friction_drift(v: Values) -> Text:
    return f"Friction {'rises' if v['rate'] > 0.0 else 'falls'} by {_percent(60.0 * v['rate'])} per minute"


def _top_drive_backlash(v: Values) -> Text:
    return sentence("There is ", displayed(v["angle"], "rad", 2), " of play between top drive and string")


def _torsional_compliance(v: Values) -> Text:
    more = "more" if v["extra"] > 0.0 else "less"
    return f"The string twists {_percent(v['extra'])} {more} under torque than its sections say"


def _axial_oscillation_tool(v: Values) -> Text:
    rate = f" at {format_number(v['frequency'])} Hz" if "frequency" in v else ""
    depth: tuple[Text | Quantity, ...] = (", ", Quantity(round(v["depth"]), "m"), " down") if "depth" in v else ()
    return sentence("Something shakes the string with ", displayed(v["force"], "N", 2), rate, *depth)


def _heave(v: Values) -> Text:
    period = f" every {format_number(v['period'])} s" if "period" in v else ""
    height = Quantity(abs(v["amplitude"]), "m", 2)
    return sentence("The block moves up and down by ", height, f"{period}, which no command shows")


def _motor_wear(v: Values) -> Text:
    loss, leak = v.get("torque_loss", 0.0), v.get("extra_leak", 0.0)
    clauses = []
    if abs(loss) >= _MIN_MOTOR_CHANGE or abs(leak) < _MIN_MOTOR_CHANGE:
        less = "less" if loss >= 0.0 else "more"
        clauses.append(f"gives {_percent(loss)} {less} torque per pressure than the file says")
    if abs(leak) >= _MIN_MOTOR_CHANGE:
        clauses.append(f"{'loses' if leak > 0.0 else 'keeps'} {_percent(leak)} more of its speed at full pressure")
    return f"The motor {' and '.join(clauses)}"


def _formation_change(v: Values) -> Text:
    since = f"From {v['time']:.0f} s on the" if "time" in v else "The"
    return f"{since} rock takes {format_number(v['factor'])} times the weight for the same cut"


def _torque_sensor_gain(v: Values) -> Text:
    gain = v["gain"]
    text = f"The torque reading is {_percent(gain)} too {'high' if gain > 0.0 else 'low'}"
    for ratio, mistake in ((1.0 / _FOOT_POUND, "ft lbf were read as N m"), (_FOOT_POUND, "N m were read as ft lbf")):
        if abs((1.0 + gain) / ratio - 1.0) < 0.02:
            text += f", as if {mistake}"
    return text


def _torque_sensor_lag(v: Values) -> Text:
    return f"The torque reading lags by {format_number(v['lag'], 2)} s"


def _torque_sensor_bias(v: Values) -> Text:
    high = "high" if v["bias"] > 0.0 else "low"
    return sentence("The torque reading is ", displayed(abs(v["bias"]), "N m"), f" too {high}")


def _torque_at_motor(v: Values) -> Text:
    clause = (
        "The torque is read at the drive's motor, so it includes what turns the drive itself: an inertia of "
        f"{format_number(v['inertia'])} kg m2"
    )
    if v.get("friction", 0.0) <= 0.0:
        return clause
    return sentence(clause, " and a friction of ", displayed(v["friction"], "N m"))


_PHRASES: dict[str, Callable[[Values], Text]] = {
    "stribeck": _stribeck,
    "viscous_drag": _viscous_drag,
    "static_aging": _static_aging,
    "buckling_contact": _buckling_contact,
    "cuttings_bed": _cuttings_bed,
    "tortuosity": _tortuosity,
    "friction_drift": _friction_drift,
    "top_drive_backlash": _top_drive_backlash,
    "torsional_compliance": _torsional_compliance,
    "axial_oscillation_tool": _axial_oscillation_tool,
    "heave": _heave,
    "motor_wear": _motor_wear,
    "formation_change": _formation_change,
    "torque_sensor_gain": _torque_sensor_gain,
    "torque_sensor_lag": _torque_sensor_lag,
    "torque_sensor_bias": _torque_sensor_bias,
    "torque_at_motor": _torque_at_motor,
}
