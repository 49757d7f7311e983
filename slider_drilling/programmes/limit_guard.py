"""Guards the limits of a step: predicts what torque, weight and pressure still reach if the step is aborted now."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slider_drilling.control.interlocks.torque_prediction import Stroke, TorquePredictor
from slider_drilling.programmes.limits import OFF_BOTTOM, ON_BOTTOM, CompleteLimits
from slider_drilling.programmes.surface_state import SurfaceState
from slider_drilling.rig import Rig

KEPT_CLEAR = 0.06
"""Of a limit, that is kept clear of for what no channel shows: gain of a sensor, waves, drag at the tare."""
_TORQUE_CLEAR = 300.0  # N m, besides: bias of a torque sensor
_SIGMAS = 3.0
STOPPING_TIME = 2.5
"""s of lowering until the block stands and its reading is no longer smoothed."""
_MAX_BRAKING = 16.0  # rad/s2
_UNKNOWN_LAG = 0.8  # s, of torque sensor and speed loop, which the first strokes do not show yet


@dataclass(frozen=True)
class LimitReached:
    """Why a step is aborted.

    Attributes:
        limit: Its name in the file, or the interlock's.
        message: With figures.
        pick_up: Whether the bit has to be lifted.
    """

    limit: str
    message: str
    pick_up: bool


class LimitGuard:
    """Watches one programme.

    Args:
        rig: Rig file.
        interval: Between samples, s.

    Attributes:
        braking: Acceleration with which an abort stops the top drive, rad/s2.
    """

    def __init__(self, rig: Rig, interval: float) -> None:
        self.braking = min(0.8 * rig.top_drive.max_acceleration, _MAX_BRAKING)
        self._interval = interval
        self._stiffness = rig.string.axial_stiffness
        self._pressure_per_weight = rig.bit.lever / rig.motor.torque_per_pressure
        self._predictor = TorquePredictor()

    def check(
        self, limits: CompleteLimits, state: SurfaceState, turning: tuple[float, float], lowering: float
    ) -> LimitReached | None:
        """Compare one sample of a step whose motion is known with the limits.

        Args:
            limits: Of the step.
            state: The surface channels.
            turning: Speed of the top drive's reference now and when an abort would begin to brake, rad/s.
            lowering: Commanded speed of the block, m/s.

        Returns:
            The first limit that would be exceeded, or None.
        """
        coming = self._stiffness * max(lowering, 0.0) * STOPPING_TIME
        weight = state.largest_weight
        by_weight = state.pressure.circulating(state.monitor.value["pump_speed"]) + self._pressure_per_weight * (
            weight + coming
        )
        if weight > 0.0:
            weight += _SIGMAS * state.hook_sigma + coming
        return (self._torque(limits, state, turning) or self._bit(limits, state) or self._weight(limits, weight)
                or self._pressure(limits, state, max(state.standpipe, by_weight)))  # fmt: skip

    def check_slide(self, limits: CompleteLimits, state: SurfaceState, weight: float) -> LimitReached | None:
        """Compare one sample of a slide with the limits, within which its own controller steers.

        Args:
            limits: Of the step.
            state: The surface channels.
            weight: On the bit as the slide's controller estimates it, N.
        """
        torque = state.recent_torque
        limit, name = (limits.right_torque, "right") if torque > 0.0 else (limits.left_torque, "left")
        if abs(torque) >= (1.0 - 0.5 * KEPT_CLEAR) * limit:
            message = f"torque to the {name} is {abs(torque) / 1e3:.1f} kN m, {_beside(abs(torque), limit)} kN m"
            return LimitReached(f"{name}_torque", message, False)
        return self._weight(limits, weight) or self._pressure(limits, state, state.standpipe)

    def _torque(self, limits: CompleteLimits, state: SurfaceState, turning: tuple[float, float]) -> LimitReached | None:
        sensor = state.torque_sensor
        fastest = max(*turning, sensor.speed, key=abs)
        side = -1.0 if fastest < 0.0 else 1.0
        speed = max(side * fastest, 0.0)
        delay = 2.0 * self._interval + max(sensor.lag, _UNKNOWN_LAG)
        stroke = Stroke(side, speed, self.braking, sensor.impedance, delay)
        peak = self._predictor.predict_peak(sensor.torque_from_below(state.pipe_torque), stroke, state.monitor.step)
        limit, name = (limits.right_torque, "right") if side > 0.0 else (limits.left_torque, "left")
        if speed > 0.0 and math.isfinite(peak) and peak >= (1.0 - KEPT_CLEAR) * limit - _TORQUE_CLEAR:
            message = f"torque to the {name} would reach {peak / 1e3:.1f} kN m, {_beside(peak, limit)} kN m"
            return LimitReached(f"{name}_torque", message, False)
        return None

    def _bit(self, limits: CompleteLimits, state: SurfaceState) -> LimitReached | None:
        off = state.bottom is not None and state.bottom.surely_off
        if limits.bit == OFF_BOTTOM and not off:
            return LimitReached("bit", "the bit may touch bottom; pick up further before this step", True)
        if limits.bit == ON_BOTTOM and off:
            return LimitReached("bit", "the bit is off bottom", False)
        return None

    def _weight(self, limits: CompleteLimits, weight: float) -> LimitReached | None:
        if weight < (1.0 - KEPT_CLEAR) * limits.weight_on_bit:
            return None
        message = f"weight on bit may reach {weight / 1e3:.0f} kN, {_beside(weight, limits.weight_on_bit, digits=0)} kN"
        return LimitReached("weight_on_bit", message, True)

    def _pressure(self, limits: CompleteLimits, state: SurfaceState, pressure: float) -> LimitReached | None:
        pressure += _SIGMAS * state.pressure_sigma
        circulating = state.pressure.circulating(state.monitor.value["pump_speed"])
        clear = KEPT_CLEAR * max(limits.pressure - circulating, 0.0)
        if pressure < limits.pressure - clear:
            return None
        beside = _beside(pressure, limits.pressure, scale=1e5, digits=0)
        message = f"standpipe pressure may reach {pressure / 1e5:.0f} bar, {beside} bar"
        return LimitReached("pressure", message, True)


def _beside(value: float, limit: float, scale: float = 1e3, digits: int = 1) -> str:
    """How a value that is not allowed lies beside its limit; without the unit."""
    return f"{'above' if value >= limit else 'too near'} the limit of {limit / scale:.{digits}f}"
