"""Keeps simulated time with the wall's clock, and knows how far behind it is."""

from __future__ import annotations


class Pace:
    """speed: simulated seconds a wall second. Times given to the methods are s of any steady clock."""

    def __init__(self, speed: float, simulated: float, wall: float) -> None:
        self.speed = speed
        self._simulated, self._wall = simulated, wall
        self.lag = 0.0  # s of wall time, at the last sample
        self.worst_lag = 0.0  # s, since last asked

    def due(self, simulated: float) -> float:
        """When, on the wall's clock, this simulated time is due."""
        return self._wall + (simulated - self._simulated) / self.speed

    def note_sent(self, simulated: float, wall: float) -> None:
        """Note that the sample of this simulated time has been sent."""
        self.lag = wall - self.due(simulated)
        self.worst_lag = max(self.worst_lag, self.lag)

    def take_worst_lag(self) -> float:
        """The furthest behind since the last call, s of wall time."""
        worst, self.worst_lag = self.worst_lag, 0.0
        return worst

    def restart(self, simulated: float, wall: float) -> None:
        """Count from here on: what is lost is lost, and a burst to catch up would help nobody."""
        self._simulated, self._wall = simulated, wall
