"""Fixed rocking: constant amplitude or torque limits; each MWD sample shifts the centre by a share of its error."""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slider_drilling.control.interface import Level, Measurements, MwdSample, RigCommand, Status
from slider_drilling.control.rocking import Rocking
from slider_drilling.control.settings import check, setting
from slider_drilling.errors import InputError

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

# Best amplitudes and periods for a proportional shift, found on three reference wells (8 1/2 in hole, 5 in pipe,
# friction factor 0.23 to 0.34): string length m, amplitude rad, period s.
_REFERENCE_WELLS = ((2600.0, 8.0, 14.0), (4000.0, 20.0, 24.0), (5600.0, 30.0, 30.0))
_ACCELERATION_MARGIN = 1.05  # over what the peaks need


@dataclass(frozen=True)
class FixedRockingSettings:
    """Settings of FixedRocking; with a torque limit of 0 strokes reverse at the amplitude alone."""

    amplitude: float = setting(20.0, "rad", 0.0, 200.0, "rocking amplitude of the top drive, to either side")
    period: float = setting(24.0, "s", 2.0, 300.0, "rocking period at full amplitude")
    rounding: float = setting(0.25, "s", 0.05, 10.0, "half the width of a rounded peak")
    right_torque_limit: float = setting(0.0, "N m", 0.0, 100e3, "reverse strokes to the right at this torque; 0: none")
    left_torque_limit: float = setting(0.0, "N m", 0.0, 100e3, "reverse strokes to the left at this torque; 0: none")
    shift_gain: float = setting(0.1, "-", 0.0, 1.0, "centre shift per toolface error, at each MWD sample")
    shift_speed: float = setting(0.5, "rad/s", 0.01, 5.0, "speed at which the centre moves when shifted")
    block_speed: float = setting(0.0025, "m/s", 0.0, 0.05, "block speed, positive lowers; 0.0025 is 9 m/h")
    pump_speed: float = setting(12.3, "rad/s", 0.0, 60.0, "crank speed of the mud pump")


def settings_for(rig: Rig) -> FixedRockingSettings:
    """Return settings for a rig: amplitude and period by string length, pump speed for the reference flow.

    The peaks are rounded as far as the top drive's acceleration needs.
    """
    length = sum(section.length for section in rig.string.sections)
    amplitude, period = _interpolate(length)
    pump_speed = rig.reference_pump_speed
    rounding = rounding_for(rig, amplitude, period)
    return FixedRockingSettings(amplitude=amplitude, period=period, rounding=rounding, pump_speed=pump_speed)


def rounding_for(rig: Rig, amplitude: float, period: float) -> float:
    """Half the width of a peak, s, that the top drive can follow at an amplitude, rad, and a period, s."""
    needed = _ACCELERATION_MARGIN * 4.0 * amplitude / period / rig.top_drive.max_acceleration
    return min(max(FixedRockingSettings.rounding, needed), period / 6.0)


def _interpolate(length: float) -> tuple[float, float]:
    if length <= _REFERENCE_WELLS[0][0]:
        return _REFERENCE_WELLS[0][1:]
    for (length_0, amplitude_0, period_0), (length_1, amplitude_1, period_1) in itertools.pairwise(_REFERENCE_WELLS):
        if length <= length_1:
            share = (length - length_0) / (length_1 - length_0)
            return amplitude_0 + share * (amplitude_1 - amplitude_0), period_0 + share * (period_1 - period_0)
    return _REFERENCE_WELLS[-1][1:]


