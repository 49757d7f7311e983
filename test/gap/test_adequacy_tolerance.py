"""A channel's tolerance: an error that nobody would act upon is no gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from toy import TIME, Toy, toy

from slider_drilling.gap import explain


def with_wave(size: float, tolerance: float) -> Toy:
    """A toy with a wave that no effect has, in a channel with a tolerance."""
    model = toy({"level": 2.0}, 5, extra=size * np.sin(2.0 * np.pi * TIME / 31.0))
    (run,) = model.runs
    channels = tuple(replace(channel, tolerance=tolerance) for channel in run.channels)
    # The whole counts the channel too: its gap stays below the threshold of the whole.
    return replace(model, runs=(replace(run, channels=channels),), effects=())


@pytest.mark.parametrize(("tolerance", "verdict"), [(0.0, "unknown"), (2.0, "parameters")])
def test_error_within_the_tolerance_is_no_gap(tolerance, verdict):
    assert explain(with_wave(0.95, tolerance)).verdict == verdict
