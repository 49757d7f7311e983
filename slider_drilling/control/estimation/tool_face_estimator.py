"""Toolface between MWD samples: surface torque shows the twist of the string, MWD calibrates it.

Over a whole cycle rocking cancels: friction above its reach takes as much torque to the right as to the left. The
mean M of surface torque is what the string carries there. At the bit it carries the reactive torque T. With S the
torsional compliance of the string and ``w`` the share of it that carries M (the static zone counts half and half),

    x = angle - S (w M + (1 - w) T) + b,

where angle is the mean of the top drive, x the mean toolface and b the toolface offset. `string_kalman_filter`
estimates x and b together with the errors of S, T and M. A histogram over the circle finds the offset that the first
samples agree on, and notices when rejected samples agree on another one. So a sample that is late, lost, wrong or off
by a whole turn does little harm.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from slider_drilling.control.estimation.circular_histogram import CircularHistogram
from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.follow_share import FollowShare
from slider_drilling.control.estimation.mwd_noise import MwdNoise
from slider_drilling.control.estimation.string_kalman_filter import Array, StringKalmanFilter
from slider_drilling.control.estimation.torque_jump import JUMP_STROKES
from slider_drilling.control.interface import MwdSample

_HISTORY_STEP = 0.5        # s between the instants that are kept
_MAX_WAITING = 10          # MWD samples kept until the first rocking cycle has ended
_MAX_FUTURE = 1.0          # s by which a sample may be ahead of the clock
_OUTLIERS = 0.1            # share of MWD samples that may be any angle
_OUTLIERS_AFTER_OUTLIER = 0.5   # the same after a wrong sample: faults come in runs
_MIN_INLIER_PROBABILITY = 0.5   # below it a sample counts as rejected
# Normalised innovation squared: weight of one sample in its average, and the largest value of one sample.
_INNOVATION_WEIGHT, _MAX_INNOVATION = 0.25, 16.0
# Variance of the rate at which the driving twist turns the bit, over that rate squared: while the bit is loaded, and
# while it is being loaded (pipe near the bit then twists before surface sees anything).
_RATE_VARIANCE, _RAMP_RATE_VARIANCE = 0.05, 1.0
# While the string slides fast: random walk of the toolface, rad/sqrt(s), and error of the twist, rad.
_SLIDING_WALK, _SLIDING_SIGMA = 0.4, 0.7
# rad of error, from which on and down to which the toolface should follow the twist that corrects it.
_WRONG, _CORRECTED = math.radians(15.0), math.radians(6.0)
_LOOSE_WALK = 0.25   # rad/sqrt(s), of a bit that large strokes tear loose
_INITIAL_TWIST_SIGMA = math.radians(6.0)   # rad
_MIN_SAMPLE_DISTANCE = 0.05   # s between two samples
_OFFSET_KNOWN = 0.5        # probability of one offset, above which it is acted on
_OFFSET_REPLACED = 0.7     # the same for the offset of rejected samples
_REPLACED_MEMORY = 600.0   # s for which a replaced offset is reported


@dataclass(frozen=True)
class EstimatorNoise:
    """Noise of the measurements and of the model.

    Attributes:
        sample: One MWD sample (noise, quantisation, unexplained swing), rad.
        torque: One sample of surface torque, white, N m.
        interval: Time between torque samples, s.
        twist_share: Error of the twist over the driving twist.
        move_share: Share of a move of the mean angle that the mean torque does not show yet.
        walk: Random walk of the toolface, rad/sqrt(s).
        drift: Random walk of the offset, rad/sqrt(s).
    """

    sample: float
    torque: float
    interval: float
    twist_share: float
    move_share: float
    walk: float
    drift: float


@dataclass
class _Instant:
    time: float        # s
    tool_face: float   # rad, x
    string: float      # rad, x - b
    turned: float = 0.0   # rad, by the model alone since the start


class ToolFaceEstimator:
    """Mean toolface, unwrapped.

    Args:
        compliance: S0, rad/(N m).
        response_time: Response time of the toolface by the rig file, s.
        noise: Noise levels.
        memory: How late an MWD sample may arrive, s.
        bias: Of the torque sensor by the rig file, N m.
        min_response_time: Lower bound of the estimated response time, s.
        bias_sigma: Of the mean torque at rest: sensor bias, and friction that differs between right and left, N m.

    Attributes:
        filter: Extended Kalman filter of toolface and string.
        mobility: Factor on 1 / response time, set by the controller.
        bit_loaded: Whether the bit is loaded, set by the controller.
        follow: How much of its expected turn the toolface makes.
        sliding_fast: Whether the string slides fast and so turns freely, set by the controller.
        error: Target minus toolface, rad, set by the controller.
        torn_loose: Whether strokes large enough to turn the bit tear it loose, set by the controller.
        known: Whether the toolface is known.
        driving_twist: S (M - T), rad.
        samples: Accepted MWD samples.
        rejections: Rejected MWD samples.
        last_sample: Time at which the last accepted sample was read, s, or None.
    """

    def __init__(
        self, compliance: float, response_time: float, noise: EstimatorNoise, memory: float = 90.0, bias: float = 0.0,
        min_response_time: float = 0.0, bias_sigma: float = 200.0,
    ):  # fmt: skip
        self._noise = noise
        self._sample_noise = MwdNoise(noise.sample**2)
        self._memory = memory
        self._history: deque[_Instant] = deque()
        self._waiting: list[tuple[MwdSample, float]] = []
        self._offset_histogram = CircularHistogram(_OUTLIERS)
        self.filter = StringKalmanFilter(compliance, response_time, bias, min_response_time, bias_sigma)
        self._angle = math.nan             # rad, mean of the last cycle
        self._cycle: CycleAverage | None = None
        self._memories: deque[tuple[Array, Array]] = deque(maxlen=JUMP_STROKES)
        self._reactive_torque = math.nan   # N m, at the last advance
        self._torque_share = 1.0           # w of the last cycle
        self._innovation = 1.0             # mean of the normalised innovation squared, at least 1
        self._outliers = _OUTLIERS         # share of wrong samples expected for the next one
        self._offset_variance = 0.0        # rad2, by which the offset may have moved since its last sample
        self.mobility = 1.0
        self.bit_loaded = False
        self.sliding_fast = False
        self.torn_loose = False
        self.error = 0.0
        self._correcting = False
        self.known = False
        self.driving_twist = 0.0
        self.follow = FollowShare()
        self.samples = 0
        self.rejections = 0
        self.last_sample: float | None = None
        self._replaced = (-math.inf, 0.0)   # s, rad: when the offset was replaced last, and by how much it changed

    @property
    def replaced_by(self) -> float:
        """Change of the offset (rad) that rejected samples have brought within the last minutes; 0 for none."""
        time, change = self._replaced
        return change if self._history and self._history[-1].time < time + _REPLACED_MEMORY else 0.0

    @property
    def offset(self) -> float:
        """b, rad."""
        return self.filter.offset

    @property
    def tool_face(self) -> float:
        """x, rad; NaN before the first rocking cycle has ended."""
        return self.filter.tool_face if self._history else math.nan

    @property
    def sigma(self) -> float:
        """One standard deviation of the toolface, rad."""
        return self.filter.tool_face_sigma if self._history else math.inf

    def advance(self, time: float, reactive_torque: float = math.nan) -> None:
        """Predict up to `time` (s) with the reactive torque from pressure (N m); does nothing if time stands still."""
        if not self._history or time - self._history[-1].time < _HISTORY_STEP:
            return
        step = time - self._history[-1].time
        before = self.filter.tool_face
        if math.isfinite(reactive_torque):
            if math.isfinite(self._reactive_torque):
                self.filter.follow_torque_step(reactive_torque - self._reactive_torque, self._torque_share)
            self._reactive_torque = reactive_torque
        noise = self._noise
        drift = math.sqrt(noise.drift**2 + (noise.twist_share * self.driving_twist) ** 2 / self.filter.response_time)
        if self._cycle is not None:
            mobility, walk = (0.0, _SLIDING_WALK) if self.sliding_fast else (self.mobility, self._walk())
            driving_twist = self.filter.driving_twist(self._cycle.torque, self._cycle.reactive_torque)
            # A twist that does not correct an error says more of the sensors than of the contacts.
            self._correcting = abs(self.error) > (_CORRECTED if self._correcting else _WRONG)
            corrects = self._correcting and self.error * driving_twist > 0.0
            turn = driving_twist * step / self.filter.estimate.response_time if corrects else 0.0
            self.follow.drive(time, turn)
            self.filter.advance(
                step, self._cycle.torque, self._cycle.reactive_torque, mobility * self.follow.mobility, walk, drift)
        self._offset_variance += drift * drift * step
        x, b = self.filter.tool_face, self.filter.offset
        self._history.append(_Instant(time, x, x - b, self._history[-1].turned + x - before))
        while len(self._history) > 2 and self._history[0].time < time - self._memory:
            self._history.popleft()

    def _walk(self) -> float:
        """Random walk of the toolface, rad/sqrt(s): more where it turns fast, and where MWD contradicts the model."""
        rate = self.driving_twist / self.filter.response_time
        variance = _RATE_VARIANCE if self.bit_loaded or self.follow.held else _RAMP_RATE_VARIANCE
        walk = _LOOSE_WALK if self.torn_loose else self._noise.walk
        return math.sqrt(
            self._innovation * (walk**2 + variance * rate * rate * self.filter.response_time))

    def update_with_cycle(self, time: float, cycle: CycleAverage, torque_share: float, reference: float) -> None:
        """Take the average of the rocking cycle that ended at `time`.

        Args:
            time: s.
            cycle: Averages.
            torque_share: w, share of the compliance that carries the mean surface torque.
            reference: Toolface whose whole turn the first samples get, rad.
        """
        noise = self._noise
        moved = 0.0 if math.isnan(self._angle) else cycle.angle - self._angle
        self._angle, self._cycle, self._torque_share = cycle.angle, cycle, torque_share
        self.driving_twist = self.filter.driving_twist(cycle.torque, cycle.reactive_torque)
        white = self.filter.compliance * noise.torque * math.sqrt(noise.interval / cycle.duration)
        variance = white * white + (noise.twist_share * self.driving_twist) ** 2 + (noise.move_share * moved) ** 2
        if self.sliding_fast:
            variance += _SLIDING_SIGMA**2
        if not self._history:
            self._start(time, cycle, reference)
            return
        self.advance(time)
        during = [instant.tool_face for instant in self._history if instant.time > time - cycle.duration]
        mean_tool_face = sum(during) / len(during) if during else self.tool_face
        # Consecutive averages share a stroke, so each counts half.
        self._memories.append(self.filter.memory)
        change = self.filter.update_with_cycle(
            cycle.angle, mean_tool_face, cycle.torque, cycle.reactive_torque, torque_share, 2.0 * variance)
        self._shift_history(time - cycle.duration, change)

    def shift_torque(self, jump: float) -> None:
        """Take a jump (N m) of the torque sensor for its bias, and undo what it has done to the toolface.

        Call it before `update_with_cycle` takes the first whole cycle after the jump.
        """
        if self._memories:
            before = self.tool_face
            self.filter.shift_bias(self._memories[0], jump)
            self._shift_history(self._history[-1].time, self.tool_face - before)
        self._memories.clear()

    def _start(self, time: float, cycle: CycleAverage, reference: float) -> None:
        """Start the history with the first cycle, then take the MWD samples that came before it."""
        string = cycle.angle - self.filter.twist(cycle.torque, cycle.reactive_torque, self._torque_share)
        self.filter.reset_tool_face(string, 0.0, math.pi**2)
        self._history.append(_Instant(time, string, string))
        for sample, phase in self._waiting:
            self.update_with_mwd(sample, reference, phase)
        self._waiting.clear()

    def _shift_history(self, since: float, change: float) -> None:
        """Correct the toolface held from `since` (s) on by `change` (rad)."""
        for instant in self._history:
            if instant.time >= since:
                instant.tool_face += change
                instant.string = instant.tool_face - self.filter.offset

    def reset_clock(self, time: float) -> None:
        """Go on from `time` (s) after the clock has jumped: estimates stay, the history goes."""
        self._waiting.clear()
        self.follow.forget()
        self._sample_noise.forget_last()
        if self._history:
            last = self._history[-1]
            self._history.clear()
            last.time = time
            self._history.append(last)

    def update_with_mwd(self, sample: MwdSample, reference: float, phase: float = math.nan) -> bool:
        """Take one MWD sample.

        Args:
            sample: Toolface as decoded at surface.
            reference: Toolface whose whole turn the first samples get, rad.
            phase: Of rocking when it was read, rad; NaN where unknown.

        Returns:
            False where it was rejected, or has to wait for the first rocking cycle.
        """
        if not (math.isfinite(sample.tool_face) and math.isfinite(sample.measured_at)):
            return False
        if not self._history:
            self._waiting = [*self._waiting[1 - _MAX_WAITING:], (sample, phase)]
            return False
        newest = self._history[-1].time
        if sample.measured_at > newest + _MAX_FUTURE or sample.measured_at < newest - self._memory:
            return False
        held = self._history[self._index_at(sample.measured_at)]
        variance = self._sample_noise.variance * self._correlated_samples(sample.measured_at)
        expected = variance + (_INITIAL_TWIST_SIGMA**2 if not self.known else self.filter.mwd_variance(phase))
        mean = sample.tool_face - self.filter.swing_at(phase)
        self._offset_histogram.diffuse(self._offset_variance)
        self._offset_variance = 0.0
        self._offset_histogram.update(math.remainder(mean - held.string, 2.0 * math.pi), expected)
        accepted = (self._correct(mean - held.tool_face, phase, variance) if self.known
                    else self._find_offset(reference))
        if accepted:
            self.samples += 1
            self.last_sample = sample.measured_at
            if self.known:
                self.follow.observe(sample.measured_at, mean)
                self._sample_noise.observe(mean, held.turned)
        return accepted

    def _correlated_samples(self, time: float) -> float:
        """Number of samples that count as one, this close (s) to the last: the swing repeats within half a cycle."""
        since = math.inf if self.last_sample is None else abs(time - self.last_sample)
        half = 0.5 * self._cycle.duration if self._cycle is not None else 0.0
        return max(half / max(since, _MIN_SAMPLE_DISTANCE), 1.0)

    def _find_offset(self, reference: float) -> bool:
        """Start with the offset that the first samples agree on."""
        near = reference - self._history[-1].string
        self._set_offset(near + math.remainder(self._offset_histogram.mean - near, 2.0 * math.pi))
        self.known = self._offset_histogram.weight > _OFFSET_KNOWN
        return True

    def _set_offset(self, offset: float) -> None:
        """Move the whole history to this offset (rad); the twist of the string stays."""
        for instant in self._history:
            instant.tool_face = instant.string + offset
        x = self._history[-1].tool_face
        self.filter.reset_tool_face(x, offset, self._offset_histogram.sigma**2 + _INITIAL_TWIST_SIGMA**2)
        cycle = self._cycle
        if cycle is not None:
            angle = x - offset + self.filter.twist(cycle.torque, cycle.reactive_torque, self._torque_share)
            self.filter.update_with_cycle(
                angle, x, cycle.torque, cycle.reactive_torque, self._torque_share, _INITIAL_TWIST_SIGMA**2)

    def _correct(self, difference: float, phase: float, variance: float) -> bool:
        """Correct the toolface by an MWD sample; False where the sample is probably wrong."""
        innovation = math.remainder(difference, 2.0 * math.pi)
        expected = variance + self.filter.mwd_variance(phase)
        inlier = _inlier_probability(innovation, expected, self._outliers)
        self._outliers = inlier * _OUTLIERS + (1.0 - inlier) * _OUTLIERS_AFTER_OUTLIER
        # A wrong sample says nothing of the model: it must not widen the gate for the next one.
        normalised = min(innovation * innovation / expected, _MAX_INNOVATION)
        self._innovation += _INNOVATION_WEIGHT * inlier * (normalised - self._innovation)
        self._innovation = max(self._innovation, 1.0)
        self._shift_history(-math.inf, self.filter.update_with_mwd(innovation, phase, variance, inlier))
        if inlier < _MIN_INLIER_PROBABILITY:
            self.rejections += 1
            self._replace_offset()
        return inlier >= _MIN_INLIER_PROBABILITY

    def _replace_offset(self) -> None:
        """Take over another offset once rejected samples agree on it."""
        change = math.remainder(self._offset_histogram.mean - self.filter.offset, 2.0 * math.pi)
        if self._offset_histogram.weight > _OFFSET_REPLACED and abs(change) > 2.0 * self._offset_histogram.sigma:
            self._set_offset(self.filter.offset + change)
            self._replaced = (self._history[-1].time, change)

    def _index_at(self, time: float) -> int:
        """Index of the newest instant not after `time` (s), or of the oldest one."""
        for index in range(len(self._history) - 1, 0, -1):
            if self._history[index].time <= time:
                return index
        return 0


def _inlier_probability(innovation: float, expected: float, outliers: float) -> float:
    """Probability that a sample is no outlier.

    Args:
        innovation: Sample minus prediction, rad.
        expected: Variance of the innovation, rad2.
        outliers: Share of samples that may be any angle.
    """
    density = math.exp(-0.5 * innovation * innovation / expected)
    normal = (1.0 - outliers) * density / math.sqrt(2.0 * math.pi * expected)
    return normal / (normal + outliers / (2.0 * math.pi))
