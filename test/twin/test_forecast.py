import numpy as np
import pytest

from slider_drilling.drillstring import Commands
from slider_drilling.twin.forecast import ToolFaceSkill, best_lag, continued
from slider_drilling.twin.report import Forecast


def _rocking(period, duration, drift=0.0):
    time = np.arange(0.0, duration, 0.1)
    angle = 6.0 * np.sin(2.0 * np.pi * time / period) + drift * time
    speed = 6.0 * 2.0 * np.pi / period * np.cos(2.0 * np.pi * time / period) + drift
    still = np.zeros_like(time)
    return Commands(time, angle, speed, 0.002 * time, still + 0.002, still + 12.0)


@pytest.mark.parametrize("period", [6.73, 8.0, 13.37])
def test_rocking_goes_on_with_its_period(period):
    whole = _rocking(period, 200.0)
    ahead = continued(whole.samples(whole.time < 140.0), period, 60.0, 0.1)
    known = whole.samples((whole.time > 140.0 - 0.01) & (whole.time < 199.95))
    error = ahead.top_drive_angle[: known.time.size] - known.top_drive_angle[: ahead.time.size]
    # A lag of whole samples is off by up to 0.05 s in each of the repeated periods.
    bound = 0.05 * 60.0 / period * 6.0 * 2.0 * np.pi / period
    assert np.max(np.abs(error)) < bound + 0.3
    assert abs(np.mean(error)) < 0.2


def test_repeated_motion_has_no_jump():
    past = _rocking(6.73, 140.0)
    ahead = continued(past, 6.73, 60.0, 0.1)
    angles = np.concatenate([past.top_drive_angle[-20:], ahead.top_drive_angle])
    assert np.max(np.abs(np.diff(angles))) < 1.5 * np.max(np.abs(past.top_drive_speed)) * 0.1


def test_block_goes_on_at_its_mean_speed():
    ahead = continued(_rocking(8.0, 140.0), 8.0, 60.0, 0.1)
    assert ahead.block_speed == pytest.approx(np.full(600, 0.002))
    assert ahead.block_position[-1] == pytest.approx(0.002 * 199.9)


def test_drive_that_does_not_rock_keeps_its_speed():
    time = np.arange(0.0, 20.0, 0.1)
    still = np.zeros_like(time)
    ahead = continued(Commands(time, 3.0 * time, still + 3.0, still, still, still), None, 10.0, 0.1)
    assert ahead.top_drive_angle[-1] == pytest.approx(3.0 * 29.9)


def test_short_past_has_no_lag():
    assert best_lag(np.zeros(50), 8.0, 0.1) is None


def _forecast(made_at, change):
    time = made_at + np.array([30.0, 60.0])
    return Forecast(made_at, time, np.array([0.5 * change, change]), np.zeros(2))


def test_toolface_stays_where_forecasts_failed():
    skill = ToolFaceSkill()
    for index in range(30):
        shrunk = skill.shrunk(_forecast(60.0 * index, 1.5), 0.0, 0.0, 0.4)
    assert shrunk.tool_face[-1] == pytest.approx(0.4, abs=0.05)


def test_toolface_follows_forecasts_that_come_true():
    skill, reading = ToolFaceSkill(), 0.0
    for index in range(60):
        shrunk = skill.shrunk(_forecast(60.0 * index, 0.8), 0.0, 0.0, reading)
        reading = (reading + 0.8 + np.pi) % (2.0 * np.pi) - np.pi
    assert skill.share > 0.7
    assert shrunk.tool_face[-1] - shrunk.tool_face[0] == pytest.approx(0.4 * skill.share, rel=1e-6)
