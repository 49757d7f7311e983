"""Messages that come late, twice, out of order, stale or invalid. Runs without ROS."""

import math
import time

import pytest

from slider_drilling.control.interface import Level, RigCommand
from slider_drilling.files.installed_files import installed_file
from slider_drilling.nodes.clock_check import ClockFaultReports, clock_offset_message
from slider_drilling.nodes.command_inbox import BLOCK, PUMP, TOP_DRIVE, CommandInbox, CommandLimits
from slider_drilling.nodes.late_joiners import FIRST_RESEND_AFTER, RESEND_PERIOD, LateJoiners
from slider_drilling.nodes.own_echoes import OwnEchoes
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.safe_stop import safe_stop
from slider_drilling.nodes.sample_inbox import JointReading, SampleInbox
from slider_drilling.nodes.watchdog import Watchdog
from slider_drilling.rig import dump_rig, load_rig, parse_rig

SECOND = 10**9


def reading(seconds, position=0.0, velocity=0.0, effort=0.0):
    return JointReading(round(seconds * SECOND), position, velocity, effort)


def fill(inbox, seconds):
    """Every channel but the top drive's."""
    found = []
    for channel in SampleInbox.CHANNELS:
        found += inbox.put(channel, reading(seconds, 1.0, 2.0, 3.0))
    return found


@pytest.mark.parametrize("top_drive_first", [True, False])
def test_sample_is_complete_with_every_channel(top_drive_first):
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


def test_next_sample_does_not_wait_for_lost_message():
    inbox = SampleInbox(stale_after=1.0)
    fill(inbox, 5.0)
    inbox.put("top_drive", reading(5.0))
    inbox.put("mud_pump", reading(5.1, 0.0, 4.0))
    assert inbox.put("top_drive", reading(5.1, 1.0)) == []
    (sample,) = inbox.put("top_drive", reading(5.2, 2.0))
    assert (sample.time, sample.top_drive_angle, sample.pump_speed, sample.standpipe_pressure) == (5.1, 1.0, 4.0, 1.0)


def test_silent_channel_is_nan_without_waiting():
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
    assert inbox.stale_channels(round(6.9 * SECOND)) == ["standpipe_pressure"]


def test_channel_that_never_came_is_nan():
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


def test_samples_continue_after_clock_set_back():
    inbox = SampleInbox(stale_after=1.0)
    fill(inbox, 100.0)
    inbox.put("top_drive", reading(100.0))
    fill(inbox, 0.0)
    (sample,) = inbox.put("top_drive", reading(0.0))
    assert sample.time == 0.0 and sample.hook_load == 3.0


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


def test_clock_fault_is_said_once_and_again_when_it_has_changed():
    reports = ClockFaultReports(0.0)

    def is_said(now, offset, sim_time=True):
        message = clock_offset_message(round(offset * SECOND) + 10**15, 10**15, sim_time)
        return reports.is_due(message, offset, now, 5.0)

    assert not is_said(4.0, -20.0)  # the clock may come late
    assert is_said(6.0, -20.0)
    assert not any(is_said(float(now), -20.0 - 0.01 * now) for now in range(7, 300))
    assert is_said(307.0, -23.0)  # it lasts
    assert is_said(313.0, -60.0) and not is_said(316.0, 60.0)
    assert is_said(319.0, 60.0)  # ahead, not behind
    assert is_said(325.0, 60.0, sim_time=False)  # other advice
    assert not is_said(331.0, 0.0) and is_said(337.0, 60.0, sim_time=False)  # it was gone


@pytest.mark.parametrize(("topic", "values", "missing", "needed"), [
    (TOP_DRIVE, (math.nan, 2.0), "position nan", "give a position, rad"),
    (TOP_DRIVE, (math.nan, math.nan), "position nan", "a velocity alone is no command"),
    (BLOCK, (3.0, math.nan), "velocity nan", "give a velocity, m/s"),
    (PUMP, (3.0, math.nan), "velocity nan", "give a velocity, rad/s"),
])  # fmt: skip
def test_refusal_of_an_incomplete_command_says_what_is_missing(topic, values, missing, needed):
    reason = at(1.0).put(topic, SECOND, *values).reason
    assert reason.startswith(f"{missing} is missing") and needed in reason


LIMITS = CommandLimits(top_drive_speed=126.0, block_speed=2.0, pump_speed=24.6)


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


def test_foreign_clocks_are_recognised():
    inbox = at(1e8)
    assert "this machine's uptime" in inbox.put(TOP_DRIVE, time.monotonic_ns(), 0.0, 0.0).reason
    assert "another clock" in inbox.put(TOP_DRIVE, round(2e8) * SECOND, 0.0, 0.0).reason
    assert "too late" in inbox.put(TOP_DRIVE, round(1e8 - 1.5) * SECOND, 0.0, 0.0).reason


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


