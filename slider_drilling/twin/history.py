"""The last minutes of what plant and rig did, second by second: bounded, whatever comes late."""

from __future__ import annotations

from collections import deque

import numpy as np

from slider_drilling.drillstring import Commands
from slider_drilling.twin.channels import COMPARED
from slider_drilling.twin.follower import Followed
from slider_drilling.twin.samples import Array

_CHANNELS = list(COMPARED)


class History:
    """What the plants did during the last s.

    Args:
        kept: s.
    """

    def __init__(self, kept: float) -> None:
        self._kept = kept
        self._blocks: deque[tuple[Followed, Commands]] = deque()

    def add(self, followed: Followed, commands: Commands) -> None:
        """Append a block; forget blocks that ended too long ago."""
        self._blocks.append((followed, commands))
        while self._blocks[0][0].time[-1] < followed.time[-1] - self._kept:
            self._blocks.popleft()

    def clear(self) -> None:
        """Forget all."""
        self._blocks.clear()

    def window(self, begin: float, end: float) -> Followed | None:
        """What the plants did from `begin` to `end`, s; None without a sample there."""
        blocks = [f for f, _ in self._blocks if f.time[-1] >= begin and f.time[0] <= end]
        if not blocks:
            return None
        time = np.concatenate([block.time for block in blocks])
        inside = (time >= begin) & (time <= end)
        if not inside.any():
            return None
        channels = np.concatenate([block.channels for block in blocks])[inside]
        sensitivity = np.concatenate([block.sensitivity for block in blocks])[inside]
        return Followed(time[inside], channels, sensitivity, blocks[-1].centre)

    def motion(self, begin: float, end: float) -> Commands | None:
        """The drives from `begin` to `end`, s; None without a sample there."""
        blocks = [c for f, c in self._blocks if f.time[-1] >= begin and f.time[0] <= end]
        if not blocks:
            return None
        names = ("time", "top_drive_angle", "top_drive_speed", "block_position", "block_speed", "pump_speed")
        whole = Commands(*(np.concatenate([getattr(c, name) for c in blocks]) for name in names))
        return whole.samples((whole.time >= begin) & (whole.time <= end))

    def at(self, channel: str, times: Array, values: Array) -> Array:
        """A channel of the twin with parameters `values` (p,) at other times (m,); NaN outside of what is kept."""
        found = self.window(float(times[0]) - 1.0, float(times[-1]) + 1.0) if times.size else None
        if found is None:
            return np.full(times.shape, np.nan)
        row = found.at(values)[:, _CHANNELS.index(channel)]
        return np.interp(times, found.time, row, left=np.nan, right=np.nan)
