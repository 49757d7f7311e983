"""Keeps simulated time in step with wall time and measures how far it is behind."""

from __future__ import annotations


class Pace:
    """Simulated time against wall time.

    Args:
        speed: Simulated seconds per second of wall time.
        simulated: Simulated time at the start, s.
        wall: Wall time at the start, s of any steady clock.

    Attributes:
        lag: Wall time by which the last sample was late, s.
        worst_lag: The largest lag since `take_worst_lag`, s.
    """

    def __init__(self, speed: float, simulated: float, wall: float) -> None:
        self.speed = speed
        self.restart(simulated, wall)
        self.lag = self.worst_lag = 0.0

    def due(self, simulated: float) -> float:
        """The wall time at which a simulated time is due, s."""
        return self._wall + (simulated - self._simulated) / self.speed

    def note_sent(self, simulated: float, wall: float) -> None:
        """Note that the sample of a simulated time has been sent."""
        self.lag = wall - self.due(simulated)
        self.worst_lag = max(self.worst_lag, self.lag)

    def take_worst_lag(self) -> float:
        """The largest lag since the last call, s."""
        worst, self.worst_lag = self.worst_lag, 0.0
        return worst

    def restart(self, simulated: float, wall: float) -> None:
        """Count from here on; a burst of samples to catch up would help nobody."""
        self._simulated, self._wall = simulated, wall
