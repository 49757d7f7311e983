"""Load check: lowering stops when the channels that show the load contradict each other by more than they can be wrong.

Pressure, torque and hook load each show the weight on bit (`load_evidence`). With one of them wrong, the other two and
the rate of penetration say which one, and how it went says why: see `LoadFault`. Weight by hook load and by torque is
bounded whatever pressure says.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace

from slider_drilling.control.estimation.load_evidence import RATE_WINDOW, LoadChange, LoadEvidence, LoadSample

_TORQUE_SIGMAS = 500.0      # N m, how far torque and pressure may disagree: bias, a toolface that creeps, noise
_SAFE_SIDE = 2.0            # times that, where torque stands for less than pressure: the weight is then too small
# Share of the target torque besides, until the reference period has ended: a held bit. It falls to none in this time
# (s), because a bit that is held for so long and pressure that is lost look the same.
_UNKNOWN_SCALE, _UNKNOWN_TIME = 0.6, 400.0
_HOLDING = 1.8              # times that, where contacts were seen to hold the bit: the wall carries torque
_LEAD_SHARE = 0.5           # of the lead over the compliance: torque that the wall holds near the bit
_CONFIRM_TIME = 20.0        # s of contradiction, less a quarter of those without, before it counts
_FORGET_SHARE = 0.25
_MAX_DOUBT_SHARE = 0.15     # of the target torque: the most that a turning or wound string may excuse
# The reference needs a toolface this close to its target, and no more other torque than this share of the motor's.
_REFERENCE_ERROR, _REFERENCE_SHARE = math.radians(8.0), 0.15
_SETTING_ERROR = math.radians(30.0)   # rad of toolface; the torque of a string that is being turned says little
_ONSET_SHARE = 0.3          # of the tolerance, at which a contradiction begins
_CLEAR = 0.5   # difference of squared misfits, below which the more dangerous cause is named: lost pressure
# N of drag; shares of the target weight: that other rock makes in the rate, and compliance and contacts in the twist.
_HOOK_SIGMA, _RATE_SIGMA, _TWIST_SIGMA = 20e3, 0.12, 0.15
# Drag outside of these is none that pipe can have, so the hook load is wrong: least, as a share of the target weight
# (drag is never negative, but the weight by pressure may be too large by twice the spread of motors and bits); most, as
# a share of the drag of a string that does not rotate; and besides, N.
_MIN_DRAG_SHARE, _MAX_DRAG_SHARE, _HOOK_TOLERANCE = -0.2, 1.25, 12e3
# After a jump less is enough, because learnt drag follows it: change within seconds and afterwards, as shares of the
# target weight, and s for which the first is remembered.
_HOOK_JUMP_SHARE, _AFTER_JUMP_SHARE, _HOOK_JUMP_MEMORY = 0.25, 0.3, 120.0
_JUMP_SHARE = 0.4           # of the target weight, by which weight by hook load may exceed the other two
LET_GO_SHARE = 0.85         # of the drag, the most that rocking was seen to let go at once
_RELEASE_SHARE = 0.92       # of the weight limit, below which lowering goes on
# A sudden change of pressure that the hook load does not show: time constants of the averages that are compared, and
# shares of the target weight. Drag that lets go turns into weight on the bit, so a rise may be larger by most of it.
_QUICK_TIME, _SLOW_TIME = 3.0, 20.0   # s
_SUDDEN_CHANGE, _SUDDEN_FALL, _SUDDEN_RISE, _RELEASED_DRAG = 0.2, 0.25, 0.25, 0.7
_FIRST_SUDDEN_FALL = 0.4    # before the reference
_HOLD_TIME = 40.0           # s until the change counts as a fault, if it stays


class LoadFault(enum.Enum):
    """What the channels contradict each other by, and what that means."""

    WASHOUT = "a washout, or a transmitter that drifts down: compare pump strokes and flow, look for a leak"
    PLUGGED_NOZZLE = "a plugged nozzle"
    LOST_STROKES = "a pump that loses strokes (valve, suction) or counts too many: check the pump and its counter"
    TRANSMITTER = "a transmitter that drifts up: compare it with another gauge"
    TORQUE = "the torque sensor is wrong"
    HOOK_LOAD = "the hook-load sensor is wrong, or pipe is stuck"


@dataclass(frozen=True)
class LoadTrip:
    """A latched contradiction.

    Attributes:
        fault: Its most likely cause.
        message: Figures of the channels.
    """

    fault: LoadFault
    message: str


@dataclass(frozen=True)
class LoadConditions:
    """What the slide does while a cycle is checked.

    Attributes:
        loaded: Whether the bit is loaded with the pressure that is asked for.
        checked: Whether the channels can be compared: the bit on bottom, no measurement missing.
        error: Of the toolface, rad.
        lead_torque: Lead of the centre over the compliance of the string, N m, positive right.
        turning_torque: Torque that turns the toolface at its present rate, N m, positive right.
        full_drag: Drag of a string that does not rotate, N.
        held: Whether contacts hold the bit against the twist that should turn it.
        slowed: Whether drag that may let go keeps the weight down, so that hook load and rate follow pressure.
    """

    loaded: bool
    checked: bool
    error: float
    lead_torque: float
    turning_torque: float
    full_drag: float
    held: bool = False
    slowed: bool = False


class LoadCheck:
    """Compares the channels and stops lowering.

    Args:
        evidence: Load by the channels.
        target_weight: On the bit, N.
        target_torque: Reactive torque at this weight, N m.
        limit: Largest weight on bit, N.

    Attributes:
        evidence: Load by the channels.
        limit: Largest weight on bit, N.
        trip: The latched contradiction, or None.
        weight: Weight on bit by hook load, N; NaN where unknown.
        over_limit: Whether weight by hook load or by torque is at its limit.
        tolerance: By how much torque may stand for more than pressure, N m.
        tolerance_below: By how much it may stand for less, N m.
    """

    def __init__(self, evidence: LoadEvidence, target_weight: float, target_torque: float, limit: float):
        self.evidence = evidence
        self.target_weight = target_weight
        self.target_torque = target_torque
        self.limit = limit
        self.trip: LoadTrip | None = None
        self.weight = math.nan
        self.over_limit = False
        self.tolerance = self.tolerance_below = math.inf
        self._by_torque = math.nan
        self._beyond_for = self._hook_beyond_for = 0.0
        self._compared_for = 0.0   # s, without a reference
        self._holding = False   # contacts hold the bit; learnt before the reference only: a washout looks the same
        self._hold_left = 0.0
        self._averages: tuple[float, float, float, float] | None = None   # N: pressure, hook load; quick, slow
        self._sudden_from = (math.nan, math.nan)   # N, of pressure and hook load before a sudden change
        self._hook_jump_left = 0.0   # s for which a jump of the hook load is remembered
        # s for which rate, or rate and hook load, still show that lowering was slowed or stopped.
        self._rate_hidden = self._stopped_left = 0.0

    def weight_after_release(self, pressure_weight: float, hook_deficit: float) -> float:
        """Weight on bit (N) if rocking let go of drag at once, from the channel that shows the most.

        Args:
            pressure_weight: Weight on bit by pressure, N.
            hook_deficit: What has left the hook since the string hung off bottom, N; NaN where unknown.
        """
        shown = (pressure_weight, self.weight, self._by_torque)
        weight = max(value for value in shown if math.isfinite(value))
        drag = max(hook_deficit - weight, 0.0) if math.isfinite(hook_deficit) else 0.0
        return weight + LET_GO_SHARE * drag

    @property
    def holds(self) -> bool:
        """Whether it is being watched if a sudden change of pressure stays."""
        return self._hold_left > 0.0

    @property
    def stops(self) -> bool:
        """Whether the block must not be lowered."""
        return self.trip is not None or self.over_limit or self.holds

    def update_sample(self, pressure_weight: float, hook_deficit: float, smooth_deficit: float, step: float) -> None:
        """Take one sample: bound the weight, and watch for a sudden change of pressure that the hook load lacks.

        Args:
            pressure_weight: Weight on bit by pressure, N.
            hook_deficit: What has left the hook since the string hung off bottom, N; NaN where unknown.
            smooth_deficit: The same, averaged over a stroke or two, N.
            step: Time since the last sample, s.
        """
        self.weight = self.evidence.by_hook_load(smooth_deficit)
        highest = max((weight for weight in (self.weight, self._by_torque) if math.isfinite(weight)), default=0.0)
        self._rate_hidden -= step
        self._stopped_left = RATE_WINDOW if self.over_limit or self.holds else self._stopped_left - step
        self.over_limit = highest > (_RELEASE_SHARE if self.over_limit else 1.0) * self.limit
        if step <= 0.0 or not (math.isfinite(hook_deficit) and math.isfinite(pressure_weight)):
            return
        now = (pressure_weight, hook_deficit)
        before = self._averages or (*now, *now)
        quick, slow = (1.0 - math.exp(-step / time) for time in (_QUICK_TIME, _SLOW_TIME))
        averages = (before[0] + quick * (now[0] - before[0]), before[1] + quick * (now[1] - before[1]),
                    before[2] + slow * (now[0] - before[2]), before[3] + slow * (now[1] - before[3]))
        self._averages = averages
        # Neither block nor bit changes the hook load so quickly, and drag that lets go does not change it at all.
        alone = abs(averages[0] - averages[2]) < _SUDDEN_CHANGE * self.target_weight
        jumped = alone and abs(averages[3] - averages[1]) > _HOOK_JUMP_SHARE * self.target_weight
        self._hook_jump_left = _HOOK_JUMP_MEMORY if jumped else self._hook_jump_left - step
        if self.holds:
            self._watch_sudden_change(averages, step)
        elif self._is_sudden(averages[0] - averages[2], averages[1] - averages[3]) and self.trip is None:
            self._hold_left, self._sudden_from = _HOLD_TIME, (averages[2], averages[3])

    def _is_sudden(self, pressure: float, hook_load: float) -> bool:
        """Whether these changes (N) contradict each other.

        While the load comes on for the first time, drag that lets go or builds up moves it by jumps: then only a large
        loss of pressure counts, which alone hides weight.
        """
        if abs(pressure) < _SUDDEN_CHANGE * self.target_weight:
            return False
        if not self.evidence.known:
            return pressure - hook_load < -_FIRST_SUDDEN_FALL * self.target_weight
        rise = _SUDDEN_RISE * self.target_weight + _RELEASED_DRAG * max(self.evidence.drag, 0.0)
        return pressure - hook_load < -_SUDDEN_FALL * self.target_weight or pressure - hook_load > rise

    def _watch_sudden_change(self, averages: tuple[float, float, float, float], step: float) -> None:
        """Trip if the change is still there after the hold."""
        self._hold_left = max(self._hold_left - step, 0.0)
        if self.holds or self.trip is not None:
            return
        pressure, hook = averages[0] - self._sudden_from[0], averages[1] - self._sudden_from[1]
        if self._is_sudden(pressure, hook):
            fault = LoadFault.LOST_STROKES if pressure < hook else LoadFault.PLUGGED_NOZZLE
            self.trip = LoadTrip(fault, f"weight by pressure changed by {pressure / 1e3:+.0f} kN at once, by hook load "
                                 f"by {hook / 1e3:+.0f} kN")

    def forget_averages(self) -> None:
        """Start the averages of `update_sample` again, as after picking up."""
        self._averages = None
        self._hold_left = 0.0

    def update_cycle(self, sample: LoadSample, conditions: LoadConditions) -> None:
        """Take one rocking cycle: compare torque and hook load with pressure."""
        evidence = self.evidence
        winding = _winding_torque(conditions)
        most = _MAX_DOUBT_SHARE * self.target_torque
        self._holding |= conditions.held and conditions.loaded and not evidence.known
        sure = (_HOLDING if self._holding else 1.0) * _TORQUE_SIGMAS
        if not evidence.known:
            self._compared_for += sample.duration if conditions.checked else 0.0
            sure += max(1.0 - self._compared_for / _UNKNOWN_TIME, 0.0) * _UNKNOWN_SCALE * self.target_torque
        # Torque that winds the string to the right stands for more than pressure, to the left for less.
        self.tolerance = sure + min(max(winding, 0.0), most)
        self.tolerance_below = _SAFE_SIDE * sure + min(max(-winding, 0.0), most)
        turning = abs(conditions.error) > _SETTING_ERROR
        if conditions.slowed:
            self._stopped_left = RATE_WINDOW
        if abs(conditions.error) > _REFERENCE_ERROR:   # the load waits for the toolface, so the rate says little
            self._rate_hidden = RATE_WINDOW
        # Torque that winds or turns the string would be taken for the motor's.
        disturbed = (abs(conditions.lead_torque) + abs(conditions.turning_torque)
                     > _REFERENCE_SHARE * self.target_torque)
        steady = (conditions.loaded and abs(conditions.error) < _REFERENCE_ERROR and not disturbed
                  and self.trip is None)
        consistent = conditions.checked and self.trip is None and not self.holds
        evidence.take(sample, steady, consistent and abs(evidence.difference) < 0.5 * self.tolerance)
        trusted = conditions.checked and evidence.known
        self._by_torque = evidence.by_torque(sample) - self._doubt(conditions) if trusted else math.nan
        if self.trip is not None or not conditions.checked:
            self._beyond_for = self._hook_beyond_for = 0.0
            return
        beyond = not -self.tolerance_below <= evidence.difference <= self.tolerance and not turning
        # The difference is smoothed and the tolerance is not: one cycle that excuses much does not clear the others.
        self._beyond_for = max(self._beyond_for + sample.duration * (1.0 if beyond else -_FORGET_SHARE), 0.0)
        if self._beyond_for >= _CONFIRM_TIME:
            self.trip = self._pressure_or_torque()
            return
        self._check_hook_load(sample, conditions)

    def _doubt(self, conditions: LoadConditions) -> float:
        """Weight (N) by which the weight by torque may be too large: torque that winds the string to the right."""
        share = max(_winding_torque(conditions), 0.0) / self.target_torque
        return share * self.target_weight / min(self.evidence.scale, 1.0)

    def _check_hook_load(self, sample: LoadSample, conditions: LoadConditions) -> None:
        """The drag that is left between hook load and weight must be one that pipe can have."""
        weight = max(self.evidence.by_pressure(sample), self.evidence.by_torque(sample))
        drag = sample.hook_deficit - self.evidence.by_pressure(sample)
        change = self.weight - weight
        # Until the reference is known drag builds up with the load, faster than it is learnt.
        jumped = self.evidence.known and (change > _JUMP_SHARE * self.target_weight or (
            abs(change) > _AFTER_JUMP_SHARE * self.target_weight and self._hook_jump_left > 0.0))
        low = _MIN_DRAG_SHARE * self.target_weight - _HOOK_TOLERANCE
        high = _MAX_DRAG_SHARE * conditions.full_drag + _HOOK_TOLERANCE
        agree = abs(self.evidence.difference) < min(_TORQUE_SIGMAS, 0.5 * self.tolerance)
        beyond = conditions.loaded and agree and not self.holds and (jumped or not low <= drag <= high)
        self._hook_beyond_for = self._hook_beyond_for + sample.duration if beyond else 0.0
        if self._hook_beyond_for >= _CONFIRM_TIME:
            known = f"{self.weight / 1e3:.0f} kN" if math.isfinite(self.weight) else "unknown"
            self.trip = LoadTrip(
                LoadFault.HOOK_LOAD, f"weight by hook load {known}, by pressure and torque "
                f"{weight / 1e3:.0f} kN; {drag / 1e3:.0f} kN of drag would be left")

    def _pressure_or_torque(self) -> LoadTrip:
        """Which of the two is wrong, by hook load and rate. A pressure that changes at once trips before this."""
        evidence = self.evidence
        onset = evidence.onset(_ONSET_SHARE * self.tolerance)
        change = evidence.change_since(onset)
        figures = (f"torque stands for {evidence.difference / 1e3:+.1f} kN m against pressure, "
                   f"{self.tolerance_below / 1e3:.1f} kN m below and {self.tolerance / 1e3:.1f} kN m above can "
                   "be wrong")
        if change is not None:
            figures += (f"; weight since then by torque {change.torque / 1e3:+.0f} kN, by pressure "
                        f"{change.pressure / 1e3:+.0f} kN, by hook load {change.hook_load / 1e3:+.0f} kN, by rate "
                        f"{change.rate / 1e3:+.0f} kN, by twist {change.twist / 1e3:+.0f} kN")
            if self._stopped_left > 0.0:
                change = replace(change, rate=math.nan, hook_load=math.nan)
            elif self._rate_hidden > 0.0:
                change = replace(change, rate=math.nan)
            by_torque, by_pressure = (
                _misfit(change, weight, self.target_weight) for weight in (change.torque, change.pressure))
            if by_torque > by_pressure + _CLEAR:
                return LoadTrip(LoadFault.TORQUE, figures)
            if by_pressure < by_torque + _CLEAR:
                figures += "; hook load and rate do not clear the torque sensor"
        if self.holds:
            sudden = LoadFault.LOST_STROKES if evidence.difference > 0.0 else LoadFault.PLUGGED_NOZZLE
            return LoadTrip(sudden, figures)
        return LoadTrip(LoadFault.WASHOUT if evidence.difference > 0.0 else LoadFault.TRANSMITTER, figures)


def _winding_torque(conditions: LoadConditions) -> float:
    """Torque (N m) that turns the toolface or that the wall holds near the bit, not the motor's; positive right."""
    return _LEAD_SHARE * conditions.lead_torque + conditions.turning_torque


def _misfit(change: LoadChange, weight: float, target_weight: float) -> float:
    """Squared misfit of hook load, rate and twist if the weight has changed by `weight` (N)."""
    shown = ((change.hook_load, _HOOK_SIGMA), (change.rate, _RATE_SIGMA * target_weight),
             (change.twist, _TWIST_SIGMA * target_weight))
    return sum(((value - weight) / sigma) ** 2 for value, sigma in shown if math.isfinite(value))
