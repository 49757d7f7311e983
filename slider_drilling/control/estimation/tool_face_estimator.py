"""Toolface between two MWD samples: surface torque tells how far the string is twisted, MWD what that means.

Over a whole cycle rocking cancels: friction above its reach takes as much to the right as to the left. What is left of
surface torque, M, is what the string carries there; at the bit it carries the reactive torque T. With S the torsional
compliance of the string and ``w`` the share of it that carries M (the static zone between is half and half),

    x = angle - S (w M + (1 - w) T) + b,

angle the mean of the top drive, x the mean toolface, b where the bend points. What S, T and M are beyond what the rig
file and the sensors say is learnt beside x and b (`string_filter`). Which b the first samples agree on, and whether
samples that are refused agree on another, is a belief over the whole circle: a late, lost, wrong or whole-turn-off
sample costs little.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from slider_drilling.control.estimation.circular_histogram import CircularHistogram
from slider_drilling.control.estimation.cycle_average import CycleAverage
from slider_drilling.control.estimation.string_kalman_filter import StringKalmanFilter
from slider_drilling.control.interface import MwdSample

_STEP = 0.5                # s between the instants that are kept
_OUTLIERS = 0.1            # share of MWD samples that may be any angle
_IN_A_ROW = 0.5            # the same of the sample that follows a wrong one: faults come in runs
_TAKEN = 0.5               # probability that a sample is none, below which it counts as refused
_NOTICED, _MOST_SURPRISE = 0.25, 16.0   # share of one sample in the mean square of surprise; the most that one counts
_RATE_DOUBT = 0.05         # of the squared rate at which what pulls is believed to turn the bit, beside its mobility
_RAMP_DOUBT = 1.0          # ... while the bit is being loaded: pipe near it gives before surface sees anything
_SLIDING_WALK, _SLIDING_DOUBT = 0.4, 0.7    # rad/sqrt(s) of the toolface, rad of the twist, while the string slides
_STRING_DOUBT = math.radians(6.0)   # rad, of the twist at first
_CLOSEST = 0.05            # s between two samples
_PLACED = 0.5              # probability of one offset, below which it is too early to act on it
_BELIEVED = 0.7            # ... above which samples that were refused are


@dataclass(frozen=True)
class EstimatorNoise:
    """sample: rad, of one MWD sample (noise, quantisation, what rocking leaves at the bit); torque: N m, of one sample
    of surface torque, white; interval: s between those; pull_share: of the twist that pulls, by which the string may be
    twisted otherwise; move_share: of what the mean angle moved since the last cycle, that the mean torque does not show
    yet; walk: rad/sqrt(s), of the twist; drift: rad/sqrt(s), of the offset."""

    sample: float
    torque: float
    interval: float
    pull_share: float
    move_share: float
    walk: float
    drift: float


@dataclass
class _Instant:
    time: float
    tool_face: float   # rad, x
    string: float      # rad, x - b


class ToolFaceEstimator:
    """Mean toolface, unwrapped. compliance: rad/(N m), S0; response_time: s, the lag behind what pulls; memory: s, how
    late a sample may come; bias: N m, of the torque sensor as believed; quickest: s, that this lag is at least."""

    def __init__(self, compliance: float, response_time: float, noise: EstimatorNoise, memory: float = 90.0,
                 bias: float = 0.0, quickest: float = 0.0):
        self._noise = noise
        self._memory = memory
        self._past: deque[_Instant] = deque()
        self._waiting: list[tuple[MwdSample, float]] = []
        self._offset = CircularHistogram(_OUTLIERS)
        self.filter = StringKalmanFilter(compliance, response_time, bias, quickest)
        self._angle = math.nan   # rad, mean of the last cycle
        self._cycle: CycleAverage | None = None
        self._reactive = math.nan   # N m, at the last advance
        self._carried = 1.0         # w of the last cycle
        self._surprise = 1.0     # mean square of what samples are off by, over what it should be; never below
        self._outliers = _OUTLIERS   # share of samples like the next one that may be any angle
        self._moved = 0.0        # rad2, that the offset may have moved since its last sample
        self.mobility = 1.0      # of 1 / response time, that rocking leaves
        self.settled = False     # whether the bit is loaded
        self.sliding = False     # whether the string slides fast: then it turns freely, and nothing here foretells it
        self.known = False       # whether the toolface is
        self.pull = 0.0          # rad, S (M - T)
        self.samples = 0
        self.rejections = 0
        self.last_sample: float | None = None     # s, when the last accepted sample was read

    @property
    def offset(self) -> float:
        """b, rad: of the turn that it had before."""
        return float(self.filter.mean[1])

    @property
    def tool_face(self) -> float:
        """x, rad; NaN before rocking has made a cycle."""
        return float(self.filter.mean[0]) if self._past else math.nan

    @property
    def sigma(self) -> float:
        """One standard deviation of the toolface, rad."""
        return self.filter.tool_face_sigma if self._past else math.inf

    def at(self, time: float) -> float:
        """x (rad) as held for `time` (s)."""
        return self._past[self._index_at(time)].tool_face if self._past else math.nan

    def advance(self, time: float, reactive: float = math.nan) -> None:
        """Come forward to `time` (s). A clock that does not advance changes nothing."""
        if not self._past or time - self._past[-1].time < _STEP:
            return
        step = time - self._past[-1].time
        if math.isfinite(reactive):
            if math.isfinite(self._reactive):
                self.filter.follow_torque_step(reactive - self._reactive, self._carried)
            self._reactive = reactive
        drift = math.sqrt(self._noise.drift**2 + (self._noise.pull_share * self.pull) ** 2 / self.filter.response_time)
        if self._cycle is not None:
            rate = self.pull / self.filter.response_time
            doubt = _RATE_DOUBT if self.settled else _RAMP_DOUBT
            walk = math.sqrt(self._surprise * (self._noise.walk**2 + doubt * rate * rate * self.filter.response_time))
            mobility, walk = (0.0, _SLIDING_WALK) if self.sliding else (self.mobility, walk)
            self.filter.advance(step, self._cycle.torque, self._cycle.reactive_torque, mobility, walk, drift)
        self._moved += drift * drift * step
        x, b = float(self.filter.mean[0]), float(self.filter.mean[1])
        self._past.append(_Instant(time, x, x - b))
        while len(self._past) > 2 and self._past[0].time < time - self._memory:
            self._past.popleft()

    def update_with_cycle(self, time: float, cycle: CycleAverage, carried: float, reference: float) -> None:
        """Take the mean of the cycle that ended at `time` (s); carried: w; reference: rad, the turn that the first
        samples get."""
        noise = self._noise
        moved = 0.0 if math.isnan(self._angle) else cycle.angle - self._angle
        self._angle, self._cycle, self._carried = cycle.angle, cycle, carried
        self.pull = self.filter.pull(cycle.torque, cycle.reactive_torque)
        white = self.filter.compliance * noise.torque * math.sqrt(noise.interval / cycle.duration)
        variance = white * white + (noise.pull_share * self.pull) ** 2 + (noise.move_share * moved) ** 2
        if self.sliding:
            variance += _SLIDING_DOUBT**2
        if not self._past:
            shown = cycle.angle - self.filter.twist(cycle.torque, cycle.reactive_torque, carried)
            self.filter.reset_tool_face(shown, 0.0, math.pi**2)
            self._past.append(_Instant(time, shown, shown))
            for sample, phase in self._waiting:
                self.update_with_mwd(sample, reference, phase)
            self._waiting.clear()
            return
        self.advance(time)
        held = [instant.tool_face for instant in self._past if instant.time > time - cycle.duration]
        middle = sum(held) / len(held) if held else self.tool_face
        change = self.filter.update_with_cycle(
            cycle.angle, middle, cycle.torque, cycle.reactive_torque, carried, 2.0 * variance)
        self._shift(time - cycle.duration, change)

    def _shift(self, since: float, change: float) -> None:
        """What was held from `since` (s) on was off by `change` (rad)."""
        for instant in self._past:
            if instant.time >= since:
                instant.tool_face += change
                instant.string = instant.tool_face - float(self.filter.mean[1])

    def reset_clock(self, time: float) -> None:
        """The clock has jumped to `time` (s): what is known stays, the past goes."""
        self._waiting.clear()
        if self._past:
            last = self._past[-1]
            self._past.clear()
            last.time = time
            self._past.append(last)

    def update_with_mwd(self, sample: MwdSample, reference: float, phase: float = math.nan) -> bool:
        """Take one MWD sample; reference: rad, the turn that the first ones get; phase: rad, of rocking when it was
        read. False where it was refused, or has to wait for the first cycle of rocking."""
        if not (math.isfinite(sample.tool_face) and math.isfinite(sample.measured_at)):
            return False
        if not self._past:
            self._waiting = [*self._waiting[-9:], (sample, phase)]
            return False
        if sample.measured_at > self._past[-1].time + 1.0 or sample.measured_at < self._past[-1].time - self._memory:
            return False
        then = self._past[self._index_at(sample.measured_at)]
        variance = self._noise.sample**2 * self._alike(sample.measured_at)
        doubt = variance + (_STRING_DOUBT**2 if not self.known else self.filter.mwd_variance(phase))
        read = sample.tool_face - self.filter.swing_at(phase)
        self._offset.diffuse(self._moved)
        self._moved = 0.0
        self._offset.update(math.remainder(read - then.string, 2.0 * math.pi), doubt)
        accepted = self._place(reference) if not self.known else self._take(read - then.tool_face, phase, variance)
        if accepted:
            self.samples += 1
            self.last_sample = sample.measured_at
        return accepted

    def _alike(self, time: float) -> float:
        """How many samples as close as this one (s) is to the last are worth one: within half a cycle rocking leaves
        the same in each."""
        since = math.inf if self.last_sample is None else abs(time - self.last_sample)
        half = 0.5 * self._cycle.duration if self._cycle is not None else 0.0
        return max(half / max(since, _CLOSEST), 1.0)

    def _place(self, reference: float) -> bool:
        """Begin with the offset that the first samples agree on."""
        string = self._past[-1].string
        near = reference - string
        self._settle(near + math.remainder(self._offset.mean - near, 2.0 * math.pi))
        self.known = self._offset.weight > _PLACED
        return True

    def _settle(self, offset: float) -> None:
        """What the string shows stays, seen from this offset (rad)."""
        for instant in self._past:
            instant.tool_face = instant.string + offset
        x = self._past[-1].tool_face
        self.filter.reset_tool_face(x, offset, self._offset.spread**2 + _STRING_DOUBT**2)
        cycle = self._cycle
        if cycle is not None:
            shown = x - offset + self.filter.twist(cycle.torque, cycle.reactive_torque, self._carried)
            self.filter.update_with_cycle(
                shown, x, cycle.torque, cycle.reactive_torque, self._carried, _STRING_DOUBT**2)

    def _take(self, beyond: float, phase: float, variance: float) -> bool:
        off = math.remainder(beyond, 2.0 * math.pi)
        expected = variance + self.filter.mwd_variance(phase)
        genuine = _genuine(off, expected, self._outliers)
        self._outliers = genuine * _OUTLIERS + (1.0 - genuine) * _IN_A_ROW
        # A wrong sample says nothing of how the string moves: it must not open the door to the next one.
        self._surprise += _NOTICED * genuine * (min(off * off / expected, _MOST_SURPRISE) - self._surprise)
        self._surprise = max(self._surprise, 1.0)
        self._shift(-math.inf, self.filter.update_with_mwd(off, phase, variance, genuine))
        if genuine < _TAKEN:
            self.rejections += 1
            self._find_again()
        return genuine >= _TAKEN

    def _find_again(self) -> None:
        """Samples that keep being refused but agree with one another are believed."""
        apart = math.remainder(self._offset.mean - float(self.filter.mean[1]), 2.0 * math.pi)
        if self._offset.weight > _BELIEVED and abs(apart) > 2.0 * self._offset.spread:
            self._settle(float(self.filter.mean[1]) + apart)

    def _index_at(self, time: float) -> int:
        """Of the newest instant not after `time`, or the oldest one."""
        for index in range(len(self._past) - 1, 0, -1):
            if self._past[index].time <= time:
                return index
        return 0


def _genuine(off: float, expected: float, outliers: float) -> float:
    """Probability that a sample `off` (rad) from what is held, with `expected` (rad2) of variance, is no outlier,
    where a share of `outliers` may be any angle."""
    normal = (1.0 - outliers) * math.exp(-0.5 * off * off / expected) / math.sqrt(2.0 * math.pi * expected)
    return normal / (normal + outliers / (2.0 * math.pi))
