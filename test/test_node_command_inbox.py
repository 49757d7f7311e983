"""Commands that come late, twice, incomplete, stale, invalid or beyond the rig's limits. Runs without ROS."""

import math
import time

import pytest

from slider_drilling.control.interface import Level, RigCommand
from slider_drilling.files.installed_files import installed_file
from slider_drilling.nodes.command_inbox import BLOCK, PUMP, TOP_DRIVE, CommandInbox, CommandLimits
from slider_drilling.rig import dump_rig, load_rig, parse_rig

SECOND = 10**9
LIMITS = CommandLimits(top_drive_speed=126.0, block_speed=2.0, pump_speed=24.6)


def at(seconds, lockstep=False):
    """An inbox whose present sample is that of this time."""
    inbox = CommandInbox(pump_speed=12.0, timeout=1.0, lockstep=lockstep)
    inbox.now_ns = round(seconds * SECOND)
    return inbox


@pytest.mark.parametrize("lockstep", [True, False])
def test_inbox_returns_the_latest_commands(lockstep):
    inbox = at(0.0, lockstep)
    assert inbox.unanswered(0, (TOP_DRIVE, BLOCK)) == [TOP_DRIVE, BLOCK]
    held = inbox.command(0, 0.7)
    assert (held.top_drive_angle, held.top_drive_speed, held.block_speed, held.pump_speed) == (0.7, 0.0, 0.0, 12.0)
    inbox.now_ns = SECOND
    assert inbox.put(TOP_DRIVE, SECOND, 3.0, 2.0) is None
    assert inbox.put(BLOCK, SECOND, math.nan, 0.01) is None and inbox.put(PUMP, SECOND, math.nan, 11.0) is None
    assert inbox.unanswered(SECOND, (TOP_DRIVE, BLOCK, PUMP)) == []
    command = inbox.command(SECOND, 0.7)
    assert (command.top_drive_angle, command.top_drive_speed) == (3.0, 2.0)
    assert (command.block_speed, command.pump_speed) == (0.01, 11.0)


def test_unanswered_sample_holds_the_last_angle():
    inbox = at(1.0)
    inbox.put(TOP_DRIVE, SECOND, 3.0, 2.0)
    late = inbox.command(2 * SECOND, 2.9)
    assert (late.top_drive_angle, late.top_drive_speed) == (3.0, 0.0)


@pytest.mark.parametrize(("topic", "values"), [
    (TOP_DRIVE, (math.nan, 0.0)), (TOP_DRIVE, (0.0, math.inf)), (BLOCK, (0.0, math.nan)), (PUMP, (math.nan, math.inf)),
])
def test_nonfinite_commands_are_refused(topic, values):
    inbox = at(1.0)
    assert "not finite" in inbox.put(topic, SECOND, *values).reason
    assert inbox.refused == 1
    assert inbox.unanswered(0, (topic,)) == [topic]


@pytest.mark.parametrize(("topic", "values", "missing", "needed"), [
    (TOP_DRIVE, (math.nan, 2.0), "position nan", "give a position, rad"),
    (TOP_DRIVE, (math.nan, math.nan), "position nan", "a velocity alone is no command"),
    (BLOCK, (3.0, math.nan), "velocity nan", "give a velocity, m/s"),
    (PUMP, (3.0, math.nan), "velocity nan", "give a velocity, rad/s"),
])  # fmt: skip
def test_refusal_of_an_incomplete_command_says_what_is_missing(topic, values, missing, needed):
    reason = at(1.0).put(topic, SECOND, *values).reason
    assert reason.startswith(f"{missing} is missing") and needed in reason


@pytest.mark.parametrize(
    ("topic", "velocity", "said"),
    [
        (BLOCK, 50.0, "50 m/s is beyond 2 m/s, draw_works.max_speed of the rig file"),
        (BLOCK, -2.1, "draw_works.max_speed"),
        (PUMP, 1e9, "24.6 rad/s, mud_pump.max_speed of the rig file"),
        (PUMP, -1.0, "a pump does not turn backwards"),
        (TOP_DRIVE, -1e9, "top_drive.max_speed"),
    ],
)
@pytest.mark.parametrize("lockstep", [True, False])
def test_commands_beyond_the_rigs_limits_are_refused(topic, velocity, said, lockstep):
    inbox = CommandInbox(pump_speed=12.0, timeout=1.0, lockstep=lockstep, limits=LIMITS)
    refusal = inbox.put(topic, 0, 0.0, velocity)
    assert refusal.level is Level.ERROR and said in refusal.reason
    assert inbox.unanswered(0, (topic,)) == [topic]


def test_limits_come_from_the_rig_file():
    rig = load_rig(installed_file("config/rig.example.yaml"))
    assert CommandLimits.of(rig) == CommandLimits(pytest.approx(126.0), 2.0, pytest.approx(2.0 * 0.032 / 0.0026))
    slow = rig.with_({"draw_works.max_speed": 0.5, "mud_pump.max_speed": 13.0})
    assert (CommandLimits.of(slow).block_speed, CommandLimits.of(slow).pump_speed) == (0.5, 13.0)
    assert parse_rig(dump_rig(slow)) == slow and "draw_works" not in dump_rig(rig)


def test_position_alone_takes_speed_from_differences():
    inbox = at(5.0)
    assert inbox.put(TOP_DRIVE, 5 * SECOND, 1.0, math.nan) is None
    assert inbox.command(5 * SECOND, 0.0).top_drive_speed == 0.0
    inbox.now_ns = round(5.1 * SECOND)
    assert inbox.put(TOP_DRIVE, inbox.now_ns, 1.2, math.nan) is None
    command = inbox.command(inbox.now_ns, 0.0)
    assert (command.top_drive_angle, command.top_drive_speed) == (1.2, pytest.approx(2.0))
    inbox.now_ns = 9 * SECOND
    inbox.put(TOP_DRIVE, inbox.now_ns, 7.0, math.nan)
    assert inbox.command(inbox.now_ns, 0.0).top_drive_speed == 0.0, "after a pause"


