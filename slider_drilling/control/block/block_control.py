"""Block control: the pressure to ask for, the block speed, and when not to lower."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.control.block.auto_driller import AutoDriller
from slider_drilling.control.block.return_to_bottom import ReturnToBottom
from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.control.estimation.drag_monitor import DragMonitor
from slider_drilling.control.interlocks.block_slip import BlockSlipInterlock
from slider_drilling.control.interlocks.load_check import LET_GO_SHARE
from slider_drilling.control.interlocks.lock_up import LockUpInterlock
from slider_drilling.control.slide_settings import SlideSettings

if TYPE_CHECKING:
    from slider_drilling.control.estimation.string_kalman_filter import StringEstimate
    from slider_drilling.rig import Rig

WEIGHT_LIMIT_SHARE = 1.4   # of the target weight, weight limit where the settings give none
_LOADED_SHARE = 0.8       # of the allowed pressure, above which the string slides steadily
_SLOWING_SHARE = 0.08     # of the weight limit, by which drag that lets go may come near it before lowering slows down
_DRAG_LIMIT = 0.95        # of the weight limit, to which drag that lets go may bring the weight
# Share of the target pressure that drag leaves: least that is asked for, and least with which a slide may go on.
_MIN_DRAG_LEFT, _GOES_ON_SHARE = 0.2, 0.6
_TOUCHED_SHARE = 0.1      # of the target pressure, at which the bit is on bottom again
_FULL_LOAD_ERROR, _NO_LOAD_ERROR = math.radians(8.0), math.radians(13.0)   # rad of toolface left of its target
# Share of the target pressure: reduction at a torque limit, least share, recovery per s.
_PRESSURE_REDUCTION, _MIN_PRESSURE_SHARE, _RECOVERY_RATE = 0.04, 0.6, 0.0002


class BlockControl:
    """Lowers the block by differential pressure.

    Args:
        rig: Rig file.
        settings: Settings of the slide.

    Attributes:
        target_pressure: Pressure across the motor by the settings, Pa.
        torque_limit_share: Share of the target pressure that the torque limits leave.
        load_share: Share of the load that the toolface error allows.
    """

    def __init__(self, rig: Rig, settings: SlideSettings):
        self.auto_driller = AutoDriller(rig, settings.auto_driller_time, settings.max_block_speed)
        self.return_to_bottom = ReturnToBottom(rig.string.axial_stiffness, self.auto_driller.weight_per_pressure)
        self.lock_up = LockUpInterlock()
        self.slip = BlockSlipInterlock()
        self._commanded_speed = 0.0   # m/s
        self.torque_limit_share = 1.0
        self.load_share = 1.0
        self.configure(rig, settings)
        self.drag = DragMonitor(rig, settings.friction_factor, self.target_weight_on_bit)

    def configure(self, rig: Rig, settings: SlideSettings) -> None:
        """Use other settings from now on; this releases a lock-up."""
        self._settings = settings
        self.auto_driller.configure(rig, settings.auto_driller_time, settings.max_block_speed)
        rate = settings.rate_of_penetration
        self.target_pressure = settings.differential_pressure or self.auto_driller.pressure_for(rate)
        self.lock_up.release()

    @property
    def target_weight_on_bit(self) -> float:
        """Weight on bit at the target pressure by the rig file, N."""
        return self.auto_driller.weight_per_pressure * self.target_pressure

    @property
    def weight_limit(self) -> float:
        """Largest weight on bit, N."""
        return self._settings.weight_on_bit_limit or WEIGHT_LIMIT_SHARE * self.target_weight_on_bit

    @property
    def allowed_pressure(self) -> float:
        """Target pressure less what torque limits, lock-up and drag that may let go take off, Pa."""
        return min(self._pressure_beside_drag, self.drag_limit_share * self.target_pressure)

    @property
    def _pressure_beside_drag(self) -> float:
        """Target pressure less what torque limits and lock-up take off, Pa."""
        return self.lock_up.share_left * self.torque_limit_share * self.target_pressure

    @property
    def drag_limit_share(self) -> float:
        """Share of the target pressure with which drag may let go at once without passing the weight limit."""
        drag = max(self.drag.drag, 0.0) if math.isfinite(self.drag.drag) else 0.0
        weight = _DRAG_LIMIT * self.weight_limit - LET_GO_SHARE * drag
        return min(max(weight / self.target_weight_on_bit, _MIN_DRAG_LEFT), 1.0)

    def loaded(self, pressure: float) -> bool:
        """Whether the bit is loaded at this pressure (Pa) across the motor and the string slides after it."""
        return not self.return_to_bottom.under_way and pressure > _LOADED_SHARE * self.allowed_pressure

    def reduce_pressure(self) -> None:
        """Ask for less pressure after a torque limit was met: reactive torque uses part of the pipe's limit."""
        self.torque_limit_share = max(self.torque_limit_share - _PRESSURE_REDUCTION, _MIN_PRESSURE_SHARE)

    def restore_pressure(self, step: float) -> None:
        """Restore the pressure slowly; step: time since the last sample, s."""
        self.torque_limit_share = min(self.torque_limit_share + _RECOVERY_RATE * step, 1.0)

    def update_drag(
        self, hook_load: float, pressure: float, string: StringEstimate, friction_scale: float, step: float
    ) -> None:
        """Take one sample while the bit may be loaded.

        Args:
            hook_load: N; NaN where unknown.
            pressure: Across the motor, Pa.
            string: Estimate of string and motor.
            friction_scale: Friction over the assumed friction factor.
            step: Time since the last sample, s.
        """
        weight = self.auto_driller.weight_per_pressure * (1.0 + string.motor) * max(pressure, 0.0)
        self.drag.update(hook_load, weight, string.motor_sigma, friction_scale, step)

    def update_lock_up(self, pressure: float, step: float) -> None:
        """Check that weight arrives at the bit: pressure across the motor Pa, time since the last sample s."""
        # Drag that leaves most of the weight does not lock the string up.
        drag = 0.0 if self.drag_limit_share > _GOES_ON_SHARE else self.drag.share
        self.lock_up.update(drag, pressure, self._pressure_beside_drag, step)

    def pick_up(self) -> float:
        """Block speed (m/s) that lifts the bit."""
        self.auto_driller.restart()
        self.return_to_bottom.pick_up()
        return -self._settings.pick_up_speed

    def rest(self) -> float:
        """Zero block speed; drilling starts again from no weight on bit."""
        self.auto_driller.restart()
        return 0.0

    def speed(
        self, pressure: DifferentialPressure, position: float, error: float, tears_loose: bool,
        highest_weight: float, step: float,
    ) -> float:  # fmt: skip
        """Block speed while lowering is permitted.

        Args:
            pressure: Across the motor.
            position: Of the block, m.
            error: Target minus toolface, rad; positive where the toolface is left of its target.
            tears_loose: Whether large strokes tear the bit loose, and hanging weight with it.
            highest_weight: Weight on bit if rocking let go of drag, N.
            step: Time since the last sample, s.

        Returns:
            m/s, positive lowers.
        """
        if self.lock_up.stops:
            self.auto_driller.track(pressure.smooth)
            return 0.0
        if self.return_to_bottom.under_way and pressure.quick < _TOUCHED_SHARE * self.target_pressure:
            return self.return_to_bottom.speed(position, self._settings.max_block_speed, self.drag.share, step)
        self.return_to_bottom.touched()
        self.return_to_bottom.update_touching_position(position, pressure.quick, step)
        ramp = self.target_pressure / self._settings.pressure_ramp_time
        self.load_share = -1.0 if tears_loose else load_share_for_tool_face(error)
        transmitted_share = self.drag.transmitted_share(self.weight_limit) * self.load_share
        left = (self.weight_limit - highest_weight) / (_SLOWING_SHARE * self.weight_limit)
        transmitted_share = min(transmitted_share, max(left, -1.0))
        return self.auto_driller.update(pressure.smooth, self.allowed_pressure, ramp, step, transmitted_share)

    def correct_slip(self, speed: float, position: float, step: float) -> float:
        """Replace the block speed by a lift while the block has slipped.

        Args:
            speed: Block speed of the auto-driller, m/s.
            position: Of the block less its heave compensation, m; NaN where unknown.
            step: Time since the last sample, s.

        Returns:
            Block speed, m/s.
        """
        if speed < 0.0 or self.return_to_bottom.under_way:
            self.slip.restart()
            return speed
        lift = self.slip.update(position, self._commanded_speed, step)
        self._commanded_speed = 0.0 if lift else speed
        return -self._settings.pick_up_speed if lift else speed


def load_share_for_tool_face(error: float) -> float:
    """Share of the load that may be put on for a toolface error.

    Reactive torque turns the toolface to the left within seconds. Rocking winds the string against it, which takes
    minutes where friction holds much of the string. So the load waits for the toolface.

    Args:
        error: Target minus toolface, rad; positive where the toolface is left of its target.

    Returns:
        1 (full load) down to -1 (take load off).
    """
    return min(max((_NO_LOAD_ERROR - error) / (_NO_LOAD_ERROR - _FULL_LOAD_ERROR), -1.0), 1.0)
