"""Tool-face between two MWD samples: a Kalman filter that fuses them with the reactive torque seen in pressure.

The mean tool-face follows what the top drive and the motor ask of it with a first-order lag,

    x' = (u + b - x) / tau,   u = centre of rocking - S T,    b' = 0 (+ noise),

S the torsional compliance of the string, T the reactive torque from differential pressure, b what is not known (start
twist, error of S or T). An MWD sample tells x as it was when the tool was read: the filter goes back to that instant,
corrects, and comes forward again through the inputs that it kept.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from slider_drilling.signals import MwdSample

_STEP = 0.5    # s, the filter's own step
_AGREED = 0.35         # rad, beyond noise, that refused samples may differ and still agree
_DOUBT = 0.8           # share of the modelled motion that may be wrong
_OFFSET_DOUBT = 0.2    # share of it that may be the offset's fault


@dataclass(frozen=True)
class EstimatorNoise:
    """sample: rad, of one MWD sample (noise, quantisation, what rocking leaves at the bit); walk: rad/sqrt(s), of
    the tool-face; drift: rad/sqrt(s), of the unknown offset; start: rad, of that offset at first."""

    sample: float
    walk: float
    drift: float
    start: float


@dataclass(frozen=True)
class Belief:
    """tool_face, offset: rad; p11, p12, p22: their covariance, rad2."""

    tool_face: float
    offset: float
    p11: float
    p12: float
    p22: float


@dataclass(frozen=True)
class _Instant:
    time: float
    belief: Belief
    drive: float      # rad, u from the instant before to this one


class ToolFaceEstimator:
    """Mean tool-face, unwrapped. response_time: s, tau; memory: s, how late a sample may come."""

    def __init__(self, response_time: float, noise: EstimatorNoise, gate: float = 4.0, memory: float = 90.0):
        self.response_time = response_time
        self._noise = noise
        self._gate = gate
        self._memory = memory
        self._past: deque[_Instant] = deque()
        self._rejected: list[float] = []          # rad, innovations in a row that the gate refused
        self.samples = 0
        self.rejections = 0
        self.last_sample: float | None = None     # s, when the last accepted sample was read

    @property
    def known(self) -> bool:
        """Whether a sample has ever come."""
        return self.samples > 0

    @property
    def belief(self) -> Belief | None:
        """The present estimate; None before the first step."""
        return self._past[-1].belief if self._past else None

    def advance(self, time: float, drive: float) -> None:
        """Come forward to `time` (s) with u = drive (rad). A clock that does not advance changes nothing."""
        if not self._past:
            start = Belief(drive, 0.0, self._noise.start**2, 0.0, self._noise.start**2)
            self._past.append(_Instant(time, start, drive))
            return
        last = self._past[-1]
        if time - last.time < _STEP:
            return
        self._past.append(_Instant(time, self._propagate(last.belief, time - last.time, drive), drive))
        while len(self._past) > 2 and self._past[0].time < time - self._memory:
            self._past.popleft()

    def restamp(self, time: float) -> None:
        """The clock has jumped to `time` (s): what is known stays, the past goes."""
        if self._past:
            last = self._past[-1]
            self._past.clear()
            self._past.append(_Instant(time, last.belief, last.drive))

    def correct(self, sample: MwdSample, reference: float) -> bool:
        """Take one MWD sample; reference: rad, what the first one is unwrapped about. False where it was refused."""
        if not (math.isfinite(sample.tool_face) and math.isfinite(sample.measured_at)) or not self._past:
            return False
        behind = self._index_at(sample.measured_at)
        if behind is None:
            return False
        if not self.known:
            self._begin(sample, reference, behind)
            return True
        then = self._past[behind].belief
        innovation = math.remainder(sample.tool_face - then.tool_face, 2.0 * math.pi)
        if self._refused(innovation, then):
            return False
        self._rejected.clear()
        self.samples += 1
        self.last_sample = sample.measured_at
        self._replay(behind, self._updated(then, innovation))
        return True

    def _begin(self, sample: MwdSample, reference: float, index: int) -> None:
        """The first sample: the offset is what the drive does not explain of it."""
        tool_face = reference + math.remainder(sample.tool_face - reference, 2.0 * math.pi)
        self.samples, self.last_sample = 1, sample.measured_at
        offset = tool_face - self._past[index].drive
        self._replay(index, Belief(tool_face, offset, self._noise.sample**2, 0.0, self._noise.start**2))

    def _refused(self, innovation: float, then: Belief) -> bool:
        """Whether the gate refuses; three refusals in a row that agree with each other are believed."""
        spread = math.sqrt(then.p11 + self._noise.sample**2)
        if abs(innovation) <= self._gate * spread:
            return False
        self.rejections += 1
        self._rejected.append(innovation)
        recent = self._rejected[-3:]
        agreed = len(recent) == 3 and max(recent) - min(recent) < 6.0 * self._noise.sample + _AGREED
        return not agreed

    def _index_at(self, time: float) -> int | None:
        """Newest instant not after `time`, None if that is forgotten or in the future."""
        if time > self._past[-1].time + 1.0:
            return None
        for index in range(len(self._past) - 1, -1, -1):
            if self._past[index].time <= time:
                return index
        return 0 if not self.known else None

    def _updated(self, b: Belief, innovation: float) -> Belief:
        wide = abs(innovation) > self._gate * math.sqrt(b.p11 + self._noise.sample**2)
        p11, p12, p22 = (self._noise.start**2, 0.0, self._noise.start**2) if wide else (b.p11, b.p12, b.p22)
        total = p11 + self._noise.sample**2
        k1, k2 = p11 / total, p12 / total
        if wide:
            # The offset that explains the new tool-face is not known better than the tool-face itself.
            k2 = 0.0
        return Belief(b.tool_face + k1 * innovation, b.offset + k2 * innovation,
                      (1.0 - k1) * p11, (1.0 - k1) * p12, p22 - k2 * p12)

    def _replay(self, index: int, belief: Belief) -> None:
        instants = list(self._past)
        instants[index] = _Instant(instants[index].time, belief, instants[index].drive)
        for k in range(index + 1, len(instants)):
            step = instants[k].time - instants[k - 1].time
            belief = self._propagate(belief, step, instants[k].drive)
            instants[k] = _Instant(instants[k].time, belief, instants[k].drive)
        self._past = deque(instants)

    def _propagate(self, b: Belief, step: float, drive: float) -> Belief:
        f = math.exp(-step / self.response_time)
        g = 1.0 - f
        # The lag is the model's weakest part: what it makes the tool-face do is doubted in proportion.
        pull = (drive + b.offset - b.tool_face) / self.response_time
        walk = self._noise.walk**2 + _DOUBT**2 * pull * pull * self.response_time
        drift = self._noise.drift**2 + _OFFSET_DOUBT**2 * pull * pull * self.response_time
        p11 = f * f * b.p11 + 2.0 * f * g * b.p12 + g * g * b.p22 + walk * step
        p12 = f * b.p12 + g * b.p22
        return Belief(f * b.tool_face + g * (drive + b.offset), b.offset,
                      p11, p12, b.p22 + drift * step)
