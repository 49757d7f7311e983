"""The block: how much weight is asked for, how fast to lower, and when not to."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.control.block.auto_driller import AutoDriller
from slider_drilling.control.block.return_to_bottom import ReturnToBottom
from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.control.estimation.drag_monitor import DragMonitor
from slider_drilling.control.interlocks.block_slip import BlockSlipInterlock
from slider_drilling.control.interlocks.lock_up import LockUpInterlock
from slider_drilling.control.slide_settings import SlideSettings

if TYPE_CHECKING:
    from slider_drilling.control.estimation.string_kalman_filter import StringEstimate
    from slider_drilling.rig import Rig

_LOADED_SHARE = 0.8          # of the pressure asked for, from which on the string slides steadily
_TOUCHED_SHARE = 0.1         # of the pressure wanted, at which the bit is on bottom again
_LOADS, _RESTS = math.radians(8.0), math.radians(13.0)   # of the toolface behind: full load until, none from there on
_EASED, _LEAST_SHARE, _RESTORED = 0.04, 0.6, 0.0002   # of the pressure wanted: at a torque limit, the least, per s


class BlockControl:
    """wanted: Pa across the motor, by the settings; asked: what torque limits and lock-up leave of it."""

    def __init__(self, rig: Rig, settings: SlideSettings):
        self.driller = AutoDriller(rig, settings.auto_driller_time, settings.max_block_speed)
        self.approach = ReturnToBottom(rig.string.axial_stiffness, self.driller.weight_per_pressure)
        self.lock_up = LockUpInterlock()
        self.slip = BlockSlipInterlock()
        self._told = 0.0         # m/s
        self.borne_share = 1.0   # of the pressure wanted, that torque limits leave
        self.following = 1.0     # share of the load that the toolface lets be put on
        self.configure(rig, settings)
        self.drag = DragMonitor(rig, settings.friction_factor, self.weight_wanted)

    def configure(self, rig: Rig, settings: SlideSettings) -> None:
        """Use other settings from now on; a lock-up is let go of."""
        self._settings = settings
        self.driller.configure(rig, settings.auto_driller_time, settings.max_block_speed)
        self.wanted = settings.differential_pressure or self.driller.pressure_for(settings.rate_of_penetration)
        self.lock_up.release()

    @property
    def weight_wanted(self) -> float:
        """N on bit, as believed."""
        return self.driller.weight_per_pressure * self.wanted

    @property
    def asked(self) -> float:
        """Pa."""
        return self.lock_up.share_left * self.borne_share * self.wanted

    def loaded(self, pressure: float) -> bool:
        """Whether the bit is, at this pressure (Pa) across the motor, and the string slides after it."""
        return not self.approach.under_way and pressure > _LOADED_SHARE * self.asked

    def ease(self) -> None:
        """A torque limit was met: the reactive torque takes its part of what the pipe bears."""
        self.borne_share = max(self.borne_share - _EASED, _LEAST_SHARE)

    def regain(self, step: float) -> None:
        """`step` s without: what was taken back returns slowly."""
        self.borne_share = min(self.borne_share + _RESTORED * step, 1.0)

    def weigh(self, hook_load: float, pressure: float, string: StringEstimate, friction: float, step: float) -> None:
        """Take a sample: N, NaN where there is none; Pa across the motor; what is learnt of string and motor; friction
        over its belief; s since the last one."""
        weight = self.driller.weight_per_pressure * (1.0 + string.motor) * max(pressure, 0.0)
        self.drag.update(hook_load, weight, string.motor_sigma, friction, step)

    def judge(self, pressure: float, step: float) -> None:
        """See whether weight arrives: Pa across the motor, s."""
        self.lock_up.update(self.drag.share, pressure, self.asked, step)

    def pick_up(self) -> float:
        """Block speed (m/s) that lifts the bit."""
        self.driller.restart()
        self.approach.pick_up()
        return -self._settings.pick_up_speed

    def rest(self) -> float:
        """No speed, and none to go on from."""
        self.driller.restart()
        return 0.0

    def speed(self, pressure: DifferentialPressure, position: float, behind: float, step: float) -> float:
        """Block speed, m/s. position: m, of the block; behind: rad, of the toolface left of its target; step: s since
        the last sample."""
        if self.lock_up.stops:
            self.driller.follow(pressure.smooth)
            return 0.0
        if self.approach.under_way and pressure.quick < _TOUCHED_SHARE * self.wanted:
            return self.approach.speed(position, self._settings.max_block_speed, self.drag.share, step)
        self.approach.touched()
        self.approach.drilling(position, pressure.quick, step)
        ramp = self.wanted / self._settings.pressure_ramp_time
        self.following = load_share_for_tool_face(behind)
        return self.driller.update(pressure.smooth, self.asked, ramp, step, self.drag.arriving * self.following)

    def held(self, speed: float, position: float, step: float) -> float:
        """Block speed, m/s: `speed` (m/s), or what lifts a block that has come down by itself. position: m, of the
        block but for what it moves against heave, NaN where there is none; step: s since the last sample."""
        if speed < 0.0 or self.approach.under_way:
            self.slip.restart()
            return speed
        lift = self.slip.update(position, self._told, step)
        self._told = 0.0 if lift else speed
        return -self._settings.pick_up_speed if lift else speed


def load_share_for_tool_face(behind: float) -> float:
    """Share of the load that may be put on, for a toolface that is `behind` (rad, left of its target): 1 to -1, what
    is taken back.

    Reactive torque turns the toolface to the left within seconds, rocking winds the string against it within minutes
    where much of it is held. So the load waits for the winding.
    """
    return min(max((_RESTS - behind) / (_RESTS - _LOADS), -1.0), 1.0)