def test_command_of_all_drives_is_taken_as_a_whole():
    inbox = CommandInbox(pump_speed=12.0, timeout=1.0, lockstep=True, limits=LIMITS)
    whole = {TOP_DRIVE: (1.0, 2.0), BLOCK: (math.nan, 0.01), PUMP: (math.nan, 11.0)}
    assert "draw_works" in inbox.put_all(0, whole | {BLOCK: (math.nan, 50.0)}).reason
    assert inbox.unanswered(0, whole) == [TOP_DRIVE, BLOCK, PUMP]
    assert inbox.put_all(0, whole) is None and inbox.unanswered(0, whole) == []
    assert inbox.command(0, 0.0) == RigCommand(1.0, 2.0, 0.01, 11.0)


def test_older_commands_are_refused():
    inbox = at(2.0)
    inbox.put(TOP_DRIVE, 2 * SECOND, 1.0, 0.0)
    assert "older" in inbox.put(TOP_DRIVE, 3 * SECOND // 2, 9.0, 0.0).reason
    assert inbox.command(2 * SECOND, 0.0).top_drive_angle == 1.0


@pytest.mark.parametrize("lockstep", [True, False])
def test_command_from_the_future_is_refused(lockstep):
    inbox = at(5.0, lockstep)
    refusal = inbox.put(TOP_DRIVE, time.time_ns(), 9.0, 0.0)
    assert refusal.level is Level.ERROR
    assert "ahead of the rig: that is the wall's clock; set use_sim_time" in refusal.reason
    assert inbox.unanswered(5 * SECOND, (TOP_DRIVE,)) == [TOP_DRIVE]
    assert inbox.put(TOP_DRIVE, 5 * SECOND, 1.0, 0.0) is None
    assert inbox.command(5 * SECOND, 0.0).top_drive_angle == 1.0


def test_command_slightly_ahead_is_taken():
    inbox = at(5.0)
    assert inbox.put(TOP_DRIVE, round(5.4 * SECOND), 1.0, 0.0) is None
    inbox.now_ns = round(5.1 * SECOND)
    assert inbox.put(TOP_DRIVE, round(5.1 * SECOND), 2.0, 0.0) is None
    assert inbox.command(inbox.now_ns, 0.0).top_drive_angle == 2.0


def test_lockstep_refuses_answers_to_future_samples():
    inbox = at(5.0, lockstep=True)
    assert inbox.put(TOP_DRIVE, round(5.1 * SECOND), 1.0, 0.0).level is Level.ERROR


def test_command_without_stamp_counts_in_real_time():
    inbox = at(50.0)
    assert inbox.put(BLOCK, 0, math.nan, 0.02) is None
    assert inbox.command(inbox.now_ns, 0.0).block_speed == 0.02


def test_block_stops_after_timeout_until_next_command():
    inbox = at(5.0)
    for topic in (TOP_DRIVE, BLOCK, PUMP):
        inbox.put(topic, 5 * SECOND, 3.0, 0.01)
    inbox.now_ns = 6 * SECOND
    assert inbox.timed_out() == [] and inbox.command(inbox.now_ns, 0.0).block_speed == 0.01
    inbox.now_ns = round(6.1 * SECOND)
    assert inbox.timed_out() == [TOP_DRIVE, BLOCK]
    left = inbox.command(inbox.now_ns, 0.0)
    assert (left.top_drive_angle, left.top_drive_speed, left.block_speed, left.pump_speed) == (3.0, 0.0, 0.0, 0.01)
    for topic in (TOP_DRIVE, BLOCK):
        inbox.put(topic, inbox.now_ns, 3.0, 0.02)
    assert inbox.timed_out() == [] and inbox.command(inbox.now_ns, 0.0).block_speed == 0.02


def test_lockstep_never_times_out():
    inbox = at(5.0, lockstep=True)
    inbox.put(BLOCK, 5 * SECOND, math.nan, 0.01)
    inbox.now_ns = 50 * SECOND
    assert inbox.timed_out() == [] and inbox.command(inbox.now_ns, 0.0).block_speed == 0.01


def test_two_answers_to_one_sample_are_a_conflict():
    inbox = at(5.0, lockstep=True)
    inbox.put(TOP_DRIVE, 5 * SECOND, 1.0, 0.0)
    assert inbox.conflict_ns is None
    inbox.put(TOP_DRIVE, 5 * SECOND, 1.5, 0.0)
    assert inbox.conflict_ns == 5 * SECOND
    again = at(5.0, lockstep=True)
    again.note_resent()
    again.put(TOP_DRIVE, 5 * SECOND, 1.0, 0.0)
    again.now_ns = 6 * SECOND
    again.put(TOP_DRIVE, 5 * SECOND, 1.0, 0.0)
    assert again.conflict_ns is None


def test_foreign_clocks_are_recognised():
    inbox = at(1e8)
    assert "this machine's uptime" in inbox.put(TOP_DRIVE, time.monotonic_ns(), 0.0, 0.0).reason
    assert "another clock" in inbox.put(TOP_DRIVE, round(2e8) * SECOND, 0.0, 0.0).reason
    assert "too late" in inbox.put(TOP_DRIVE, round(1e8 - 1.5) * SECOND, 0.0, 0.0).reason
