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


def sparse_samples(buffers: Mapping[str, SampleBuffer]) -> tuple[str, ...]:
    """One sentence for each channel that comes too seldom for what the twin does with it."""
    drive = max(_rate(buffers["top_drive_angle"]), _rate(buffers["top_drive_speed"]))
    said = []
    if 0.0 < drive < _DRIVE_RATE:
        said.append(
            f"the top drive is sampled at {drive:.2g} Hz, which does not show how it reverses: gaps are larger, and a "
            f"change may be none of the rig's; sample it at {_DRIVE_RATE:g} Hz or faster"
        )
    for name in SURFACE:
        rate = _rate(buffers[name])
        if 0.0 < rate < _COMPARED_RATE:
            said.append(
                f"{COMPARED[name].title} is sampled at {rate:.2g} Hz: it shows no change; sample it at "
                f"{_COMPARED_RATE:g} Hz or faster"
            )
    return tuple(said)


def _rate(buffer: SampleBuffer) -> float:
    """Samples a second, Hz; 0 where there are too few to tell."""
    return round(1.0 / float(np.median(np.diff(buffer.time))), 2) if len(buffer) > 1 else 0.0
