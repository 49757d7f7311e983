"""What a node makes of messages that come late, twice, out of order, stale or with nonsense in them. No ROS needed."""

import math

import pytest

from slider_drilling.nodes.command_inbox import BLOCK, PUMP, TOP_DRIVE, CommandInbox
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.sample_inbox import Joint, SampleInbox

SECOND = 10**9


def reading(seconds, position=0.0, velocity=0.0, effort=0.0):
    return Joint(round(seconds * SECOND), position, velocity, effort)


def fill(inbox, seconds):
    """Every channel but the top drive's."""
    found = []
    for channel in SampleInbox.CHANNELS:
        found += inbox.put(channel, reading(seconds, 1.0, 2.0, 3.0))
    return found


@pytest.mark.parametrize("top_drive_first", [True, False])
def test_a_sample_is_complete_when_every_channel_is_there(top_drive_first):
    inbox = SampleInbox(stale_after=1.0)
    found = inbox.put("top_drive", reading(5.0, 7.0, 8.0, 9.0)) if top_drive_first else []
    assert found == []
    found += fill(inbox, 5.0)
    if not top_drive_first:
        assert found == []
        found = inbox.put("top_drive", reading(5.0, 7.0, 8.0, 9.0))
    (sample,) = found
    assert (sample.time, sample.top_drive_angle, sample.top_drive_speed, sample.surface_torque) == (5.0, 7.0, 8.0, 9.0)
    assert (sample.block_position, sample.block_speed, sample.hook_load) == (1.0, 2.0, 3.0)
    assert (sample.standpipe_pressure, sample.pump_speed) == (1.0, 2.0)


def test_the_next_sample_does_not_wait_for_a_lost_message():
    inbox = SampleInbox(stale_after=1.0)
    fill(inbox, 5.0)
    inbox.put("top_drive", reading(5.0))
    inbox.put("mud_pump", reading(5.1, 0.0, 4.0))
    assert inbox.put("top_drive", reading(5.1, 1.0)) == []
    (sample,) = inbox.put("top_drive", reading(5.2, 2.0))
    assert (sample.time, sample.top_drive_angle, sample.pump_speed, sample.standpipe_pressure) == (5.1, 1.0, 4.0, 1.0)


def test_a_channel_that_went_silent_is_nan_and_not_waited_for():
    inbox = SampleInbox(stale_after=1.0)
    fill(inbox, 5.0)
    inbox.put("top_drive", reading(5.0))
    found = []
    for k in range(51, 70):
        for channel in ("draw_works", "mud_pump"):
            found += inbox.put(channel, reading(k / 10, 1.0, 2.0, 3.0))
        found += inbox.put("top_drive", reading(k / 10))
    assert math.isnan(found[-1].standpipe_pressure) and found[-1].hook_load == 3.0
    assert found[-1].time == 6.9
    assert inbox.stale(round(6.9 * SECOND)) == ["standpipe_pressure"]


def test_a_channel_that_never_came_is_nan():
    inbox = SampleInbox(stale_after=1.0)
    found = [sample for k in range(30) for sample in inbox.put("top_drive", reading(k / 10))]
    assert found[-1].time == 2.9
    assert math.isnan(found[-1].hook_load) and math.isnan(found[0].hook_load)


def test_mwd_goes_with_the_next_sample_once():
    inbox = SampleInbox(stale_after=1.0)
    fill(inbox, 18.0)
    inbox.put_mwd(12 * SECOND, 0.5)
    (sample,) = inbox.put("top_drive", reading(18.0))
    assert [(m.measured_at, m.arrived_at, m.tool_face) for m in sample.mwd] == [(12.0, 18.0, 0.5)]
    fill(inbox, 18.1)
    (following,) = inbox.put("top_drive", reading(18.1))
    assert following.mwd == ()


def test_a_clock_set_back_goes_on():
    inbox = SampleInbox(stale_after=1.0)
    fill(inbox, 100.0)
    inbox.put("top_drive", reading(100.0))
    fill(inbox, 0.0)
    (sample,) = inbox.put("top_drive", reading(0.0))
    assert sample.time == 0.0 and sample.hook_load == 3.0


def test_commands_for_a_sample():
    inbox = CommandInbox(pump_speed=12.0)
    assert inbox.missing(0, (TOP_DRIVE, BLOCK)) == [TOP_DRIVE, BLOCK]
    held = inbox.command(0, 0.7)
    assert (held.top_drive_angle, held.top_drive_speed, held.block_speed, held.pump_speed) == (0.7, 0.0, 0.0, 12.0)
    assert inbox.put(TOP_DRIVE, SECOND, 3.0, 2.0) and inbox.put(BLOCK, SECOND, math.nan, 0.01)
    assert inbox.put(PUMP, SECOND, math.nan, 11.0)
    assert inbox.missing(SECOND, (TOP_DRIVE, BLOCK, PUMP)) == []
    command = inbox.command(SECOND, 0.7)
    assert (command.top_drive_angle, command.top_drive_speed) == (3.0, 2.0)
    assert (command.block_speed, command.pump_speed) == (0.01, 11.0)


def test_an_unanswered_sample_stands_still_at_the_last_angle():
    inbox = CommandInbox(pump_speed=12.0)
    inbox.put(TOP_DRIVE, SECOND, 3.0, 2.0)
    late = inbox.command(2 * SECOND, 2.9)
    assert (late.top_drive_angle, late.top_drive_speed) == (3.0, 0.0)


@pytest.mark.parametrize(("topic", "values"), [
    (TOP_DRIVE, (math.nan, 0.0)), (TOP_DRIVE, (0.0, math.inf)), (BLOCK, (0.0, math.nan)), (PUMP, (math.nan, math.inf)),
])
def test_commands_that_are_not_finite_are_refused(topic, values):
    inbox = CommandInbox(pump_speed=12.0)
    assert not inbox.put(topic, SECOND, *values)
    assert inbox.refused == 1
    assert inbox.missing(0, (topic,)) == [topic]


def test_older_commands_are_refused():
    inbox = CommandInbox(pump_speed=12.0)
    inbox.put(TOP_DRIVE, 2 * SECOND, 1.0, 0.0)
    assert not inbox.put(TOP_DRIVE, SECOND, 9.0, 0.0)
    assert inbox.command(2 * SECOND, 0.0).top_drive_angle == 1.0


def test_pace():
    pace = Pace(speed=4.0, simulated=10.0, wall=100.0)
    assert pace.due(12.0) == 100.5
    pace.passed(12.0, 100.75)
    pace.passed(14.0, 101.0)
    assert (pace.behind, pace.take_worst_behind(), pace.take_worst_behind()) == (0.0, 0.25, 0.0)
    pace.forgive(14.0, 103.0)
    assert pace.due(18.0) == 104.0
