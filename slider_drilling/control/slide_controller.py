"""The controller that holds the toolface while it rocks and drills by differential pressure.

Each step estimates the state of the slide, checks the interlocks, moves the top drive and then the block:

* `estimation`: toolface, string, friction, drag, pressure;
* `interlocks`: what the block and the top drive may do;
* `top_drive`: amplitude and centre of rocking;
* `block`: auto-driller, return to bottom, heave compensation.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

from slider_drilling.control import slide_status
from slider_drilling.control.block.block_control import BlockControl
from slider_drilling.control.block.heave_compensation import HeaveCompensator
from slider_drilling.control.estimation.calibrated_rig import calibrated_rig, with_worn_motor
from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.slide_state import SlideState
from slider_drilling.control.interface import Measurements, RigCommand, Status
from slider_drilling.control.interlocks.motor_stall import StallGuard, StallState
from slider_drilling.control.interlocks.slide_interlocks import (
    HOLD_AFTER,
    MIN_FLOW_SHARE,
    MIN_RATE,
    Interlocks,
    Permission,
)
from slider_drilling.control.load_supervision import LoadSupervision
from slider_drilling.control.settings import check
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.control.top_drive.amplitude_control import AmplitudeControl
from slider_drilling.control.top_drive.centre_control import CentreControl
from slider_drilling.control.top_drive.rocking_reference import (
    DriveMode,
    RockingReference,
    RockingSetpoint,
    stroke_of,
)
from slider_drilling.control.top_drive.torque_limited_reversal import TorqueLimitedReversal
from slider_drilling.errors import InputError
from slider_drilling.wellbore.zones import Zones

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_LOST_TURN = math.radians(200.0)   # rad of error: another turn of the target is nearer now
# The more pipe drags, the less of the driving twist turns the bit: mobility falls from this share of drag on, to its
# minimum over this range.
_HELD_DRAG, _HELD_RANGE, _MIN_MOBILITY = 0.25, 0.3, 0.1
_HOLDING_DRAG = 0.15         # share of drag, below which contacts do not hold a loaded bit
_HALF_LOADED = 0.5           # of the target pressure, above which drag and swing show the reach of rocking
_RELEASED_SHARE = 0.25       # of the target pressure, below which the bit is off bottom


class SlideController:
    """Holds a toolface by rocking and drills by differential pressure.

    The command for the top drive is continuous, whatever the measurements do.

    Args:
        rig: Rig file.
        settings: Settings of the slide; the defaults suit any rig.
        tool_face_target: rad.

    Attributes:
        tool_face_target: rad; may be set between any two steps.

    Raises:
        InputError: A setting is out of its range, or the rig's sensors are too slow.
    """

    def __init__(self, rig: Rig, settings: SlideSettings | None = None, tool_face_target: float = 0.0):
        if rig.sensors.rate < MIN_RATE:
            raise InputError(f"SlideController: sensors.rate = {rig.sensors.rate:g} Hz: must be at least {MIN_RATE:g}, "
                             "or strokes and torque limits are not followed; sample the surface channels faster")
        self.tool_face_target = tool_face_target
        self._rig_file = rig
        self._rig = rig = with_worn_motor(rig)
        self._settings = settings = SlideSettings() if settings is None else settings
        check(settings)
        self._reference_pump_speed = rig.reference_pump_speed
        self._block = BlockControl(rig, settings)
        self._amplitude = AmplitudeControl(rig, settings, self._block.target_weight_on_bit)
        self._centre = CentreControl(rig, settings)
        self._state = SlideState(rig, settings, self._amplitude.model)
        self._heave = HeaveCompensator(rig.string.axial_stiffness, settings.compensation_speed)
        stall = StallGuard(
            settings.stall_share * rig.motor.max_pressure, _RELEASED_SHARE * self._block.target_pressure)
        self._interlocks = Interlocks(settings.make_up_torque_limit, settings.back_off_torque_limit, stall,
                                      MIN_FLOW_SHARE * self._reference_pump_speed)
        self._reversal = TorqueLimitedReversal(settings.right_reversal_torque, settings.left_reversal_torque)
        self._load = LoadSupervision(rig, settings, self._block, self._state.pressure)
        self._permission = Permission(False, False, True)
        self._block_command = 0.0   # m/s, without heave compensation
        self._is_tested = False   # whether a breakover test off bottom has ended
        self._reference: RockingReference | None = None   # made at the first step
        self._target = tool_face_target            # rad, on the turn nearest to the toolface
        self._requested_target = tool_face_target  # rad, that `_target` was made from

    @property
    def settings(self) -> SlideSettings:
        """The settings in use."""
        return self._settings

    def configure(self, settings: SlideSettings) -> None:
        """Use other settings from the next step on; the motion stays continuous.

        Raises:
            InputError: A setting is out of its range; nothing has changed.
        """
        check(settings)
        self._settings = settings
        self._block.configure(self._rig, settings)
        self._amplitude.configure(settings, self._block.target_weight_on_bit)
        self._centre.settings = settings
        self._load.configure(settings, self._block)
        self._state.configure(self._rig, settings)
        self._heave.max_speed = settings.compensation_speed
        stall = self._interlocks.stall
        stall.limit = settings.stall_share * self._rig.motor.max_pressure
        stall.released = _RELEASED_SHARE * self._block.target_pressure
        self._interlocks.make_up, self._interlocks.back_off = (
            settings.make_up_torque_limit, settings.back_off_torque_limit)
        self._reversal.right, self._reversal.left = settings.right_reversal_torque, settings.left_reversal_torque
        if self._reference is not None:
            self._reference.set_limits(self._amplitude.max_speed, self._amplitude.max_acceleration)

    def step(self, measurements: Measurements) -> RigCommand:
        """Return the next point of the rocking reference, the block speed and the pump speed."""
        state = self._state
        state.read(measurements, self._hangs)
        reference = self._started_reference()
        cycle = self._estimate_tool_face(measurements, reference)
        tracking_error = state.monitor.value["top_drive_angle"] - reference.angle
        pump_speed = self._settings.pump_speed or self._reference_pump_speed
        if not state.monitor.clock_age:
            self._interlocks.drives.update_pump(state.monitor.value["pump_speed"], pump_speed, state.monitor.step)
        self._permission = self._interlocks.update(
            state.monitor, state.elapsed, state.pressure.quick, state.mwd_age, tracking_error, state.mwd_stuck,
            state.tool_face.replaced_by)
        self._adapt_to_drag()
        if self._amplitude.testing:
            if cycle is not None and self._hangs:
                self._load.take_unloaded(cycle)
        else:
            self._is_tested = True
            lead = self._centre.lead(self.error, state.tool_face, self._amplitude) if state.tool_face.known else 0.0
            self._load.update(state, self._block, cycle, self.error, lead)
        self._rock(reference)
        return RigCommand(reference.angle, reference.speed, self._block_speed(), pump_speed)

    def _started_reference(self) -> RockingReference:
        """The reference, which starts at the angle of the top drive."""
        if self._reference is None:
            angle = self._state.monitor.value["top_drive_angle"]
            self._centre.start(angle if math.isfinite(angle) else 0.0)
            self._reference = RockingReference(
                self._amplitude.max_speed, self._amplitude.max_acceleration, self._centre.centre)
        return self._reference

    def _estimate_tool_face(self, measurements: Measurements, reference: RockingReference) -> CycleAverage | None:
        """Advance the toolface; returns the average of the rocking cycle that has just ended, or None."""
        state, estimator = self._state, self._state.tool_face
        estimator.sliding_fast = self._block.return_to_bottom.fast
        estimator.error = self.error
        estimator.torn_loose = self._amplitude.adaptation.tears_loose
        estimator.bit_loaded = self._permission.lower and self._block.loaded(state.pressure.smooth)
        cycle = state.advance(reference.strokes)
        if cycle is not None:
            if not self._amplitude.testing and (jump := self._load.torque_jump(
                    cycle, estimator.filter.compliance, self._block.return_to_bottom.under_way)):
                estimator.shift_torque(jump)
            torque_share = self._amplitude.torque_share(state.pressure.reactive_torque)
            believed = cycle if state.pressure.assumed is None else dataclasses.replace(
                cycle, reactive_torque=state.pressure.reactive_torque)
            estimator.update_with_cycle(state.monitor.time, believed, torque_share, self.tool_face_target)
        state.take_mwd(measurements.mwd, self.tool_face_target)
        self._choose_turn()
        return cycle

    def _choose_turn(self) -> None:
        """Take the turn of the target nearest to the toolface.

        This happens when the toolface is first known, at a new target, and when a whole turn was lost.
        """
        estimator = self._state.tool_face
        if not estimator.known or not math.isfinite(self.tool_face_target) or self._block.return_to_bottom.fast:
            return
        tool_face, changed = estimator.tool_face, self.tool_face_target != self._requested_target
        if changed:
            self._block.lock_up.release()
        if changed or abs(self._target - tool_face) > _LOST_TURN:
            self._requested_target = self.tool_face_target
            self._target = tool_face + math.remainder(self._requested_target - tool_face, 2.0 * math.pi)

    @property
    def _hangs(self) -> bool:
        """Whether the string hangs off bottom, as in the first breakover test; a later one finds it on bottom."""
        return self._amplitude.testing and not self._is_tested

    @property
    def error(self) -> float:
        """Target minus estimated toolface, rad; 0 before the toolface is known."""
        estimator = self._state.tool_face
        return self._target - estimator.tool_face if estimator.known else 0.0

    @property
    def tool_face_sigma(self) -> float:
        """One standard deviation of the estimated toolface, rad; infinite before the toolface is known."""
        estimator = self._state.tool_face
        return estimator.sigma if estimator.known else math.inf

    @property
    def drills(self) -> bool:
        """Whether the bit is on bottom with nearly the pressure that is asked for."""
        return self._block.loaded(self._state.pressure.smooth)

    @property
    def weight_on_bit(self) -> float:
        """Larger weight on bit of those that pressure and hook load show, N."""
        by_pressure = self._block.auto_driller.weight_per_pressure * self._state.pressure.quick
        by_hook_load = self._load.check.weight
        return max(by_pressure, by_hook_load) if math.isfinite(by_hook_load) else by_pressure

    @property
    def parked(self) -> bool:
        """Whether the top drive stands still because the setting `rocking` is 0."""
        return self._settings.rocking < 0.5 and self._reference is not None and self._reference.speed == 0.0

    def start_off_bottom(self, touching_position: float, hook_load: float) -> None:
        """Say before the first step that the bit was lifted, which leaves drag in the hook load.

        The bit then goes quickly to just above bottom, as after a stall.

        Args:
            touching_position: Of the block where the bit touches bottom, m.
            hook_load: Of the string off bottom, free of drag, N.
        """
        self._block.return_to_bottom.start_off_bottom(touching_position)
        self._block.drag.start_tared(hook_load)

    def zones(self) -> Zones:
        """The three zones as estimated now: the reach of rocking and of the reactive torque."""
        return self._amplitude.zones(self._state.pressure.reactive_torque)

    def _adapt_to_drag(self) -> None:
        """Update drag, lock-up and the adaptation of the amplitude; off bottom, tare the hook load."""
        state, block, step = self._state, self._block, self._state.monitor.step
        estimator, pressure, hook_load = state.tool_face, state.pressure.smooth, state.monitor.fresh("hook_load")
        if self._amplitude.testing:
            if self._hangs:
                block.drag.tare(hook_load, step)
            return
        string = estimator.filter
        block.update_drag(hook_load, pressure, string.estimate, self._amplitude.test.friction_scale, step)
        if block.return_to_bottom.under_way or not self._permission.lower:
            return
        block.update_lock_up(pressure, step)
        adaptation = self._amplitude.adaptation
        loaded = pressure > _HALF_LOADED * block.target_pressure
        adaptation.check_response(
            estimator.driving_twist, string.response_time, estimator.tool_face, self.error,
            self._may_tear_loose(loaded), step)
        if loaded:
            drag = block.drag.share if math.isfinite(block.drag.share) else 0.0
            estimator.mobility = min(max(1.0 - (drag - _HELD_DRAG) / _HELD_RANGE, _MIN_MOBILITY), 1.0)
            adaptation.update(drag, block.drag.share_lower_bound, string.swing, string.swing_sigma, step)

    def _may_tear_loose(self, loaded: bool) -> bool:
        """Whether strokes may grow to tear a stuck bit loose: pipe drags that holds it, and the drag may let go."""
        drag = self._block.drag
        return not (drag.room(self._block.weight_limit) < 0.0 or (loaded and drag.share < _HOLDING_DRAG))

    def _rock(self, reference: RockingReference) -> None:
        """Advance the reference by one sample."""
        state, amplitude, step = self._state, self._amplitude, self._state.monitor.step
        if self._may_move_centre():
            self._centre.update(self._target, state.tool_face, amplitude, self._block, state.pressure,
                                self._permission.lower, step)
        amplitude.update(self.error, self._block.return_to_bottom, step)
        self._block.restore_pressure(step)
        setpoint = RockingSetpoint(
            self._centre.centre, amplitude.amplitude, amplitude.period, amplitude.slow_down_time)
        if self._must_reverse(reference, setpoint):
            reference.reverse()
        reference.advance(step, setpoint, self._drive_mode())
        if self._drive_mode() is DriveMode.ROCK:
            sensor_lag = state.torque_sensor.most_likely_lag / state.interval
            amplitude.test.update(reference.angle, state.pipe_torque, reference.strokes, sensor_lag)

    def _may_move_centre(self) -> bool:
        """The centre stays while a measurement is missing, the drive parks, or the breakover test runs."""
        monitor = self._state.monitor
        missing = max(*monitor.age.values(), monitor.clock_age) > HOLD_AFTER
        return self._drive_mode() is DriveMode.ROCK and not missing and not self._amplitude.testing

    def _must_reverse(self, reference: RockingReference, setpoint: RockingSetpoint) -> bool:
        """Whether the stroke must end now: at a torque limit, or where torque-limited rocking reverses it."""
        state, sensor = self._state, self._state.torque_sensor
        stroke = stroke_of(reference, setpoint, self._amplitude.max_acceleration, sensor)
        trips = self._interlocks.torque_trips
        # An estimated sensor bias counts where it hides torque, not where it would leave more room.
        hidden = stroke.side * max(-stroke.side * state.tool_face.filter.estimate.bias, 0.0)
        from_below = sensor.torque_from_below(state.pipe_torque) + hidden
        at_limit = self._interlocks.must_reverse(from_below, stroke, state.monitor.step)
        if self._interlocks.torque_trips > trips:
            # Less reactive torque leaves more of the limit for rocking.
            self._amplitude.reduce()
            self._block.reduce_pressure()
        if stroke.speed <= 0.0:
            return False
        reversal = self._reversal.must_reverse(
            reference.angle, state.pipe_torque, reference.side, self._centre.centre)
        return reversal or at_limit

    def _drive_mode(self) -> DriveMode:
        if not self._permission.rock:
            return DriveMode.FREEZE
        return DriveMode.PARK if self._settings.rocking < 0.5 else DriveMode.ROCK

    def _block_speed(self) -> float:
        """Block speed with heave compensation and slip correction, m/s."""
        monitor, block = self._state.monitor, self._block
        may_move = self._permission.lower and not self._amplitude.testing and not block.lock_up.stops
        wave = self._heave.update(monitor.fresh("hook_load"), self._amplitude.period, may_move, monitor.step)
        position = monitor.fresh("block_position") - self._heave.moved
        speed = block.correct_slip(self._lowering_speed(), position, monitor.step)
        self._interlocks.drives.update_block(position, self._block_command, monitor.step)
        self._block_command = speed
        return speed + wave

    def _lowering_speed(self) -> float:
        """Block speed by the interlocks and the auto-driller, m/s."""
        if self._permission.pick_up:
            return self._block.pick_up()
        if self._interlocks.stall.state is not StallState.NONE:
            return self._block.rest()
        if not self._permission.lower or self._amplitude.testing or self._drive_mode() is not DriveMode.ROCK:
            return 0.0
        if self._load.stops:
            self._block.auto_driller.track(self._state.pressure.smooth)
            return 0.0
        monitor = self._state.monitor
        block, pressure = self._block, self._state.pressure
        highest = self._load.check.weight_after_release(
            block.auto_driller.weight_per_pressure * pressure.smooth, block.drag.highest_deficit)
        return block.speed(pressure, monitor.value["block_position"], self.error,
                           self._amplitude.adaptation.tears_loose, highest, monitor.step)

    def status(self) -> tuple[Status, ...]:
        """Toolface and its error, the string, the zones, and every interlock with its reason."""
        state, block = self._state, self._block
        return (
            slide_status.tool_face_status(
                state.tool_face, self._target, self._centre.centre, state.pressure.reactive_torque),
            slide_status.string_status(state.tool_face.filter),
            slide_status.reach_status(self.zones(), self._amplitude, state.tool_face.filter, block),
            slide_status.heave_status(self._heave),
            slide_status.lock_up_status(block.lock_up, block.drag),
            slide_status.slip_status(block.slip),
            *self._load.statuses(),
            *self._interlocks.statuses())

    def calibrated_rig(self) -> Rig:
        """The rig file with what the slide has shown of the string so far."""
        return calibrated_rig(self._rig_file, self._state.tool_face.filter.estimate)
