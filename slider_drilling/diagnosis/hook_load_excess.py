"""What the hook load holds beyond the rig file: the block's weight, or that of a heavier string."""

from __future__ import annotations

import numpy as np

from slider_drilling.diagnosis.nuisance import hook_load_reading
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.gap.search.multi_start import plausible_range
from slider_drilling.units import Sentence, displayed, sentence

SHARES_OF_EXCESS = ("string_weight", "hook_load_offset", "hook_load_gain")
"""Calibrated numbers that share what the hook load holds beyond the rig file, as their priors allow."""


def hook_load_excess(diagnosis: Diagnosis) -> Sentence | None:
    """That calibration needs another weight on the hook than a good tare leaves, and of what it may be; else None.

    No slide distinguishes a tare from the weight of the string: both are the same all the time.
    """
    offset = diagnosis.tuned_parameters.get("hook_load_offset")
    low, high = plausible_range(next(each for each in hook_load_reading() if each.name == "hook_load_offset"))
    if offset is None or low <= offset.value <= high:
        return None
    traces = [trace for trace in diagnosis.traces if trace.channel == "hook_load" and "nominal" in trace.simulated]
    differences = [trace.measured - trace.simulated["nominal"] for trace in traces]
    excess = float(np.nanmean(np.concatenate(differences))) if differences else offset.value
    more, tare = ("more", "leaves the block's weight in") if excess > 0.0 else ("less", "takes off too much")
    return sentence(
        "The hook load reads ", displayed(abs(excess), "N", 2), f" {more} than the rig file explains: its tare {tare}, "
        f"or the string weighs {more}. Sliding cannot distinguish the two: weigh the block without the string.",
    )  # fmt: skip
