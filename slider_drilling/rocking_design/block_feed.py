"""Feed of the block that holds a load at one end of the string, as a driller or an auto-driller does."""

from __future__ import annotations

from slider_drilling.rig import Rig

_TIME_CONSTANT, _SMOOTHING, _RESET_TIME = 15.0, 4.0, 90.0  # s
_MAX_SPEED = 0.03  # m/s


class BlockFeed:
    """Block speed that holds a setpoint.

    Slow against axial waves: feed that answers them would shake the string, and shaken pipe has less friction.

    Args:
        rig: Gives the stiffness of the string.
        rate: Rate of penetration that is expected, m/s.
    """

    def __init__(self, rig: Rig, rate: float):
        self.speed = rate
        self._rate = rate
        self._gain = 1.0 / (rig.string.axial_stiffness * _TIME_CONSTANT)
        self._error: float | None = None

    def update(self, error: float, step: float) -> None:
        """Set the speed for the next step.

        Args:
            error: Force (N) that lowering makes smaller: hook load above, or weight on bit below the setpoint.
            step: s.
        """
        self._error = error if self._error is None else self._error + (error - self._error) * step / _SMOOTHING
        # Integral action: the rate of penetration that belongs to the setpoint may differ from the expected one.
        self._rate = min(max(self._rate + self._gain * self._error * step / _RESET_TIME, 0.0), _MAX_SPEED)
        wanted = min(max(self._rate + self._gain * self._error, 0.0), _MAX_SPEED)
        self.speed += (wanted - self.speed) * min(step / _SMOOTHING, 1.0)
