"""A noisy sensor that repeats its reading to the last digit is stuck."""

from __future__ import annotations

import math

_FALSE_ALARM = 1e-6   # probability that a healthy sensor at rest repeats its reading as often


class RepeatedReading:
    """Counts equal readings of a sensor whose noise would change them.

    The most likely reading of a value at rest comes with probability ``p = erf(r / (sqrt(8) sigma))``, with the
    resolution r and the standard deviation sigma. So many in a row that ``p^n`` is a false alarm's probability mean a
    sensor that is stuck.

    Args:
        sigma: Standard deviation of a reading; 0: it may repeat.
        resolution: Step of the readings.
    """

    def __init__(self, sigma: float, resolution: float):
        likeliest = math.erf(resolution / (math.sqrt(8.0) * sigma)) if sigma > 0.0 else 1.0
        # A sensor without noise may repeat for ever; readings without steps do not repeat at all.
        self._limit = math.log(_FALSE_ALARM) / math.log(max(likeliest, _FALSE_ALARM)) if likeliest < 1.0 else math.inf
        self._reading = math.nan
        self._since = math.nan   # time of the first of the equal readings
        self.count = 0

    def update(self, reading: float, time: float) -> None:
        """Take one reading, and when it was made."""
        if reading != self._reading:
            self._reading, self._since, self.count = reading, time, 0
        self.count += 1

    @property
    def stuck(self) -> bool:
        """Whether the sensor is stuck."""
        return self.count > self._limit

    @property
    def since(self) -> float:
        """Time of the first of the equal readings."""
        return self._since
