"""Messages that come late, twice, out of order, stale or invalid. Runs without ROS."""

import math

import pytest

from slider_drilling.control.interface import RigCommand
from slider_drilling.nodes.clock_check import ClockFaultReports, clock_offset_message
from slider_drilling.nodes.late_joiners import FIRST_RESEND_AFTER, RESEND_PERIOD, LateJoiners
from slider_drilling.nodes.own_echoes import OwnEchoes
from slider_drilling.nodes.pace import Pace
from slider_drilling.nodes.safe_stop import safe_stop
from slider_drilling.nodes.sample_inbox import JointReading, SampleInbox
from slider_drilling.nodes.watchdog import Watchdog

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
