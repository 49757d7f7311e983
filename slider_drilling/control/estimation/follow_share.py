"""Share of its expected turn that the toolface makes: contacts that hold firmly keep a bit that the string drives.

The driving twist turns the bit where contacts creep (Dahl) or where rocking reaches. Coulomb and elasto-plastic
contacts hold it until the twist tears it loose. Consecutive MWD samples show which of the two it is: their difference
is regressed on the turn that the driving twist should have made between them.
"""

from __future__ import annotations

import math
from collections import deque

_MEMORY = 45.0  # s, of the regression
_PRIOR_TURN = math.radians(12.0)  # rad, expected turn that counts as much as the prior, which is to follow
_HELD = 0.5  # share below which contacts hold the bit
_FOLLOWS = 0.65  # share from which on the toolface counts as following; below it turns by as much less
_MIN_MOBILITY = 0.03
_KEPT = 180.0  # s of expected turn that is kept: MWD arrives late


class FollowShare:
    """Regression of the measured turn on the expected one, with a prior that the toolface follows."""

    def __init__(self) -> None:
        self._expected: deque[tuple[float, float]] = deque()  # s; rad turned up to then
        self._last: tuple[float, float, float] | None = None  # s, rad measured, rad expected
        self._products = self._squares = 0.0  # rad2

    def forget(self) -> None:
        """Start again, as after a clock that has jumped."""
        self._expected.clear()
        self._last = None
        self._products = self._squares = 0.0

    def drive(self, time: float, turn: float) -> None:
        """Add the turn (rad) that the driving twist should have made by `time` (s) since the last call."""
        before = self._expected[-1][1] if self._expected else 0.0
        self._expected.append((time, before + turn))
        while self._expected[0][0] < time - _KEPT:
            self._expected.popleft()

    def observe(self, time: float, tool_face: float) -> None:
        """Take an accepted MWD sample: when it was read, s, and the toolface without its swing, rad."""
        if not self._expected:
            return
        expected, last = self._expected_at(time), self._last
        if last is not None and time <= last[0]:
            return
        self._last = (time, tool_face, expected)
        if last is None:
            return
        kept = math.exp(-(time - last[0]) / _MEMORY)
        turn = expected - last[2]
        # A whole turn cannot be seen: take the one nearest to what is expected of it.
        share = self.share
        measured = share * turn + math.remainder(tool_face - last[1] - share * turn, 2.0 * math.pi)
        self._products = kept * self._products + turn * measured
        self._squares = kept * self._squares + turn * turn

    @property
    def share(self) -> float:
        """Measured turn over expected turn; 1 where little was expected."""
        prior = _PRIOR_TURN**2
        return (self._products + prior) / (self._squares + prior)

    @property
    def held(self) -> bool:
        """Whether contacts hold the bit."""
        return self.share < _HELD

    @property
    def mobility(self) -> float:
        """Factor on the rate at which the driving twist turns the toolface: 1 where it follows."""
        return min(max(self.share / _FOLLOWS, _MIN_MOBILITY), 1.0)

    def _expected_at(self, time: float) -> float:
        """Expected turn up to a time (s), rad."""
        for instant, turn in reversed(self._expected):
            if instant <= time:
                return turn
        return self._expected[0][1]