class FixedRocking:
    """Rocks about a centre that every MWD sample shifts by `shift_gain` times the unwrapped toolface error.

    With torque limits a stroke reverses where surface torque reaches its limit, or after twice the amplitude,
    whichever comes first. A shift is then driven as a bump beyond the limit on its own side.

    Args:
        rig: Rig file.
        settings: Default: `settings_for(rig)`.
        tool_face_target: rad.

    Attributes:
        tool_face_target: rad; may be set between any two steps.

    Raises:
        InputError: A setting is out of its range, or the rounding needs more acceleration than the top drive has.
    """

    def __init__(self, rig: Rig, settings: FixedRockingSettings | None = None, tool_face_target: float = 0.0):
        self.tool_face_target = tool_face_target
        self._max_acceleration = rig.top_drive.max_acceleration
        self._settings = settings_for(rig) if settings is None else settings
        self._rocking = self._make_rocking(self._settings)
        self._time: float | None = None
        self._elapsed = 0.0          # s on the rocking clock
        self._centre = 0.0           # rad
        self._pending = 0.0          # rad of shift still to be driven
        self._tool_face: float | None = None   # rad, unwrapped
        self._side = 0.0             # direction of the stroke, +1 clockwise
        self._limit_angle: float | None = None   # rad, where this stroke met its torque limit
        self._bump_driven = False                # whether it went beyond that by the pending shift
        self._limit_was_met = False              # on the last stroke

    @property
    def settings(self) -> FixedRockingSettings:
        """The settings in use."""
        return self._settings

    def configure(self, settings: FixedRockingSettings) -> None:
        """Change settings between two steps; the angle stays continuous and the stroke keeps its direction.

        Raises:
            InputError: As the constructor; nothing has changed.
        """
        rocking = self._make_rocking(settings)
        if self._time is not None:
            self._carry_over(rocking)
        self._settings, self._rocking = settings, rocking

    def _make_rocking(self, settings: FixedRockingSettings) -> Rocking:
        check(settings)
        rocking = Rocking(settings.amplitude, settings.period, settings.rounding)
        if rocking.acceleration > self._max_acceleration:
            raise InputError(
                f"FixedRocking: rounding = {settings.rounding:g} s: amplitude {settings.amplitude:g} rad and "
                f"period {settings.period:g} s need {rocking.acceleration:.3g} rad/s2, the top drive "
                f"has {self._max_acceleration:g} rad/s2; make rounding at least "
                f"{rocking.speed / self._max_acceleration:.3g} s")
        return rocking

    def _carry_over(self, rocking: Rocking) -> None:
        """Keep the phase of the cycle; the centre takes up the difference in angle and drives it back."""
        offset, _ = self._rocking.from_rest(self._elapsed)
        self._elapsed *= rocking.period / self._rocking.period
        jump = offset - rocking.from_rest(self._elapsed)[0]
        self._centre += jump
        self._pending -= jump

    def step(self, measurements: Measurements) -> RigCommand:
        """Return the next point of the trajectory.

        A clock that stands still or runs backwards holds the angle. Without the angle of the top drive, the drive is
        held and the block stopped until the angle is measured again.
        """
        step = 0.0 if self._time is None else measurements.time - self._time
        if not step >= 0.0:
            step = 0.0
        self._time = measurements.time
        if not math.isfinite(measurements.top_drive_angle):
            held = self._centre + self._rocking.from_rest(self._elapsed)[0]
            return RigCommand(held, 0.0, 0.0, self._settings.pump_speed)
        for sample in measurements.mwd:
            self._correct(sample)
        self._elapsed += step
        if self._has_torque_limits():
            self._reverse_on_torque(measurements.surface_torque)
        # With a torque limit the shift is driven as a bump; otherwise the centre moves.
        centre_speed = 0.0 if self._limit_was_met else self._move_centre(step)
        offset, speed = self._rocking.from_rest(self._elapsed)
        return RigCommand(self._centre + offset, speed + centre_speed,
                          self._settings.block_speed, self._settings.pump_speed)

    def _has_torque_limits(self) -> bool:
        return self._settings.right_torque_limit > 0.0 or self._settings.left_torque_limit > 0.0

    def _correct(self, sample: MwdSample) -> None:
        if not math.isfinite(sample.tool_face):
            return
        reference = self.tool_face_target if self._tool_face is None else self._tool_face
        self._tool_face = reference + math.remainder(sample.tool_face - reference, 2.0 * math.pi)
        self._pending += self._settings.shift_gain * (self.tool_face_target - self._tool_face)

    def _move_centre(self, step: float) -> float:
        """Drive the pending shift at `shift_speed`; returns the speed of the centre, rad/s."""
        move = math.copysign(min(abs(self._pending), self._settings.shift_speed * step), self._pending)
        self._centre += move
        self._pending -= move
        return move / step if step > 0.0 else 0.0

    def _reverse_on_torque(self, surface_torque: float) -> None:
        """End the stroke where torque meets its limit, or beyond it by a pending shift on that side."""
        offset, speed = self._rocking.from_rest(self._elapsed)
        angle = self._centre + offset
        if speed * self._side < 0.0:
            self._end_stroke(angle)
        if speed == 0.0:
            return
        self._side = math.copysign(1.0, speed)
        if abs(speed) < self._rocking.speed:
            return
        limit = self._settings.right_torque_limit if self._side > 0.0 else self._settings.left_torque_limit
        if self._limit_angle is None and limit > 0.0 and self._side * surface_torque >= limit:
            self._limit_angle = angle
        if self._limit_angle is None or self._bump_driven:
            return
        if self._side * (angle - self._limit_angle) >= max(0.0, self._side * self._pending):
            self._settle_bump(angle)
            self._start_peak(self._side, angle)

    def _end_stroke(self, angle: float) -> None:
        """The direction has changed; a bump that ended at the amplitude counts as far as it was driven."""
        self._limit_was_met = self._limit_angle is not None
        if self._limit_was_met and not self._bump_driven:
            self._settle_bump(angle)
        self._limit_angle, self._bump_driven = None, False

    def _settle_bump(self, angle: float) -> None:
        if self._limit_angle is not None:
            self._pending -= angle - self._limit_angle
            self._bump_driven = True

    def _start_peak(self, side: float, angle: float) -> None:
        """Set the clock to the start of this side's rounded peak; the centre keeps the angle continuous."""
        rocking = self._rocking
        peak = (1.25 if side > 0.0 else 1.75) * rocking.period
        self._elapsed = peak - rocking.rounding / 2.0
        self._centre = angle - rocking.from_rest(self._elapsed)[0]

    def status(self) -> tuple[Status, ...]:
        """Toolface, its error and the centre of rocking."""
        values = [("target_deg", f"{math.degrees(self.tool_face_target):.1f}"),
                  ("centre_rad", f"{self._centre:.3f}"), ("pending_shift_rad", f"{self._pending:.3f}")]
        if self._tool_face is None:
            return (Status(Level.WARN, "tool_face", "no MWD toolface yet: rocking about the start angle",
                           tuple(values)),)
        error = math.degrees(self._tool_face - self.tool_face_target)
        values += [(field.name, f"{getattr(self._settings, field.name):g}")
                   for field in dataclasses.fields(self._settings)]
        message = f"last MWD toolface {error:+.1f} deg off target"
        return (Status(Level.OK, "tool_face", message, tuple(values)),)