def test_sample_is_resent_only_to_late_joiners():
    there, now = {b"first"}, [0.0]
    newcomers = LateJoiners(lambda: set(there), lambda: now[0])
    newcomers.start(6)
    assert not newcomers.should_resend(7)
    there.add(b"second")
    assert newcomers.should_resend(7)
    assert not newcomers.should_resend(7)
    now[0] += RESEND_PERIOD
    assert newcomers.should_resend(7)
    assert not newcomers.should_resend(8), "the sample was answered: the newcomer has heard it"


def test_first_sample_is_resent_without_answer():
    now = [0.0]
    newcomers = LateJoiners(lambda: {b"first"}, lambda: now[0])
    newcomers.start(0)
    now[0] += FIRST_RESEND_AFTER - 0.1
    assert not newcomers.should_resend(0)
    now[0] += 0.2
    assert newcomers.should_resend(0) and not newcomers.should_resend(0)
    assert not newcomers.should_resend(1)


def test_own_echoes_are_matched_by_bytes():
    echoes = OwnEchoes()
    assert not echoes.is_own(b"a")
    for data in (b"a", b"b", b"c"):
        echoes.add(data)
    assert echoes.is_own(b"b"), "what came before it is lost"
    assert not echoes.is_own(b"a") and not echoes.is_own(b"b")
    assert echoes.is_own(b"c") and not echoes.is_own(b"c")


def test_watchdog_ignores_slow_motion():
    now = [100.0]
    silence = Watchdog(lambda: now[0])
    assert silence.silent_for(1.0) == 0.0
    silence.note_sample()
    now[0] += 1.5
    assert silence.silent_for(1.0) == 1.5
    now[0] += 8.5
    silence.note_sample()
    now[0] += 25.0
    assert silence.silent_for(1.0) == 0.0, "a sample every ten seconds is slow motion"
    now[0] += 6.0
    assert silence.silent_for(1.0) == 31.0


def test_watchdog_forgives_own_stop():
    now = [100.0]
    silence = Watchdog(lambda: now[0])
    silence.note_sample()
    assert not silence.tick()
    now[0] += 1.5  # SIGSTOP
    assert silence.tick() and silence.silent_for(1.0) == 0.0
    for _ in range(30):
        now[0] += 0.02
        waiting = silence.tick()
    assert not waiting
    for _ in range(30):
        now[0] += 0.02
        silence.tick()
    assert silence.silent_for(1.0) == pytest.approx(1.2)


def test_watchdog_restarts_with_listening():
    now = [100.0]
    silence = Watchdog(lambda: now[0])
    silence.note_sample()
    now[0] += 50.0
    silence.restart()
    assert silence.silent_for(1.0) == 0.0


@pytest.mark.parametrize(
    ("speed", "held"), [(0.0, 5.0), (4.0, 5.4), (-4.0, 4.6), (math.nan, 7.0)], ids=["still", "right", "left", "lost"]
)
def test_safe_stop_holds_where_drive_comes_to_rest(speed, held):
    command = safe_stop(RigCommand(7.0, 4.0, 0.01, 12.0), 5.0, speed, 20.0)
    assert command == RigCommand(pytest.approx(held), 0.0, 0.0, 12.0)


DAY = 86_400 * SECOND


@pytest.mark.parametrize(
    ("stamp", "now", "simulated", "says"),
    [
        (5 * DAY, 5 * DAY + SECOND, False, ""),
        (5 * DAY, 6 * DAY, False, "86400 s behind this node's clock: synchronise the clocks"),
        (7 * DAY, 6 * DAY, False, "86400 s ahead of this node's clock: synchronise the clocks"),
        (5 * DAY, 0, True, "no /clock comes; set use_sim_time to false"),
        (5 * DAY, 4 * DAY, True, "/clock belongs to another rig"),
    ],
)
def test_stamps_of_another_clock_are_named(stamp, now, simulated, says):
    message = clock_offset_message(stamp, now, simulated)
    assert says in message and bool(message) == bool(says)


def test_pace_measures_lag():
    pace = Pace(speed=4.0, simulated=10.0, wall=100.0)
    assert pace.due(12.0) == 100.5
    pace.note_sent(12.0, 100.75)
    pace.note_sent(14.0, 101.0)
    assert (pace.lag, pace.take_worst_lag(), pace.take_worst_lag()) == (0.0, 0.25, 0.0)
    pace.restart(14.0, 103.0)
    assert pace.due(18.0) == 104.0
