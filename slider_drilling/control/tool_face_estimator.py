"""Tool-face between two MWD samples: surface torque tells how far the string is twisted, MWD what that means.

Over a whole cycle rocking cancels: friction above its reach takes as much to the right as to the left. What is left of
surface torque, M, is what the string carries there; at the bit it carries the reactive torque T. With S the torsional
compliance of the string and ``w`` the share of it that carries M (the static zone between is half and half),

    x = angle - S (w M + (1 - w) T) + b,

angle the mean of the top drive, x the mean tool-face. b is what is not known: where the bend points, errors of S, T and
of the torque sensor. It hardly moves, so all MWD samples together tell it, late ones as well as prompt ones, and a lost
or a wrong one costs little. ``S (M - T)`` is the twist that pulls the tool-face; it follows with a lag. Where the
tool-face rests although the string slides, nothing pulls: what is measured then is the error of S, T and the sensor.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from slider_drilling.control.circular_belief import CircularBelief
from slider_drilling.control.stroke_means import CycleMean
from slider_drilling.signals import MwdSample

_STEP = 0.5                # s between the instants that are kept
_OUTLIERS = 0.1            # share of MWD samples that may be any angle
_GATE = 4.0                # standard deviations beyond which a sample counts as refused
_REST, _REST_MOVE = 40.0, math.radians(6.0)   # s, rad: a tool-face that moves no more than this rests
_REST_LEARNT, _IN_DOUBT, _MOST_REST_PULL = 20.0, 0.4, 4.0   # s, rad, rad
_PLACED = 0.5              # probability of one offset, below which it is too early to act on it


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
    string: float      # rad, x - b
    variance: float    # rad2
    pull: float        # rad


class ToolFaceEstimator:
    """Mean tool-face, unwrapped. compliance: rad/(N m), S; response_time: s, the lag behind what pulls; memory: s, how
    late a sample may come."""

    def __init__(self, compliance: float, response_time: float, noise: EstimatorNoise, memory: float = 90.0):
        self.response_time = response_time
        self._compliance = compliance
        self._noise = noise
        self._memory = memory
        self._past: deque[_Instant] = deque()
        self._waiting: list[MwdSample] = []
        self._offset = CircularBelief(_OUTLIERS)
        self._angle = math.nan   # rad, mean of the last cycle
        self._moved = 0.0        # rad2, that the offset may have moved since its last sample
        self._turned = 0.0       # rad, the offset with its turns
        self.rest_pull = 0.0     # rad, S (M - T) as measured where the tool-face rests
        self.pull = 0.0          # rad, S (M - T) beyond that
        self.samples = 0
        self.rejections = 0
        self.last_sample: float | None = None     # s, when the last accepted sample was read

    @property
    def known(self) -> bool:
        """Whether the tool-face is."""
        return bool(self._past) and self._offset.weight > _PLACED

    @property
    def offset(self) -> float:
        """b, rad: of the turn that it had before."""
        return self._turned

    @property
    def tool_face(self) -> float:
        """x, rad; NaN before rocking has made a cycle."""
        return self._past[-1].string + self._turned if self._past else math.nan

    @property
    def spread(self) -> float:
        """One standard deviation of the tool-face, rad."""
        return math.sqrt(self._variance(self._past[-1]) + self._offset.spread**2) if self._past else math.inf

    def advance(self, time: float) -> None:
        """Come forward to `time` (s). A clock that does not advance changes nothing."""
        if not self._past or time - self._past[-1].time < _STEP:
            return
        last, step = self._past[-1], time - self._past[-1].time
        rate = self.pull / self.response_time
        walk = (self._noise.walk**2 + rate * rate * self.response_time) * step
        self._past.append(_Instant(time, last.string, last.variance + walk, self.pull))
        self._moved += (self._noise.drift**2 + (self._noise.pull_share * self.pull) ** 2 / self.response_time) * step
        while len(self._past) > 2 and self._past[0].time < time - self._memory:
            self._past.popleft()

    def observe(self, time: float, cycle: CycleMean, carried: float, drilling: bool, reference: float) -> None:
        """Take the mean of the cycle that ended at `time` (s); carried: w; drilling: whether the string slides, so that
        what pulls would turn it; reference: rad, the turn that the first samples get."""
        string, variance = self._string(cycle, carried)
        if self._past:
            self._blend(time, string, variance, cycle.duration)
            if drilling and self._at_rest(time):
                share = 1.0 - math.exp(-0.5 * cycle.duration / _REST_LEARNT)
                # The controller's trim takes the little that noise and a slow creep leave in doubt.
                beyond = math.copysign(max(abs(self.pull) - _IN_DOUBT, 0.0), self.pull)
                self.rest_pull = min(max(self.rest_pull + share * beyond, -_MOST_REST_PULL), _MOST_REST_PULL)
            return
        self._past.append(_Instant(time, string, variance, self.pull))
        for sample in self._waiting:
            self.correct(sample, reference)
        self._waiting.clear()

    def _string(self, cycle: CycleMean, carried: float) -> tuple[float, float]:
        """x - b (rad) as this cycle shows it and its variance (rad2)."""
        noise = self._noise
        twist = self._compliance * (cycle.torque - cycle.reactive_torque)
        self.pull = twist - self.rest_pull
        moved = 0.0 if math.isnan(self._angle) else cycle.angle - self._angle
        self._angle = cycle.angle
        white = self._compliance * noise.torque * math.sqrt(noise.interval / cycle.duration)
        variance = white * white + (noise.pull_share * self.pull) ** 2 + (noise.move_share * moved) ** 2
        return cycle.angle - self._compliance * cycle.reactive_torque - carried * twist, variance

    def _at_rest(self, time: float) -> bool:
        """Whether the string's twist has not changed for a while: then nothing pulls, whatever the sensors say."""
        then = self._past[self._index_at(time - _REST)]
        return then.time <= time - 0.9 * _REST and abs(self._past[-1].string - then.string) < _REST_MOVE

    def _blend(self, time: float, string: float, variance: float, duration: float) -> None:
        """Weigh what a cycle shows with what was believed; it speaks for all of its `duration` (s)."""
        self.advance(time)
        middle = self._past[self._index_at(time - 0.5 * duration)]
        share = self._past[-1].variance / (self._past[-1].variance + variance)
        change = share * (string - middle.string)
        for instant in self._past:
            if instant.time > time - duration:
                instant.string += change
                instant.variance *= 1.0 - share
                instant.pull = self.pull

    def restamp(self, time: float) -> None:
        """The clock has jumped to `time` (s): what is known stays, the past goes."""
        self._waiting.clear()
        if self._past:
            last = self._past[-1]
            self._past.clear()
            last.time = time
            self._past.append(last)

    def correct(self, sample: MwdSample, reference: float) -> bool:
        """Take one MWD sample; reference: rad, the turn that the first ones get. False where it was refused,
        or has to wait for the first cycle of rocking."""
        if not (math.isfinite(sample.tool_face) and math.isfinite(sample.measured_at)):
            return False
        if not self._past:
            self._waiting = [*self._waiting[-9:], sample]
            return False
        if sample.measured_at > self._past[-1].time + 1.0 or sample.measured_at < self._past[-1].time - self._memory:
            return False
        then = self._past[self._index_at(sample.measured_at)]
        offset = math.remainder(sample.tool_face - then.string, 2.0 * math.pi)
        variance = self._noise.sample**2 + self._variance(then)
        known = self.known
        self._offset.diffuse(self._moved)
        self._moved = 0.0
        off = abs(math.remainder(offset - self._offset.mean, 2.0 * math.pi))
        refused = known and off > _GATE * math.sqrt(variance + self._offset.spread**2)
        self._offset.update(offset, variance)
        near = self._turned if known else reference - self._past[-1].string
        self._turned = near + math.remainder(self._offset.mean - near, 2.0 * math.pi)
        if refused:
            self.rejections += 1
            return False
        self.samples += 1
        self.last_sample = sample.measured_at
        return True

    def _variance(self, instant: _Instant) -> float:
        return instant.variance + (self._noise.pull_share * instant.pull) ** 2

    def _index_at(self, time: float) -> int:
        """Of the newest instant not after `time`, or the oldest one."""
        for index in range(len(self._past) - 1, 0, -1):
            if self._past[index].time <= time:
                return index
        return 0
