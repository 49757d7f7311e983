"""What the twin knows of its rig: learnt in the first minutes, followed ever after."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.twin.calibration import RecursiveCalibration
from slider_drilling.twin.follower import Followed, Follower
from slider_drilling.twin.learning import RecordedBlock, Relearning
from slider_drilling.twin.report import Trend
from slider_drilling.twin.samples import Array
from slider_drilling.twin.tracked import TrackedParameter

_LONGEST_S = 900.0  # of recorded seconds while the rig does not settle
_RESTLESS_S = 480.0  # of them, after which drilling counts even while the drive rocks in other ways all the time
_TREND_MEMORY_S = 400.0
_TRENDS = {"motor_gain": "motor_gain", "circulating_pressure": "pressure_gain",
           "string_stiffness": "torsional_stiffness"}  # fmt: skip


class Learner:
    """Calibrates the plants over the first settled minutes, then follows slow changes.

    Args:
        parameters: What is tracked.
        noise: Noise level by channel.
        needed: s of settled work to learn from.
        make_follower: Returns plants in the state in which the rig began, around values (p,).

    Attributes:
        follower: The plants, in step with the rig.
        fixed: (p,) values that were learnt and stay; the nominal ones before.
        covariance: (p, p) of them.
        learnt: Whether learning is over.
        trends: The calibration that follows the rig.
    """

    def __init__(
        self, parameters: Sequence[TrackedParameter], noise: Mapping[str, float], needed: float,
        make_follower: Callable[[Array], Follower],
    ) -> None:  # fmt: skip
        self._parameters, self._noise, self._needed = tuple(parameters), noise, needed
        self._make_follower = make_follower
        self.fixed: Array = np.array([parameter.nominal for parameter in parameters], dtype=float)
        self.follower = make_follower(self.fixed)
        self.trends = self._new_calibration(_TREND_MEMORY_S)
        self.covariance: Array = self.trends.covariance
        self.learnt = False
        self._first = self._new_calibration(math.inf)
        self._blocks: list[RecordedBlock] = []
        self._settled = self._drilled = 0.0
        self._relearning: Relearning | None = None

    @property
    def values(self) -> Array:
        """(p,) the calibrated values now."""
        return self.trends.values

    @property
    def pressure_gain(self) -> float:
        """Circulating pressure over the rig file's, as it was learnt."""
        return float(self.fixed[[parameter.name for parameter in self._parameters].index("pressure_gain")])

    @property
    def share(self) -> float:
        """Share of the learning that is done, 0 to 1."""
        return 1.0 if self.learnt else min(self._settled / self._needed, 0.99)

    def _is_ready(self, recorded: float) -> tuple[bool, bool]:
        """Whether enough is recorded, s, and whether all drilling of it has to count."""
        restless = recorded >= _RESTLESS_S and self._drilled >= self._needed
        return self._settled >= self._needed or restless or recorded >= _LONGEST_S, restless

    def advance(self, commands: Commands, torque: Array) -> Followed:
        """Step the plants."""
        return self.follower.advance(commands, torque)

    def take(self, followed: Followed, block: RecordedBlock) -> bool:
        """Learn from one second; whether learning has just ended."""
        if block.settled:
            self.trends.add(followed, block.measured)
        if self.learnt:
            return False
        seconds = block.commands.time.size * float(block.commands.time[1] - block.commands.time[0])
        self._blocks.append(block)
        if self._relearning is None:
            self._settled += seconds * block.settled
            self._drilled += seconds * block.drilling
            if block.settled:
                self._first.add(followed, block.measured)
            ready, restless = self._is_ready(len(self._blocks) * seconds)
            if ready:
                self._relearning = Relearning(
                    self._make_follower, lambda: self._new_calibration(math.inf), self._first.values, restless
                )
        return self._relearning is not None and self._relearn()

    def trend_table(self) -> dict[str, Trend]:
        """The trends by name: friction is that of the whole hole."""
        names = [parameter.name for parameter in self._parameters]
        frictions = np.array([name.startswith("friction_") for name in names], dtype=float)
        table = {"friction": self.trends.trend(frictions / frictions.sum())}
        for title, name in _TRENDS.items():
            table[title] = self.trends.trend(np.array([each == name for each in names], dtype=float))
        offset = np.array([each == "hook_load_offset" for each in names], dtype=float)
        table["hook_load_offset"] = self.trends.trend(offset, "N")
        return table

    def _relearn(self) -> bool:
        assert self._relearning is not None
        done = self._relearning.work(self._blocks)
        if done is None:
            return False
        self.follower, calibration = done
        self.fixed, self.covariance = calibration.values, calibration.covariance
        self.trends.start_from(calibration)
        self.learnt, self._blocks, self._relearning = True, [], None
        return True

    def _new_calibration(self, memory: float) -> RecursiveCalibration:
        return RecursiveCalibration(self._parameters, self._noise, memory)
