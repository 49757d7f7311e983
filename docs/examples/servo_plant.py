"""The servo of `servo.py`: arm, gear, motor and firmware, simulated at the times of a log."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.model import Array, Values
from slider_drilling.process.jit_cache import INLINED_JIT_OPTIONS, JIT_OPTIONS, njit

GRAVITY = 9.81
COUNTS = 4096  # of the encoder, a turn
# Firmware: duty = gain x error in counts / (divisor x limit), the limit of the duty being 1.
DUTY_PER_RADIAN = COUNTS / (2.0 * math.pi) / (256.0 * 885.0)
STEP = 1e-3  # s
_LONGEST_DELAY = 0.064  # s

# Every parameter of the simulation at its nominal value; the kernel reads them in this order.
NOMINAL = {
    "mass": 0.49,  # kg, at the arm's end
    "length": 0.1,  # m
    "arm": 0.0,  # kg, of the arm itself, taken as a uniform rod
    "supply": 7.4,  # V
    "torque_constant": 0.387,  # N m/A and V s/rad
    "resistance": 4.0,  # ohm
    "armature": 1.8e-3,  # kg m2, of the motor as seen at the arm
    "coulomb": 0.0128,  # N m
    "viscous": 0.0037,  # N m s/rad
    "stribeck.drop": 0.0,  # N m more at rest
    "stribeck.speed": 0.2,  # rad/s
    "load_friction_motor.share": 0.0,  # N m of friction per N m of motor torque
    "load_friction_external.share": 0.0,  # N m of friction per N m of the arm's weight
    "quadratic_load.factor": 0.0,  # 1/(N m), of the squared torque in the gear
    "backlash.angle": 0.0,  # rad, full width between gear and arm
    "encoder_offset.angle": 0.0,  # rad, from the angle shown to the arm's own
    "supply_sag.resistance": 0.0,  # ohm, of supply and cable
    "motor_heating.per_joule": 0.0,  # 1/J, of the winding's resistance, by what it turns to heat
    "delay.time": 0.0,  # s, from the encoder and the goal to the motor
}
(
    _MASS, _LENGTH, _ARM, _SUPPLY, _TORQUE_CONSTANT, _RESISTANCE, _ARMATURE, _COULOMB, _VISCOUS, _DROP, _FALLING,
    _BY_MOTOR, _BY_WEIGHT, _QUADRATIC, _BACKLASH, _OFFSET, _SAG, _HEATING, _DELAY,
) = range(len(NOMINAL))  # fmt: skip


@njit(**INLINED_JIT_OPTIONS)
def _friction(p, motor, weight, speed):
    """Largest friction torque, N m, that resists at these torques in the gear and this speed."""
    gear = abs(p[_BY_WEIGHT] * weight - p[_BY_MOTOR] * motor)
    squared = p[_QUADRATIC] * (weight - motor) ** 2
    return p[_COULOMB] + p[_DROP] * math.exp(-abs(speed) / p[_FALLING]) + gear + squared


@njit(**INLINED_JIT_OPTIONS)
def _slowed(speed, drive, damping, friction, inertia, dt):
    """Speed after dt under a constant drive torque, damping and dry friction that may hold it at rest.

    Damping by the trapezoidal rule, friction as the impulse that stops it or as much as there is: stable for any dt.
    """
    half = 0.5 * dt * damping / inertia
    free = ((1.0 - half) * speed + dt * drive / inertia) / (1.0 + half)
    lost = dt * friction / inertia / (1.0 + half)
    return math.copysign(max(abs(free) - lost, 0.0), free)


@njit(**INLINED_JIT_OPTIONS)
def _met(arm, arm_speed, gear, gear_speed, play, arm_inertia, armature):
    """Gear's angle and both speeds where gear and arm have come to the end of their play: they do not bounce."""
    ahead = gear - arm
    if abs(ahead) < play:
        return gear, arm_speed, gear_speed
    if (gear_speed - arm_speed) * ahead > 0.0:
        arm_speed = gear_speed = (armature * gear_speed + arm_inertia * arm_speed) / (armature + arm_inertia)
    return arm + math.copysign(play, ahead), arm_speed, gear_speed


