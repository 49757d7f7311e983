"""What a recorder can leave out of a log: the start, whole series, most samples, the digits of an encoder."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NO_DEFECT = "none"


@dataclass(frozen=True)
class LogDefect:
    """One way in which a log is incomplete.

    Attributes:
        start_share: Share of the run that is over when the recorder starts.
        missing_series: Keys in `messages.topics.TOPICS` of series that are not logged.
        keep_every: One of this many samples is kept.
        hold_samples: One of this many samples is new, the others repeat it.
        angle_resolution: Of the top drive's encoder, rad; 0 for none.
        speed_resolution: Of the top drive's speed, rad/s; 0 for none.
        block_resolution: Of the block position, m; 0 for none.
    """

    start_share: float = 0.0
    missing_series: tuple[str, ...] = ()
    keep_every: int = 1
    hold_samples: int = 1
    angle_resolution: float = 0.0
    speed_resolution: float = 0.0
    block_resolution: float = 0.0

    def sample_rows(self, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Returns which of a run's samples are logged, and for each of these the sample whose values it shows.

        Args:
            count: Samples of the run.
        """
        logged = np.arange(round(self.start_share * count), count, self.keep_every)
        return logged, logged[np.arange(logged.size) // self.hold_samples * self.hold_samples]


DrawDefect = Callable[[np.random.Generator], LogDefect]

LOG_DEFECTS: dict[str, DrawDefect] = {
    NO_DEFECT: lambda generator: LogDefect(),
    "late_start": lambda generator: LogDefect(start_share=float(generator.uniform(0.1, 0.5))),
    "no_drawworks": lambda generator: LogDefect(missing_series=("draw_works",)),
    "no_pump": lambda generator: LogDefect(missing_series=("mud_pump",)),
    "few_samples": lambda generator: LogDefect(keep_every=int(generator.choice([2, 5, 10]))),
    "held_samples": lambda generator: LogDefect(hold_samples=int(generator.choice([2, 5, 10]))),
    "coarse_values": lambda generator: LogDefect(
        # Encoders have 1024, 360 or 180 steps per turn; speeds are given to a tenth of a rev/min or to a whole one.
        angle_resolution=math.radians(generator.choice([0.35, 1.0, 2.0])),
        speed_resolution=2.0 * math.pi / 60.0 * generator.choice([0.1, 1.0]),
        block_resolution=float(generator.choice([0.0, 0.001, 0.01])),
    ),
}
"""Kinds of defects by name."""
