"""From a rig file to what a controller believes of its string, and from what it has learnt back to a rig file."""

from __future__ import annotations

import dataclasses

from slider_drilling.control.estimation.string_kalman_filter import StringEstimate
from slider_drilling.rig import Rig


def with_worn_motor(rig: Rig) -> Rig:
    """The rig with the motor's torque per pressure as its file's effects say that it is."""
    left = 1.0 - rig.effects.motor_wear.torque_loss
    motor = dataclasses.replace(rig.motor, torque_per_pressure=left * rig.motor.torque_per_pressure)
    return dataclasses.replace(rig, motor=motor)


def calibrated_rig(rig: Rig, learnt: StringEstimate) -> Rig:
    """The rig file with what a slide has shown of it, in its effects: compliance, motor and torque sensor."""
    effects = rig.effects
    extra = (1.0 + effects.torsional_compliance.extra) * (1.0 + learnt.compliance) - 1.0
    loss = 1.0 - (1.0 - effects.motor_wear.torque_loss) * (1.0 + learnt.motor)
    return dataclasses.replace(rig, effects=dataclasses.replace(
        effects,
        torsional_compliance=dataclasses.replace(effects.torsional_compliance, extra=extra),
        motor_wear=dataclasses.replace(effects.motor_wear, torque_loss=loss),
        torque_sensor_bias=dataclasses.replace(effects.torque_sensor_bias, bias=learnt.bias)))