@njit(**JIT_OPTIONS)
def _swing(time, goal, enabled, gain, start, speed, parameters, history, angle):
    """Fill angle (K, n), as the encoder shows it, for parameters (K, len(NOMINAL)); history: (m,) rad, work space.

    Half a drift, a kick, half a drift: of second order, and energy of the undamped arm stays within a bound.
    """
    for k in range(len(parameters)):
        p = parameters[k]
        end = (p[_MASS] + 0.5 * p[_ARM]) * p[_LENGTH]
        arm_inertia = (p[_MASS] + p[_ARM] / 3.0) * p[_LENGTH] ** 2
        constant, play, armature = p[_TORQUE_CONSTANT], 0.5 * p[_BACKLASH], p[_ARMATURE]
        arm, arm_speed, gear, gear_speed = start + p[_OFFSET], speed, start + p[_OFFSET], speed
        heat, now = 0.0, 0
        history[:] = goal[0] - start
        angle[k, 0] = start
        for i in range(len(time) - 1):
            steps = max(math.ceil((time[i + 1] - time[i]) / STEP - 1e-9), 1)
            dt = (time[i + 1] - time[i]) / steps
            on = enabled[i] > 0.5
            back = min(int(p[_DELAY] / dt + 0.5), len(history) - 1)
            for _ in range(steps):
                arm += 0.5 * dt * arm_speed
                gear += 0.5 * dt * gear_speed
                if play > 0.0:
                    gear, arm_speed, gear_speed = _met(arm, arm_speed, gear, gear_speed, play, arm_inertia, armature)
                now = (now + 1) % len(history)
                history[now] = goal[i] - (arm - p[_OFFSET])
                weight = -GRAVITY * end * math.sin(arm)
                motor, damping = 0.0, p[_VISCOUS]
                if on:
                    duty = min(max(gain * DUTY_PER_RADIAN * history[now - back], -1.0), 1.0)
                    resistance = p[_RESISTANCE] * (1.0 + p[_HEATING] * heat)
                    inner = resistance + p[_SAG] * duty * duty
                    current = (duty * p[_SUPPLY] - constant * gear_speed) / inner
                    motor = constant * duty * p[_SUPPLY] / inner
                    damping += constant * constant / inner
                    heat += dt * resistance * current * current
                holds = _friction(p, motor, weight, gear_speed)
                pushes = _slowed(gear_speed, motor + weight, damping, holds, armature + arm_inertia, dt)
                # What the gear must give the arm so that it keeps up with it: it pushes, and cannot pull.
                given = arm_inertia * (pushes - gear_speed) / dt - weight
                touch = gear_speed == arm_speed and abs(gear - arm) > (1.0 - 1e-9) * play
                if play == 0.0 or (touch and given * (gear - arm) > 0.0):
                    arm_speed = gear_speed = pushes
                else:
                    arm_speed += dt * weight / arm_inertia
                    gear_speed = _slowed(gear_speed, motor, damping, holds, armature, dt)
                arm += 0.5 * dt * arm_speed
                gear += 0.5 * dt * gear_speed
                if play > 0.0:
                    gear, arm_speed, gear_speed = _met(arm, arm_speed, gear, gear_speed, play, arm_inertia, armature)
            angle[k, i + 1] = arm - p[_OFFSET]


@dataclass(frozen=True)
class Log:
    """One log of the servo: time s, goal and position rad, enabled 0 or 1, (n,) each; gain of the firmware."""

    name: str
    gain: float
    time: Array
    goal: Array
    position: Array
    enabled: Array

    def swing(self, sets: Sequence[Values]) -> Array:
        """Angles (K, n) rad that the encoder would show, for K parameter sets; a name left out is at its nominal."""
        rows = np.array([[values.get(name, nominal) for name, nominal in NOMINAL.items()] for values in sets])
        angle = np.empty((len(sets), self.time.size))
        history = np.empty(int(_LONGEST_DELAY / (0.5 * STEP)))
        speed = _first_speed(self.time, self.position)
        first = float(self.position[0])
        _swing(self.time, self.goal, self.enabled, self.gain, first, speed, rows, history, angle)
        return angle


def _first_speed(time: Array, position: Array) -> float:
    """Slope of the first tenth of a second, rad/s."""
    early = time <= time[0] + 0.1
    return float(np.polyfit(time[early], position[early], 1)[0]) if np.count_nonzero(early) > 3 else 0.0
