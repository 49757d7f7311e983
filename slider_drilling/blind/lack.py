"""What a recorder leaves out of a run: its beginning, whole series, most of the samples, the digits of an encoder."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NOTHING = "nothing"


@dataclass(frozen=True)
class Lack:
    """begun: share of the run that is over when the recorder starts; without: series that no topic has, by their key
    in `messages.topics.TOPICS`; every: of so many samples one is kept; renewed: of so many samples one is new and the
    others repeat it; angle, speed, block: resolution of the top drive's encoder, rad and rad/s, and of the block's
    position, m, 0 for none.
    """

    begun: float = 0.0
    without: tuple[str, ...] = ()
    every: int = 1
    renewed: int = 1
    angle: float = 0.0
    speed: float = 0.0
    block: float = 0.0

    def rows(self, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Of a run's samples those that are stamped, and for each the one whose values it has."""
        stamped = np.arange(round(self.begun * count), count, self.every)
        return stamped, stamped[np.arange(stamped.size) // self.renewed * self.renewed]


Draw = Callable[[np.random.Generator], Lack]

LACKS: dict[str, Draw] = {
    NOTHING: lambda generator: Lack(),
    "beginning": lambda generator: Lack(begun=float(generator.uniform(0.1, 0.5))),
    "drawworks": lambda generator: Lack(without=("draw_works",)),
    "pump": lambda generator: Lack(without=("mud_pump",)),
    "samples": lambda generator: Lack(every=int(generator.choice([2, 5, 10]))),
    "renewals": lambda generator: Lack(renewed=int(generator.choice([2, 5, 10]))),
    "resolution": lambda generator: Lack(angle=math.radians(generator.choice([0.35, 1.0, 2.0])),
                                         speed=2.0 * math.pi / 60.0 * generator.choice([0.1, 1.0]),
                                         block=float(generator.choice([0.0, 0.001, 0.01]))),
}  # fmt: skip
"""By what a log may lack. Encoders have 1,024, 360 and 180 steps a turn, speeds a tenth of a rpm or a whole one,
a block's position millimetres or centimetres."""
