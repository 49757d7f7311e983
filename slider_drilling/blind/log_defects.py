"""What a recorder leaves out of a run: its beginning, whole series, most of the samples, the digits of an encoder."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NO_DEFECT = "nothing"


@dataclass(frozen=True)
class LogDefect:
    """begun: share of the run that is over when the recorder starts; without: series that no topic has, by their key
    in `messages.topics.TOPICS`; every: of so many samples one is kept; renewed: of so many samples one is new and the
    others repeat it; angle, speed, block: resolution of the top drive's encoder, rad and rad/s, and of the block's
    position, m, 0 for none.
    """

    start_share: float = 0.0
    missing_series: tuple[str, ...] = ()
    keep_every: int = 1
    hold_samples: int = 1
    angle_resolution: float = 0.0
    speed_resolution: float = 0.0
    block_resolution: float = 0.0

    def sample_rows(self, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Of a run's samples those that are stamped, and for each the one whose values it has."""
        stamped = np.arange(round(self.start_share * count), count, self.keep_every)
        return stamped, stamped[np.arange(stamped.size) // self.hold_samples * self.hold_samples]


Draw = Callable[[np.random.Generator], LogDefect]

LOG_DEFECTS: dict[str, Draw] = {
    NO_DEFECT: lambda generator: LogDefect(),
    "beginning": lambda generator: LogDefect(start_share=float(generator.uniform(0.1, 0.5))),
    "drawworks": lambda generator: LogDefect(missing_series=("draw_works",)),
    "pump": lambda generator: LogDefect(missing_series=("mud_pump",)),
    "samples": lambda generator: LogDefect(keep_every=int(generator.choice([2, 5, 10]))),
    "renewals": lambda generator: LogDefect(hold_samples=int(generator.choice([2, 5, 10]))),
    "resolution": lambda generator: LogDefect(angle_resolution=math.radians(generator.choice([0.35, 1.0, 2.0])),
                                         speed_resolution=2.0 * math.pi / 60.0 * generator.choice([0.1, 1.0]),
                                         block_resolution=float(generator.choice([0.0, 0.001, 0.01]))),
}  # fmt: skip
"""By what a log may lack. Encoders have 1,024, 360 and 180 steps a turn, speeds a tenth of a rpm or a whole one,
a block's position millimetres or centimetres."""
