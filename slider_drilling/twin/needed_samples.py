"""What a twin needs of a rig's samples, and what it says where they are too few."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slider_drilling.twin.channels import COMPARED, SURFACE
from slider_drilling.twin.samples import SampleBuffer

FIRST_S = 3.0
"""s of data, from which the initial state is inferred."""
ALWAYS_LEARNT_S = 1080.0
"""s of a record after which the twin has learnt, whatever the rig does: see `learner` and `learning`."""
_DRIVE_RATE = 4.0  # Hz, from which on samples of the top drive show how it reverses
_COMPARED_RATE = 1.0  # Hz, below which less than half of a window's samples lies near a measured one (`features`)


def too_short(source: str, span: float) -> str:
    """Why a record of so many s cannot be watched."""
    return (
        f"{source}: shows {span:.1f} s of the top drive; the twin needs {FIRST_S:.0f} s to begin, and some minutes "
        "to learn the rig; give a longer record"
    )


def nothing_compared(learnt: bool, share: float, needed: float) -> str:
    """Why no change could show, and what the twin needs.

    Args:
        learnt: Whether learning is over.
        share: Of the settled work that it needs, so far.
        needed: s of settled work.
    """
    if learnt:
        return (
            "the twin learnt the rig, but no work that it compares came after that, so nothing was compared; give a "
            "longer record"
        )
    return (
        f"the twin never finished learning the rig ({100.0 * share:.0f} % of the {needed:.0f} s of settled work that "
        f"it needs), so nothing was compared; give a longer record: {ALWAYS_LEARNT_S / 60.0:.0f} minutes are always "
        "enough"
    )


class SparseSamples:
    """Says once of each channel that it comes too seldom for what the twin does with it, and of a pump that none comes.

    Args:
        buffers: Samples by channel.
    """

    def __init__(self, buffers: Mapping[str, SampleBuffer]) -> None:
        self._buffers = buffers
        self._said: set[str] = set()

    def remarks(self, begin: float, end: float) -> tuple[str, ...]:
        """One sentence for each channel that is new, by its samples from `begin` to `end`, s."""
        rates = {name: self._rate(name, begin, end) for name in ("top_drive_angle", "top_drive_speed", *SURFACE)}
        drive, said = max(rates["top_drive_angle"], rates["top_drive_speed"]), {}
        if 0.0 < drive < _DRIVE_RATE:
            said["top_drive"] = (
                f"the top drive is sampled at {drive:.2g} Hz, which does not show how it reverses: gaps are larger, "
                f"and a change may be none of the rig's; sample it at {_DRIVE_RATE:g} Hz or faster"
            )
        for name in SURFACE:
            if 0.0 < rates[name] < _COMPARED_RATE:
                said[name] = (
                    f"{COMPARED[name].title} is sampled at {rates[name]:.2g} Hz: it shows no change; sample it at "
                    f"{_COMPARED_RATE:g} Hz or faster"
                )
        # Topics and items need not come up at once.
        if end - begin > FIRST_S and not len(self._buffers["pump_speed"]):
            as_far = ", as far as the pressure agrees" if len(self._buffers["standpipe_pressure"]) else ""
            assumed = f"the flow is assumed to be the rig file's reference flow{as_far}"
            said["pump_speed"] = f"the pump is not sent: {assumed}"
        new = tuple(text for name, text in said.items() if name not in self._said)
        self._said |= set(said)
        return new

    def _rate(self, name: str, begin: float, end: float) -> float:
        """Samples a second, Hz; 0 where there are too few to tell."""
        time, _ = self._buffers[name].window(begin, end)
        return round(1.0 / float(np.median(np.diff(time))), 2) if time.size > 1 else 0.0
