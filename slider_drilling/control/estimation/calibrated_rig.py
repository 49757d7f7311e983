"""The rig with a worn motor, as a controller uses it, and the rig file with what a slide has shown of the string."""

from __future__ import annotations

import dataclasses

from slider_drilling.control.estimation.string_kalman_filter import StringEstimate
from slider_drilling.rig import Rig


def with_worn_motor(rig: Rig) -> Rig:
    """Return the rig with the motor's torque per pressure reduced by its `motor_wear` effect."""
    left = 1.0 - rig.effects.motor_wear.torque_loss
    motor = dataclasses.replace(rig.motor, torque_per_pressure=left * rig.motor.torque_per_pressure)
    return dataclasses.replace(rig, motor=motor)


def calibrated_rig(rig: Rig, estimate: StringEstimate) -> Rig:
    """Return the rig file with the estimate in its effects: compliance, motor wear and torque-sensor bias."""
    effects = rig.effects
    extra = (1.0 + effects.torsional_compliance.extra) * (1.0 + estimate.compliance) - 1.0
    loss = 1.0 - (1.0 - effects.motor_wear.torque_loss) * (1.0 + estimate.motor)
    return dataclasses.replace(rig, effects=dataclasses.replace(
        effects,
        torsional_compliance=dataclasses.replace(effects.torsional_compliance, extra=extra),
        motor_wear=dataclasses.replace(effects.motor_wear, torque_loss=loss),
        torque_sensor_bias=dataclasses.replace(effects.torque_sensor_bias, bias=estimate.bias)))
