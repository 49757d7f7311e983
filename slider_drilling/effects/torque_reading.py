"""Effects on the reading of the surface torque.

They act in this order: torque at the motor, gain, bias, lag. Noise and resolution of the rig file's ``sensors`` section
come last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.effects.definition import EffectDefinition, FitParameter, Search, Sizes, Values, percent
from slider_drilling.schema.fields import quantity
from slider_drilling.units import KINDS, Text, displayed, format_number, sentence

_FOOT_POUND = KINDS["torque"]["ft lbf"]  # N m


def _torque_is_logged(channels: Sequence[str], off_bottom: bool) -> bool:
    return "surface_torque" in channels


@dataclass(frozen=True)
class TorqueSensorGain:
    """The torque reading is wrong by a factor: ``torque (1 + gain)``."""

    gain: float = quantity("-", 0.0, above=-1.0, at_most=10.0, why="a share of the torque; -1 shows none")


def _torque_sensor_gain_phrase(v: Values) -> Text:
    gain = v["gain"]
    text = f"The torque reading is {percent(gain)} too {'high' if gain > 0.0 else 'low'}"
    for ratio, mistake in ((1.0 / _FOOT_POUND, "ft lbf were read as N m"), (_FOOT_POUND, "N m were read as ft lbf")):
        if abs((1.0 + gain) / ratio - 1.0) < 0.02:
            text += f", as if {mistake}"
    return text


TORQUE_SENSOR_GAIN = EffectDefinition(
    "torque_sensor_gain", "sensor", TorqueSensorGain, "torque (1 + gain)",
    search=lambda log: Search(
        (FitParameter("gain", -0.6, 1.5, 0.01),), scan=((0.05,), (-0.05,), (0.2,), (-0.2,))
    ),
    sizes=Sizes(usual={"gain": 0.1}, small={"gain": 0.03}, large={"gain": -0.1}, material={"gain": 0.02}),
    phrase=_torque_sensor_gain_phrase,
    draw=lambda random, length, duration: {"gain": random.uniform(-0.1, 0.1)},
    # A calibration of friction and stiffness scales a lone torque in the same way.
    visible=lambda channels, off_bottom: list(channels) != ["surface_torque"],
)  # fmt: skip


@dataclass(frozen=True)
class TorqueSensorLag:
    """The torque reading follows the torque with the first-order time constant `lag`. It starts settled."""

    lag: float = quantity("s", 0.0, at_least=0.0, at_most=60.0, why="first order: under a second to some")


def _torque_sensor_lag_phrase(v: Values) -> Text:
    return f"The torque reading lags by {format_number(v['lag'], 2)} s"


TORQUE_SENSOR_LAG = EffectDefinition(
    "torque_sensor_lag", "sensor", TorqueSensorLag, "first-order lag",
    # A shorter lag than half the sampling interval comes from the time stamps.
    nonphysical="a shift of the time stamps of less than half the sampling interval",
    search=lambda log: Search(
        (FitParameter("lag", 0.0, 8.0, 0.05),), scan=((0.1,), (0.4,), (1.2,)),
        physical=(0.5 * log.torque_interval, np.inf),
    ),
    sizes=Sizes(usual={"lag": 0.5}, small={"lag": 0.2}, large={"lag": 0.8}, material={"lag": 0.1}),
    phrase=_torque_sensor_lag_phrase,
    draw=lambda random, length, duration: {"lag": random.uniform(0.1, 0.8)},
    visible=_torque_is_logged,
)  # fmt: skip


@dataclass(frozen=True)
class TorqueSensorBias:
    """The torque reading is wrong by a constant: `bias` is added."""

    bias: float = quantity("N m", 0.0, at_least=-1e5, at_most=1e5, why="in N m, not kN m")


def _torque_sensor_bias_phrase(v: Values) -> Text:
    high = "high" if v["bias"] > 0.0 else "low"
    return sentence("The torque reading is ", displayed(abs(v["bias"]), "N m"), f" too {high}")


TORQUE_SENSOR_BIAS = EffectDefinition(
    "torque_sensor_bias", "sensor", TorqueSensorBias, "torque + bias",
    search=lambda log: Search(
        (FitParameter("bias", -8000.0, 8000.0, 100.0),), scan=((400.0,), (-400.0,), (1500.0,))
    ),
    sizes=Sizes(usual={"bias": 500.0}, small={"bias": 150.0}, large={"bias": -500.0}, material={"bias": 100.0}),
    phrase=_torque_sensor_bias_phrase,
    draw=lambda random, length, duration: {"bias": random.uniform(-500.0, 500.0)},
    visible=_torque_is_logged,
)  # fmt: skip


@dataclass(frozen=True)
class TorqueAtMotor:
    """The torque is read at the top drive's motor, for instance from its current, and not at the quill.

    The reading then includes the torque that turns the drive itself: ``inertia d(speed)/dt + friction sign(speed)``,
    both as seen at the quill's speed. In a replay or a diagnosis of a log, the acceleration comes from a smoothing
    spline through the measured speed; cross-validation chooses how smooth it is.
    """

    inertia: float = quantity("kg m2", 0.0, at_least=0.0, at_most=1e5, why="at the quill, gears included: 1e+3 to 5e+3")
    friction: float = quantity("N m", 0.0, at_least=0.0, at_most=1e5, why="in N m, not kN m; of bearings and gears")


def _torque_at_motor_phrase(v: Values) -> Text:
    clause = (
        "The torque is read at the drive's motor, so it includes what turns the drive itself: an inertia of "
        f"{format_number(v['inertia'])} kg m2"
    )
    if v.get("friction", 0.0) <= 0.0:
        return clause
    return sentence(clause, " and a friction of ", displayed(v["friction"], "N m"))


TORQUE_AT_MOTOR = EffectDefinition(
    "torque_at_motor", "top_drive", TorqueAtMotor, "torque + inertia d(speed)/dt + friction sign(speed)",
    search=lambda log: Search(
        (FitParameter("inertia", 0.0, 8000.0, 100.0), FitParameter("friction", 0.0, 6000.0, 100.0)),
        scan=((500.0, 100.0), (2000.0, 100.0), (1500.0, 1500.0)),
    ),
    sizes=Sizes(
        usual={"inertia": 900.0, "friction": 200.0}, small={"inertia": 400.0, "friction": 100.0},
        large={"inertia": 1500.0, "friction": 400.0},
        material={"inertia": 200.0, "friction": 100.0},
    ),
    phrase=_torque_at_motor_phrase,
    draw=lambda random, length, duration: {
        "inertia": random.uniform(300.0, 1500.0), "friction": random.uniform(50.0, 400.0)
    },
    visible=_torque_is_logged,
)  # fmt: skip


@dataclass(frozen=True)
class TorqueReadingEffects:
    """The part of the rig file's ``effects`` section on the reading of the surface torque."""

    torque_sensor_gain: TorqueSensorGain = TorqueSensorGain()
    torque_sensor_lag: TorqueSensorLag = TorqueSensorLag()
    torque_sensor_bias: TorqueSensorBias = TorqueSensorBias()
    torque_at_motor: TorqueAtMotor = TorqueAtMotor()


TORQUE_READING = (TORQUE_SENSOR_GAIN, TORQUE_SENSOR_LAG, TORQUE_SENSOR_BIAS, TORQUE_AT_MOTOR)
