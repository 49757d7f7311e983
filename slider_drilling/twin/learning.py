"""Learning: once the twin has seen some minutes, it simulates them again with better numbers, and then takes over.

The plants run thousands of times faster than the rig. The minutes learnt are simulated again in slices of some
milliseconds, one with every second of the rig, until they have caught up with it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from slider_drilling.drillstring import Commands
from slider_drilling.twin.calibration import RecursiveCalibration
from slider_drilling.twin.follower import Follower
from slider_drilling.twin.samples import Array

_ROUNDS = 3
_BLOCKS_A_SLICE = 20


@dataclass(frozen=True)
class RecordedBlock:
    """What the rig did in one second.

    Attributes:
        commands: Its drives.
        measured: By channel, (n,), NaN where nothing was measured.
        settled: Whether the rig had settled.
        drilling: Whether it had but for its rocking, see `activity.Activity`.
    """

    commands: Commands
    measured: Mapping[str, Array]
    settled: bool
    drilling: bool


class Relearning:
    """Gauss-Newton over recorded blocks; every round simulates all of them around the values of the one before.

    Args:
        make_follower: Returns plants in the state in which the blocks begin, around values (p,).
        make_calibration: Returns an empty calibration.
        values: (p,) to begin with.
        unsettled: Whether drilling counts however the drive rocks.
    """

    def __init__(
        self, make_follower: Callable[[Array], Follower], make_calibration: Callable[[], RecursiveCalibration],
        values: Array, unsettled: bool = False,
    ) -> None:  # fmt: skip
        self._make_follower, self._make_calibration = make_follower, make_calibration
        self._unsettled = unsettled
        self._round, self._next = 0, 0
        self._begin(values)

    def work(self, blocks: list[RecordedBlock]) -> tuple[Follower, RecursiveCalibration] | None:
        """Simulate some more of the blocks; the plants and their calibration once they have caught up with the last.

        Args:
            blocks: All blocks since the learning began, the latest second too.
        """
        for _ in range(_BLOCKS_A_SLICE):
            if self._next == len(blocks):
                if self._round == _ROUNDS - 1:
                    return self._follower, self._calibration
                self._round += 1
                self._begin(self._calibration.values)
                continue
            block = blocks[self._next]
            followed = self._follower.advance(block.commands, block.measured["surface_torque"])
            if block.settled or (self._unsettled and block.drilling):
                self._calibration.add(followed, block.measured)
            self._next += 1
        return None

    def _begin(self, values: Array) -> None:
        self._next = 0
        self._follower = self._make_follower(values)
        self._calibration = self._make_calibration()
