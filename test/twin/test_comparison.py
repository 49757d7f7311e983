"""The gap beside what it usually is."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.twin.channels import COMPARED
from slider_drilling.twin.comparison import Comparison
from slider_drilling.twin.motion import new_buffers

CHANGED, SEEN = 200.0, 260.0


@pytest.fixture
def comparison():
    """After four minutes in which the twin expects nothing, and the hook load leaves that after `CHANGED`, s."""
    time = np.arange(0.0, 400.0, 0.1)
    buffers = new_buffers(3600.0)
    buffers["hook_load"].add(time, np.where(time > CHANGED, 10.0, np.where(np.arange(time.size) % 2, 1.0, -1.0)))
    compared = Comparison(buffers, dict.fromkeys(COMPARED, 1.0), 2.0)

    def window(begin, end):
        grid = np.arange(begin, end, 0.1)
        return SimpleNamespace(time=grid, at=lambda values: np.zeros((grid.size, len(COMPARED))))

    def run(begin, end, changed):
        for now in np.arange(begin, end):
            compared.update(SimpleNamespace(window=window), np.empty(0), float(now), True, changed)
        return compared.threshold("hook_load")

    return run


def test_change_does_not_raise_the_threshold_that_it_exceeds(comparison):
    assert comparison(1.0, SEEN, math.inf) > 5.0, "not known yet"
    assert comparison(SEEN, 300.0, CHANGED) == pytest.approx(1.0, abs=0.05)


def test_threshold_is_unknown_where_nothing_is_known_from_before_a_change(comparison):
    comparison(170.0, SEEN, math.inf)
    assert math.isnan(comparison(SEEN, 300.0, CHANGED))
