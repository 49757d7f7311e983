"""A stalled motor, by the pressure across it."""

from __future__ import annotations

import numpy as np
import pytest
from short_well import short_rig

from slider_drilling.drillstring import Commands
from slider_drilling.twin.stall_watch import StallWatch

RIG = short_rig()
LIMIT = RIG.motor.pressure_at_stall
PUMP = RIG.hydraulics.reference_flow / RIG.mud_pump.displacement
CIRCULATING = float(RIG.circulation_at(PUMP))


def _watched(across, pump=(), gain=1.0):
    """After seconds with these pressures across the motor, as shares of its stall pressure."""
    watch = StallWatch(RIG)
    speeds = pump or [PUMP] * len(across)
    for second, (share, speed) in enumerate(zip(across, speeds, strict=True)):
        time, still = second + 0.1 * np.arange(10), np.zeros(10)
        watch.update(
            Commands(time, still, still, still, still, np.full(10, speed)),
            np.full(10, gain * CIRCULATING + share * LIMIT), gain,
        )  # fmt: skip
    return watch.stall


def test_stall_pressure_for_three_seconds_is_a_stall():
    stall = _watched([0.5, 0.5, 1.0, 1.01, 1.0])
    assert stall.since == 2.0 and stall.ended is None
    assert stall.pressure == pytest.approx(1.01 * LIMIT) and stall.limit == LIMIT


@pytest.mark.parametrize("across", [[0.9] * 20, [0.5, 1.0, 1.0, 0.5, 1.0, 1.0], [float("nan")] * 9])
def test_less_or_shorter_is_none(across):
    assert _watched(across) is None


def test_stall_is_over_when_the_pressure_is_gone():
    assert _watched([1.0] * 5 + [0.9, 0.85, 0.3, 0.3]).ended == 7.0
    assert _watched([1.0] * 5 + [0.3, 0.3, 1.0, 1.0, 1.0]).since == 7.0


def test_circulating_pressure_counts_as_it_was_learnt():
    assert _watched([0.9] * 5, gain=1.2) is None and _watched([1.0] * 5, gain=1.2) is not None


def test_pressure_that_falls_after_the_flow_is_no_stall():
    """The standpipe still has the pressure of the old flow."""
    excess = float(CIRCULATING / LIMIT)
    assert excess > 1.0
    assert _watched([0.5] * 5, [PUMP] + [0.1 * PUMP] * 4) is None


def test_pump_off_is_no_stall():
    assert _watched([1.0] * 5, [0.0] * 5) is None
    assert _watched([1.0] * 7, [PUMP] * 4 + [0.0] * 3).ended == 4.0
