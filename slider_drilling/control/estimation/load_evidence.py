"""Weight on bit by three channels: standpipe pressure, surface torque and hook load.

What each channel can tell:

* pressure: ``W_p = k_m (SPP - p_circ(Q)) / lever``, with k_m the motor's torque per pressure and the lever the bit's
  torque per weight;
* torque: friction cancels over a rocking cycle, so the mean surface torque M is the reactive torque while the toolface
  is at rest, ``W_t = M / (kappa lever)``;
* hook load: what has left the hook since the string hung off bottom, D, is weight on bit plus drag: ``W_h = D - drag``;
* rate of penetration: the block's speed less the stretch of the string, in proportion to the weight;
* twist: the top drive turns further than the toolface by the compliance times the torque that the string carries. It
  shows changes of the torque without the torque sensor.

The scale kappa between torque and pressure (torque sensor, motor) is learnt in a reference period of steady drilling,
and stays. Drag changes with friction, so it is learnt all the time, slowly. The off-bottom pressure that torque
implies, ``SPP - M / (kappa k_m)``, is tracked over time.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

_REFERENCE_TIME = 120.0   # s of steady drilling
_MAX_SCALE = 1.15         # more than that is pressure that was lost during the reference period
_SMOOTHING_TIME = 25.0    # s, of the difference between torque and pressure
# Drag is learnt with a time constant (s) and a largest rate (N/s): quickly while the load comes on, then so that it
# follows friction and not a hook load that jumps.
_FIRST_DRAG, _LATER_DRAG = (30.0, 1000.0), (60.0, 250.0)
_HISTORY_TIME = 1800.0    # s
RATE_WINDOW = 90.0            # s, of the averages that are compared before and after a fault


@dataclass(frozen=True)
class LoadSample:
    """What the channels say of the load over one rocking cycle.

    Attributes:
        time: End of the cycle, s.
        duration: Since the last sample, s.
        torque: Mean surface torque, N m.
        reactive_torque: From pressure by the rig file's motor, N m.
        hook_deficit: D, N; NaN where unknown.
        block_position: m; NaN where unknown.
        twist_torque: That the twist of the string stands for, but for a constant, N m; NaN where unknown.
        difference: Torque less what pressure stands for, smoothed, N m.
    """

    time: float
    duration: float
    torque: float
    reactive_torque: float
    hook_deficit: float
    block_position: float
    twist_torque: float = math.nan
    difference: float = 0.0


@dataclass(frozen=True)
class LoadChange:
    """How much the load has changed since the channels agreed, by each of them, N.

    `rate` is NaN where the block shows no rate, `twist` where the toolface is unknown.
    """

    pressure: float
    torque: float
    hook_load: float
    rate: float
    twist: float


class LoadEvidence:
    """Compares the channels, cycle by cycle.

    Args:
        lever: Bit torque over weight on bit, m.
        stiffness: Of the string between block and bit, N/m.

    Attributes:
        scale: kappa.
        known: Whether the reference period has ended.
        difference: M - kappa k_m dP, smoothed, N m.
        drag: Learnt, N; NaN before the first sample.
    """

    def __init__(self, lever: float, stiffness: float):
        self._lever = lever
        self._stiffness = stiffness
        self.scale = 1.0
        self.known = False
        self.difference = 0.0
        self.drag = math.nan
        self._samples: deque[LoadSample] = deque()
        self._learnt_for = self._torque_sum = self._reactive_sum = 0.0

    def take(self, sample: LoadSample, steady: bool, consistent: bool) -> None:
        """Take one cycle.

        Args:
            sample: What it shows.
            steady: Whether the bit is loaded and the toolface at its target, as the reference needs.
            consistent: Whether the channels agree, so that drag may be learnt.
        """
        if steady and not self.known:
            self._learn_scale(sample)
        difference = sample.torque - self.scale * sample.reactive_torque
        weight = 1.0 - math.exp(-sample.duration / _SMOOTHING_TIME)
        self.difference += weight * (difference - self.difference)
        self._samples.append(replace(sample, difference=self.difference))
        while self._samples[0].time < sample.time - _HISTORY_TIME:
            self._samples.popleft()
        if consistent:
            self._learn_drag(sample)

    def _learn_scale(self, sample: LoadSample) -> None:
        self._learnt_for += sample.duration
        self._torque_sum += sample.duration * sample.torque
        self._reactive_sum += sample.duration * sample.reactive_torque
        if self._learnt_for >= _REFERENCE_TIME and self._reactive_sum > 0.0 and self._torque_sum > 0.0:
            self.scale = min(self._torque_sum / self._reactive_sum, _MAX_SCALE)
            self.known = True
            self.difference = 0.0
            self._samples.clear()

    def _learn_drag(self, sample: LoadSample) -> None:
        """The larger of two weights leaves the smaller drag, and so never too small a weight by hook load."""
        if not math.isfinite(sample.hook_deficit):
            return
        drag = sample.hook_deficit - max(self.by_pressure(sample), self.by_torque(sample))
        if math.isnan(self.drag):
            self.drag = drag
        time, rate = _LATER_DRAG if self.known else _FIRST_DRAG
        change = (1.0 - math.exp(-sample.duration / time)) * (drag - self.drag)
        limit = rate * sample.duration
        self.drag += min(max(change, -limit), limit)

    def by_pressure(self, sample: LoadSample) -> float:
        """Weight on bit by pressure, N."""
        return sample.reactive_torque / self._lever

    def by_torque(self, sample: LoadSample) -> float:
        """Weight on bit by mean surface torque, N; never too small: more torque than pressure may be a strong motor."""
        return sample.torque / (min(self.scale, 1.0) * self._lever)

    def by_twist(self, sample: LoadSample) -> float:
        """Weight on bit by the twist of the string, but for a constant, N; NaN where unknown."""
        return sample.twist_torque / (min(self.scale, 1.0) * self._lever)

    def by_hook_load(self, hook_deficit: float) -> float:
        """Weight on bit by hook load, N; NaN before any drag was learnt."""
        return hook_deficit - self.drag

    @property
    def learning(self) -> bool:
        """Whether the reference period has begun."""
        return self._learnt_for > 0.0

    @property
    def pressure_change(self) -> float:
        """Torque by which the off-bottom pressure seems to have changed, N m; negative where pressure is missing."""
        return -self.difference / self.scale

    def onset(self, tolerated: float) -> float:
        """Time (s) since which the difference has been beyond this magnitude (N m), or of the first sample."""
        for sample in reversed(self._samples):
            if abs(sample.difference) <= tolerated:
                return sample.time
        return self._samples[0].time

    def change_since(self, time: float) -> LoadChange | None:
        """Change of the load by each channel since a time (s); None where too little is known of either."""
        before = [sample for sample in self._samples if time - RATE_WINDOW <= sample.time <= time]
        now = [sample for sample in self._samples if sample.time > max(self._samples[-1].time - RATE_WINDOW, time)]
        if len(before) < 2 or len(now) < 2:
            return None
        pressure, torque, hook, twist = (
            _mean(now, value) - _mean(before, value)
            for value in (self.by_pressure, self.by_torque, lambda sample: sample.hook_deficit, self.by_twist))
        then, rate = self._rate(before), self._rate(now)
        by_rate = (rate / then - 1.0) * _mean(before, self.by_torque) if then > 0.0 else math.nan
        return LoadChange(pressure, torque, hook, by_rate, twist)

    def _rate(self, samples: list[LoadSample]) -> float:
        """Rate of penetration over these samples, m/s: the block less the stretch of the string."""
        first, last = samples[0], samples[-1]
        # Weight on the bit and drag shorten the string, so the block goes further than the bit.
        stretch = (last.hook_deficit - first.hook_deficit) / self._stiffness
        return (last.block_position - first.block_position - stretch) / (last.time - first.time)


def _mean(samples: list[LoadSample], value: Callable[[LoadSample], float]) -> float:
    return sum(value(sample) for sample in samples) / len(samples)
