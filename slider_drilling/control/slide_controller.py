"""The controller that holds the toolface while it rocks: estimate, feed forward, correct, and mind the limits."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slider_drilling.control import slide_status
from slider_drilling.control.block.block_control import BlockControl
from slider_drilling.control.block.heave_compensation import HeaveCompensator
from slider_drilling.control.estimation.breakover_test import SLOW_DOWN_TRAVEL_TIMES, BreakoverTest
from slider_drilling.control.estimation.calibrated_rig import calibrated_rig, with_worn_motor
from slider_drilling.control.estimation.cycle_average import CycleAverager
from slider_drilling.control.estimation.differential_pressure import DifferentialPressure
from slider_drilling.control.estimation.rocking_phase import RockingPhase, period_with_distinct_phases
from slider_drilling.control.estimation.tool_face_estimator import EstimatorNoise, ToolFaceEstimator
from slider_drilling.control.estimation.torque_and_drag import TorqueAndDrag
from slider_drilling.control.estimation.torque_sensor_model import TorqueSensorModel
from slider_drilling.control.interface import Measurements, RigCommand, Status
from slider_drilling.control.interlocks.measurement_monitor import MeasurementMonitor
from slider_drilling.control.interlocks.slide_interlocks import (
    HOLD_AFTER,
    Interlocks,
    Permission,
    StallGuard,
    StallState,
)
from slider_drilling.control.interlocks.torque_prediction import stroke_of
from slider_drilling.control.settings import check
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.control.top_drive.amplitude_adaptation import AmplitudeAdaptation
from slider_drilling.control.top_drive.centre_lead import ToolFaceResponse, centre_lead
from slider_drilling.control.top_drive.rocking_reference import DriveMode, RockingReference, RockingSetpoint
from slider_drilling.control.top_drive.torque_limited_reversal import TorqueLimitedReversal
from slider_drilling.wellbore.zones import Zones

if TYPE_CHECKING:
    from slider_drilling.rig import Rig

_PERIOD_PER_TRAVEL = 6.4     # best period of rocking over the time that torsion takes from top to bit
_RESPONSE_PER_TRAVEL = 38.0  # 1/s, lag of the toolface behind what pulls over the square of that time
_QUICKEST_SHARE = 0.75       # of that lag, below which no string follows: that of one rocked as deep as when being set
_LEAST_RESPONSE = 60.0       # s, believed before it is learnt: less makes short strings late to set
_SHORTEST_PERIOD = 6.0       # s
_NEAR, _FAR = math.radians(12.0), math.radians(45.0)   # errors between which holding turns into setting
_LOST_TURN = math.radians(200.0)   # of error: the nearest turn of the target is now another
_UNEXPLAINED = math.radians(0.8)   # of an MWD sample beside its noise
_HOLDS, _LEAST_MOBILITY = (0.25, 0.3), 0.1   # shares of drag: from there on, and beyond it all, pipe holds the bit
_HALF_LOADED = 0.5           # of the pressure wanted, from which on drag and swing tell the reach
_WALK, _DRIFT = math.radians(0.6), math.radians(0.15)   # per sqrt(s), of the string's twist and of the offset
_PULL_SHARE = 0.1            # of the twist that pulls, by which the string may be twisted otherwise
_MOVE_SHARE = 0.3            # of a move of the centre, that surface torque does not show at once
_MOST_TRIM = 1.0             # rad
_TEST_SPEED = 6.0            # rad/s, fastest stroke of the breakover test
_CENTRE_TIME = 1.0           # periods of rocking, in which the centre follows
_PRIOR_SPREAD = 0.25         # of ln(friction)
_QUICK, _SMOOTH = 0.5, 6.0   # s, filters of differential pressure
_RELEASED_SHARE = 0.25       # of the pressure wanted, at which the bit has let go
_CUT, _LEAST_BEARABLE, _REGAINED = 0.98, 0.3, 0.001   # of the amplitude: a stroke cut short, the least, per s
_MOVING_SHARE = 0.3          # of the amplitude while the string slides fast: it then turns easily
_LEAST_FLOW_SHARE = 0.3      # of the reference flow, below which the motor is not fed
_ACCELERATION_SHARE, _SPEED_SHARE = 0.9, 0.95   # of the top drive's limits, the rest is for following


class SlideController:
    """Rocks, holds `tool_face_target` (rad, may be set between any two steps) and drills by differential pressure.

    The centre of rocking is ``target + S T - b + K (target - x)``: x and b from the estimator, S T the twist that
    the reactive torque needs. What it asks of the top drive is continuous whatever the measurements do.
    """

    def __init__(self, rig: Rig, settings: SlideSettings | None = None, tool_face_target: float = 0.0):
        self.tool_face_target = tool_face_target
        self._given_rig = rig
        self._rig = rig = with_worn_motor(rig)
        s = self._settings = SlideSettings() if settings is None else settings
        check(s)
        self._interval = 1.0 / rig.sensors.rate
        self._reference_pump = rig.hydraulics.reference_flow / rig.mud_pump.displacement
        self._watch = MeasurementMonitor()
        self._pressure = DifferentialPressure(rig, s.off_bottom_pressure, _QUICK, _SMOOTH)
        self._lowering = BlockControl(rig, s)
        self._believe(s)
        mwd = rig.sensors.mwd
        sample = math.sqrt(mwd.noise**2 + mwd.resolution**2 / 12.0 + _UNEXPLAINED**2)
        noise = EstimatorNoise(sample, rig.sensors.surface_torque.noise, self._interval, _PULL_SHARE, _MOVE_SHARE,
                               _WALK, _DRIFT)
        self._estimator = ToolFaceEstimator(
            self._belief.compliance, self._response_time(), noise, bias=rig.effects.torque_sensor_bias.bias,
            quickest=_QUICKEST_SHARE * self._spreading_time())
        self._means = CycleAverager()
        self._phase = RockingPhase()
        self._reach = AmplitudeAdaptation()
        self._heave = HeaveCompensator(rig.string.axial_stiffness, s.compensation_speed)
        sensor = rig.sensors.surface_torque
        self._reading = TorqueSensorModel(self._belief.impedance, sensor.noise, self._interval, sensor.lag)
        self._torque = math.nan      # N m that the pipe takes, this sample; NaN where there is none
        self._strokes = 0            # of the drive, that the swing knows of
        stall = StallGuard(s.stall_share * rig.motor.max_pressure, _RELEASED_SHARE * self._lowering.wanted)
        self._interlocks = Interlocks(s.make_up_torque_limit, s.back_off_torque_limit, stall,
                                      _LEAST_FLOW_SHARE * self._reference_pump)
        self._torque_turn = TorqueLimitedReversal(s.right_reversal_torque, s.left_reversal_torque)
        self._permission = Permission(False, False, True)
        self._drive: RockingReference | None = None
        self._centre = 0.0           # rad, wished middle of rocking
        self._aim = 0.0              # rad, of the centre before the reactive twist
        self._trim = 0.0             # rad
        self._amplitude = 0.0        # rad
        self._bearable = math.inf    # rad, amplitude that the torque limits bear
        self._mwd_age = 0.0          # s since the last accepted sample was read
        self._target = self._asked = tool_face_target   # rad: the turn of the target that is nearest; as asked

    @property
    def settings(self) -> SlideSettings:
        """The settings in use."""
        return self._settings

    def configure(self, settings: SlideSettings) -> None:
        """Use other settings from the next step on; the motion goes on without a jump. Raises InputError."""
        check(settings)
        friction_changed = settings.friction_factor != self._settings.friction_factor
        s = self._settings = settings
        self._pressure.configure(self._rig, s.off_bottom_pressure)
        self._lowering.configure(self._rig, s)
        self._estimator.filter.response_time = self._response_time()
        self._heave.fastest = s.compensation_speed
        stall = self._interlocks.stall
        stall.limit = s.stall_share * self._rig.motor.max_pressure
        stall.released = _RELEASED_SHARE * self._lowering.wanted
        self._interlocks.make_up, self._interlocks.back_off = s.make_up_torque_limit, s.back_off_torque_limit
        self._torque_turn.right, self._torque_turn.left = s.right_reversal_torque, s.left_reversal_torque
        if friction_changed:
            self._believe(s)
        if self._drive is not None:
            self._drive.set_limits(self._max_speed(), self._max_acceleration())

    def _keep_reach(self, step: float) -> None:
        """Rock as deep as drag and swing ask for, while the bit is loaded; see whether weight arrives."""
        lowering, hook_load, pressure = self._lowering, self._fresh("hook_load"), self._pressure.smooth
        if self._testing():
            lowering.drag.tare(hook_load, step)
            return
        lowering.weigh(hook_load, pressure, self._estimator.filter.estimate, self._finder.friction_scale, step)
        if lowering.approach.under_way or not self._permission.lower:
            return
        lowering.judge(pressure, step)
        estimator = self._estimator
        self._reach.check_response(estimator.pull, self._response_time(), estimator.tool_face, self.error, step)
        if pressure > _HALF_LOADED * lowering.wanted:
            share, string = lowering.drag.share if math.isfinite(lowering.drag.share) else 0.0, estimator.filter
            estimator.mobility = min(max(1.0 - (share - _HOLDS[0]) / _HOLDS[1], _LEAST_MOBILITY), 1.0)
            self._reach.update(share, lowering.drag.certain, string.swing, string.swing_sigma, step)

    def _believe(self, s: SlideSettings) -> None:
        """Torque and drag from the rig file, to be corrected by the breakover test."""
        self._belief = TorqueAndDrag(self._rig, s.friction_factor, self._lowering.weight_wanted)
        self._finder = BreakoverTest(TorqueAndDrag(self._rig, s.friction_factor, 0.0), _PRIOR_SPREAD)

    def _response_time(self) -> float:
        """s, as believed before it is learnt."""
        return self._settings.response_time or max(self._spreading_time(), _LEAST_RESPONSE)

    def _spreading_time(self) -> float:
        """s; rocking lets twist spread along a long string as heat does in a rod: with the square of its length."""
        return _RESPONSE_PER_TRAVEL * self._belief.travel_time**2

    def _max_speed(self) -> float:
        return min(self._settings.max_rocking_speed, _SPEED_SHARE * self._rig.top_drive.max_speed)

    def _max_acceleration(self) -> float:
        return min(self._settings.rounding_acceleration, _ACCELERATION_SHARE * self._rig.top_drive.max_acceleration)

    def step(self, measurements: Measurements) -> RigCommand:
        """The next point of the trajectory, the block's and the pump's speed."""
        watch = self._watch
        watch.update(measurements, self._interval)
        drive = self._started()
        torque = self._fresh("surface_torque")
        self._torque = self._reading.pipe_torque(measurements.top_drive_speed, torque, watch.step)
        pressure, pump = self._fresh("standpipe_pressure"), watch.value["pump_speed"]
        if self._testing():
            self._pressure.tare(pressure, pump, watch.step)
        self._pressure.update(pressure, pump, watch.step)
        self._estimate(measurements, drive)
        waited, behind = watch.step or self._interval, watch.value["top_drive_angle"] - drive.angle
        self._permission = self._interlocks.update(watch, waited, self._pressure.quick, self._mwd_age, behind)
        self._rock(drive)
        pump_speed = self._settings.pump_speed or self._reference_pump
        moving = self._permission.lower and not self._testing() and not self._lowering.lock_up.stops
        wave = self._heave.update(self._fresh("hook_load"), self._period_now(), moving, watch.step)
        lower = self._lowering.held(self._lower(), self._fresh("block_position") - self._heave.moved, watch.step)
        return RigCommand(drive.angle, drive.speed, lower + wave, pump_speed)

    def _started(self) -> RockingReference:
        """The reference, which begins at the angle that the top drive has."""
        if self._drive is None:
            angle = self._watch.value["top_drive_angle"]
            self._centre = self._aim = angle if math.isfinite(angle) else 0.0
            self._drive = RockingReference(self._max_speed(), self._max_acceleration(), self._centre)
        return self._drive

    def _estimate(self, m: Measurements, drive: RockingReference) -> None:
        watch, estimator = self._watch, self._estimator
        if watch.jumped:
            estimator.reset_clock(watch.time)
        self._mwd_age += watch.step
        estimator.sliding = self._lowering.approach.fast
        estimator.settled = self._drilling()
        if math.isfinite(watch.time):
            estimator.advance(watch.time, self._pressure.reactive_torque)
            if drive.strokes != self._strokes:
                self._strokes = drive.strokes
                self._phase.add_reversal(watch.time)
            cycle = self._means.update(watch.step, self._fresh("top_drive_angle"), self._torque,
                                       self._pressure.quick_reactive_torque, drive.strokes)
            if cycle is not None:
                estimator.update_with_cycle(watch.time, cycle, self._carried(), self.tool_face_target)
        for sample in m.mwd:
            if estimator.update_with_mwd(sample, self.tool_face_target, self._phase.at(sample.measured_at)):
                self._mwd_age = max(watch.time - sample.measured_at, 0.0)
        self._choose_turn()

    def _drilling(self) -> bool:
        """Whether the bit is loaded and the string slides after it."""
        return self._permission.lower and self._lowering.loaded(self._pressure.smooth)

    def _carried(self) -> float:
        """Share of the string's compliance that carries the mean torque of surface; half of the static zone does."""
        return 0.5 + 0.5 * self._belief.compliance_at(self.zones().rocked_to) / self._belief.compliance

    def _fresh(self, channel: str) -> float:
        """This sample's value of a channel, NaN where it has none."""
        return self._watch.value[channel] if self._watch.age[channel] == 0.0 else math.nan

    def _choose_turn(self) -> None:
        """The turn of the target nearest to the toolface: when that is first known, when a target is asked for, and
        when a turn was lost."""
        if not self._estimator.known or not math.isfinite(self.tool_face_target) or self._lowering.approach.fast:
            return
        tool_face = self._estimator.tool_face
        if self.tool_face_target != self._asked:
            self._lowering.lock_up.release()
        if self.tool_face_target != self._asked or abs(self._target - tool_face) > _LOST_TURN:
            self._asked = self.tool_face_target
            self._target = tool_face + math.remainder(self._asked - tool_face, 2.0 * math.pi)

    @property
    def error(self) -> float:
        """Target minus estimated toolface, rad; 0 before that is known."""
        return self._target - self._estimator.tool_face if self._estimator.known else 0.0

    def zones(self) -> Zones:
        """The three zones as believed now: how deep rocking reaches, how far up the reactive torque."""
        return self._belief.zones(self._amplitude, self._pressure.reactive_torque, self._finder.friction_scale)

    def _rock(self, drive: RockingReference) -> None:
        step = self._watch.step
        self._keep_reach(step)
        if self._may_shift():
            self._steer(step)
        self._amplitude = self._borne(self._wished_amplitude(), step)
        landing = SLOW_DOWN_TRAVEL_TIMES * self._belief.travel_time if self._testing() else 0.0
        wish = RockingSetpoint(self._centre, self._amplitude, self._period_now(), landing)
        if self._must_turn(drive, wish):
            drive.reverse()
        drive.advance(step, wish, self._motion())
        if self._motion() is DriveMode.ROCK:
            late = self._reading.likeliest_lag / self._interval
            self._finder.update(drive.angle, self._torque, drive.strokes, late)

    def _borne(self, wished: float, step: float) -> float:
        """Amplitude (rad) that the torque limits bear; it and the pressure that they bear are regained slowly."""
        hold = self._amplitude_for(self._settings.holding_amplitude_share)
        self._bearable = max(self._bearable, _LEAST_BEARABLE * hold) * (1.0 + _REGAINED * step)
        self._lowering.regain(step)
        return min(wished, self._bearable)

    def _may_shift(self) -> bool:
        """The centre is held while a measurement is missing or the drive parks, and during the breakover test."""
        missing = max(*self._watch.age.values(), self._watch.clock_age) > HOLD_AFTER
        return self._motion() is DriveMode.ROCK and not missing and not self._testing()

    def _testing(self) -> bool:
        return self._finder.running and self._settings.amplitude == 0.0

    def _must_turn(self, drive: RockingReference, wish: RockingSetpoint) -> bool:
        stroke, reading = stroke_of(drive, wish, self._max_acceleration(), self._reading), self._reading
        trips = self._interlocks.torque_trips
        # A bias that was learnt of the sensor counts where it hides torque, not where it would leave room for more.
        hidden = stroke.side * max(-stroke.side * self._estimator.filter.estimate.bias, 0.0)
        from_below = reading.torque_from_below(self._torque) + hidden
        limited = self._interlocks.must_reverse(from_below, stroke, self._watch.step)
        if self._interlocks.torque_trips > trips:
            # Less of the reactive torque leaves room to rock.
            self._bearable = _CUT * self._amplitude
            self._lowering.ease()
        if stroke.speed <= 0.0:
            return False
        return self._torque_turn.must_reverse(drive.angle, self._torque, drive.side, self._centre) or limited

    def _motion(self) -> DriveMode:
        if not self._permission.rock:
            return DriveMode.FREEZE
        return DriveMode.PARK if self._settings.rocking < 0.5 else DriveMode.ROCK

    def _steer(self, step: float) -> None:
        """Move the centre: the reactive twist at once, what the toolface asks for within a period of rocking."""
        wanted = self._aim
        if self._estimator.known:
            self._trim_pull(step)
            wanted = self._target - self._estimator.offset + self._lead() + self._trim
        share = 1.0 - math.exp(-step / (_CENTRE_TIME * self._period_now()))
        self._aim += share * (wanted - self._aim)
        string = self._estimator.filter
        twist = string.compliance * string.motor_gain * self._expected_torque()
        self._centre = self._aim + self._settings.feed_forward * twist

    def _lead(self) -> float:
        """rad, for the error of the toolface."""
        if self._lowering.approach.fast:
            # While the string slides fast it turns freely, and means over a stroke say little.
            return 0.0
        s, estimator, mwd = self._settings, self._estimator, self._rig.sensors.mwd
        response, cycle = estimator.filter.estimate.response_time, self._period_now()
        answer = ToolFaceResponse(response, cycle, mwd.period + mwd.latency, estimator.sigma, self._amplitude_for(1.0))
        return centre_lead(self.error, (1.0 + self._reach.gain_boost) * s.gain, s.max_lead, answer)

    def _trim_pull(self, step: float) -> None:
        """What friction leaves of a pull where the toolface has come to rest: slow, bounded, near the target only."""
        if abs(self.error) < _NEAR and self._permission.lower:
            self._trim += self._settings.trim_rate * self.error * step
            self._trim = min(max(self._trim, -_MOST_TRIM), _MOST_TRIM)

    def _expected_torque(self) -> float:
        """Reactive torque (N m) on its way: what pressure shows, or midway from there to more that it is driven to."""
        if self._lowering.approach.under_way:
            # A stalled motor lets go of the string when the bit does, before pressure can tell.
            return 0.0
        measured = self._pressure.reactive_torque
        return max(measured, 0.5 * (measured + self._rig.motor.torque_per_pressure * self._lowering.driller.setpoint))

    def _wished_amplitude(self) -> float:
        s = self._settings
        if s.amplitude > 0.0:
            return s.amplitude
        if self._testing():
            return self._amplitude_for(s.holding_amplitude_share)
        if self._lowering.approach.fast:
            return self._amplitude_for(_MOVING_SHARE * s.holding_amplitude_share)
        if self._lowering.approach.under_way:
            return self._amplitude_for(s.setting_amplitude_share)
        weight = min(max((abs(self.error) - _NEAR) / (_FAR - _NEAR), 0.0), 1.0)
        holding, setting = s.holding_amplitude_share, s.setting_amplitude_share
        return self._amplitude_for(holding + (setting - holding) * weight)

    def _amplitude_for(self, share: float) -> float:
        """rad; `share` of the amplitude that frees the whole string, as its friction is known."""
        scale = 1.0 if self._testing() else self._finder.friction_scale
        return share * self._reach.factor * self._belief.full_amplitude(scale)

    def _period_now(self) -> float:
        """s; longer than the best one where the drive could not make the amplitude in it."""
        wanted = self._settings.period
        if wanted <= 0.0:
            wanted = max(_PERIOD_PER_TRAVEL * self._belief.travel_time, _SHORTEST_PERIOD)
            wanted = period_with_distinct_phases(wanted, self._rig.sensors.mwd.period)
            if self._testing():
                wanted = max(wanted, 4.0 * self._amplitude / _TEST_SPEED)
        return max(wanted, 4.0 * self._amplitude / self._max_speed())

    def _lower(self) -> float:
        """Block speed, m/s."""
        if self._permission.pick_up:
            return self._lowering.pick_up()
        if self._interlocks.stall.state is not StallState.NONE:
            return self._lowering.rest()
        if not self._permission.lower or self._testing() or self._motion() is not DriveMode.ROCK:
            return 0.0
        return self._lowering.speed(self._pressure, self._watch.value["block_position"], self.error, self._watch.step)

    def status(self) -> tuple[Status, ...]:
        """The toolface and its error, what was learnt of the string, the zones, every interlock with its reason."""
        zones, lowering = self.zones(), self._lowering
        return (
            slide_status.of_tool_face(self._estimator, self._target, self._centre, self._pressure.reactive_torque),
            slide_status.of_string(self._estimator),
            slide_status.of_reach(zones, self._belief.bit_depth, self._amplitude, self._period_now(), self._finder,
                                  self._reach, self._estimator, lowering),
            slide_status.of_heave(self._heave),
            slide_status.of_lock_up(lowering.lock_up, lowering.drag),
            slide_status.of_slip(lowering.slip),
            *self._interlocks.statuses())

    def corrected_rig(self) -> Rig:
        """The rig file with what was learnt of the string so far."""
        return calibrated_rig(self._given_rig, self._estimator.filter.estimate)
