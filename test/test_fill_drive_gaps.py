"""What drives a simulation where the log lost the top drive's samples."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slider_drilling.benchmarks.log_defects import with_defect
from slider_drilling.drillstring import Commands
from slider_drilling.drillstring.sample_gaps import times_in_gaps
from slider_drilling.log import RigLog
from slider_drilling.log.series import JointSeries, ScalarSeries
from slider_drilling.log_checks.unknown_flow import mask_pressure_of_unknown_flow
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.log_inputs.fill_drive_gaps import fill_drive_gaps
from slider_drilling.log_inputs.fill_pump_gaps import fill_pump_gaps, hidden_flow_changes
from slider_drilling.rig import load_rig

NAN = np.nan


def rocking(time, rate=4.0, quarter=5.0, ramp=0.4):
    """Angle and speed of a drive that rocks at an even rate and turns round in ``ramp`` s."""
    fine = np.arange(0.0, time[-1] + 0.01, 1e-3)
    speed = np.clip(rate * 2.0 / ramp * quarter * 0.5 * np.sin(np.pi * fine / (2.0 * quarter)), -rate, rate)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * 1e-3)])
    return np.interp(time, fine, angle), np.interp(time, fine, speed)


def without(series, begin, end):
    keep = ~((series.time > begin) & (series.time < end))
    return replace(series, **{name: getattr(series, name)[keep] for name in series.__dataclass_fields__})


@pytest.fixture
def rig(repository):
    return load_rig(repository / "config" / "rig.example.yaml")


@pytest.fixture
def log():
    time = np.arange(0.0, 60.0, 0.1)
    angle, speed = rocking(time)
    nothing = np.full_like(time, NAN)
    pump = np.where(time < 30.0, 10.0, 9.3)
    return RigLog(
        source="a log", start_ns=0, rig_text="", rig_source="", metadata={}, notes=(),
        top_drive=JointSeries(time, time, angle, speed, np.zeros_like(time)), top_drive_command=None,
        draw_works=None, draw_works_command=None,
        standpipe_pressure=ScalarSeries(time, time, 2e7 * (pump / 10.0) ** 2, nothing),
        mud_pump=JointSeries(time, time, nothing, pump, nothing), mwd_tool_face=None, tool_face_target=None,
        bit_depth=None, truth_bit=None, truth_depth=None, truth_weight_on_bit=None,
    )  # fmt: skip


@pytest.mark.parametrize(("begin", "end"), [(9.2, 10.9), (9.6, 10.7), (9.0, 10.1), (19.5, 20.6)])
def test_missing_reversal_reaches_its_peak(log, begin, end):
    """A cubic through both ends cuts off up to half of it; the whole turn lies between two samples."""
    kept = without(log.top_drive, begin, end)
    here = (log.top_drive.time > begin) & (log.top_drive.time < end)
    true = log.top_drive.position[here]

    def worst(time, angle, speed):
        still = np.zeros_like(time)
        found = Commands(time, angle, speed, still, still, still).resampled(log.top_drive.time[here])
        return np.max(np.abs(found.top_drive_angle - true))

    plain = (kept.time, kept.position, kept.velocity)
    assert worst(*fill_drive_gaps(*plain, 20.0)) < 0.1
    assert worst(*plain) > 4.0 * worst(*fill_drive_gaps(*plain, 20.0))


@pytest.mark.parametrize("by_time", [True, False])
@pytest.mark.parametrize("lost_turn", [4.5, 11.5, 15.5, 22.5])
def test_missing_speed_change_has_usual_duration(by_time, lost_turn):
    """Of a drive that needs the same time for every change, and of one that needs the same for every rad/s."""
    time = np.arange(0.0, 40.0, 0.1)
    turns = ((1.0, 3.0), (4.5, -3.0), (8.0, 0.0), (9.5, 1.2), (11.5, -1.2), (13.5, 0.0), (14.0, 3.0), (15.5, -3.0),
             (18.0, 0.0), (20.5, 1.2), (22.5, -1.2), (24.5, 0.0))  # fmt: skip
    speed, now = np.zeros_like(time), 0.0
    for at, then in turns:
        ramp = 0.8 if by_time else abs(then - now) / 6.0
        speed += (then - now) * np.clip((time - at) / ramp + 0.5, 0.0, 1.0)
        now = then
    angle = np.concatenate([[0.0], np.cumsum(0.05 * (speed[1:] + speed[:-1]))])
    come = np.abs(time - lost_turn) > 0.65
    found = fill_drive_gaps(time[come], angle[come], speed[come], 20.0)
    still = np.zeros_like(found[0])
    driven = Commands(*found, still, still, still).resampled(time).top_drive_angle
    assert driven == pytest.approx(angle, abs=0.03)


def test_complete_motion_is_unchanged(log):
    drive = log.top_drive
    found = fill_drive_gaps(drive.time, drive.position, drive.velocity, 20.0)
    assert all(np.array_equal(a, b) for a, b in zip(found, (drive.time, drive.position, drive.velocity), strict=True))


def test_unexplained_motion_keeps_the_cubic():
    time = np.r_[np.arange(0.0, 5.0, 0.1), np.arange(7.0, 12.0, 0.1)]
    speed = np.where(time < 6.0, 1.0, 2.0)
    angle = np.where(time < 6.0, time, 4.9 + 2.0 * (time - 7.0) - 3.0)  # it went back meanwhile
    found = fill_drive_gaps(time, angle, speed, 20.0)
    assert found[0].size == time.size


@given(
    first=st.floats(-8.0, 8.0), second=st.floats(-8.0, 8.0), share=st.floats(0.0, 1.0), length=st.floats(0.5, 5.0),
    ramp=st.floats(0.01, 1.0),
)  # fmt: skip
def test_corners_lie_inside_the_gap(first, second, share, length, ramp):
    before, after = np.arange(0.0, 2.0, 0.1), np.arange(0.0, 2.0, 0.1)
    end = before[-1] + length
    turned = first * share * length + second * (1.0 - share) * length
    time = np.r_[before, end + after]
    start = before[-1] * first
    angle = np.r_[before * first, start + turned + second * after]
    speed = np.r_[np.full(20, first), np.full(20, second)]
    speed[0] = first - ramp
    moved = fill_drive_gaps(time, angle, speed, 20.0)
    assert np.all(np.diff(moved[0]) > 0.0)
    assert np.isin(time, moved[0]).all()
    inside = (moved[0] > before[-1]) & (moved[0] < end)
    assert np.all(moved[2][inside] <= max(first, second) + 1e-9)
    assert np.all(moved[2][inside] >= min(first, second) - 1e-9)
    # Trapezoids between all corners: speeds that are joined evenly give the angle that was turned.
    part = slice(19, 20 + int(inside.sum()) + 1)
    whole = np.sum(0.5 * (moved[2][part][1:] + moved[2][part][:-1]) * np.diff(moved[0][part]))
    if inside.sum() == 2:
        assert whole == pytest.approx(turned, abs=2e-3)


def test_pump_samples_survive_drive_gaps(log, rig):
    """The commands' times are the drive's: a step of the pump between two of them would become a ramp."""
    holed = replace(log, top_drive=without(log.top_drive, 29.05, 30.75))
    commands = commands_from_log(holed, rig).commands
    assert np.interp(29.8, commands.time, commands.pump_speed) == pytest.approx(10.0)
    assert np.interp(30.1, commands.time, commands.pump_speed) == pytest.approx(9.3)


def test_times_in_gaps():
    time = np.array([0.0, 0.1, 0.2, 1.2, 1.3])
    assert times_in_gaps(time, np.array([0.15, 0.2, 0.5, 1.0, 1.2, 1.25])).tolist() == [0.5, 1.0]


def test_pressure_of_unknown_flow_is_masked(log):
    holed = replace(log, mud_pump=without(log.mud_pump, 29.15, 30.55))
    found, notes = mask_pressure_of_unknown_flow(holed)
    gone = np.isnan(found.standpipe_pressure.value)
    assert log.standpipe_pressure.time[gone] == pytest.approx(np.arange(29.2, 30.55, 0.1))
    assert [(note.severity, note.channel) for note in notes] == [("note", "standpipe_pressure")]
    assert "14 samples, the first at 29.2 s" in notes[0].text


@pytest.mark.parametrize("lag", [0.01, 0.4, 2.0])
@pytest.mark.parametrize("moment", [29.3, 29.9, 30.4])
@pytest.mark.parametrize("flows", [(10.0, 9.3), (9.3, 10.0)])
def test_pressure_shows_when_flow_changed(lag, moment, flows):
    time = np.arange(0.0, 60.0, 0.1)
    pump = np.where(time < moment, *flows)
    level = 2e7 * (np.array(flows) / 10.0) ** 2
    share = -np.expm1(-np.maximum(time - moment, 0.0) / lag)
    noise = np.random.default_rng(3).normal(0.0, 4e4, time.size)
    pressure = level[0] + (level[1] - level[0]) * share + noise
    came = ~((time > 29.15) & (time < 30.55))
    found, speed = fill_pump_gaps(time[came], pump[came], time, pressure)
    fine = np.arange(29.0, 31.0, 0.01)
    off = np.interp(fine, found, speed) - np.where(fine < moment, *flows)
    assert abs(float(np.sum(off)) * 0.01) < 0.12 * abs(flows[1] - flows[0])
    before = found.size - 2
    assert np.count_nonzero(came) == before and np.all(np.diff(found) > 0.0)


def test_flow_without_visible_change_stays_linear(log):
    pump = without(log.mud_pump, 29.15, 30.55)
    flat, gone = np.full(600, 2e7), np.full(600, NAN)
    against = log.standpipe_pressure.value[::-1]
    for pressure in (flat, gone, against):
        found = fill_pump_gaps(pump.time, pump.velocity, log.standpipe_pressure.time, pressure)
        assert np.array_equal(found, (pump.time, pump.velocity))


def test_commands_and_diagnosis_follow_the_pressure(log, rig):
    holed = replace(log, mud_pump=without(log.mud_pump, 28.95, 30.35))
    masked, _ = mask_pressure_of_unknown_flow(holed)
    assert np.all(np.diff(masked.mud_pump.time) > 0.0)
    for one in (holed, masked):
        pump = commands_from_log(one, rig).commands.pump_speed
        assert pump[log.top_drive.time < 29.85] == pytest.approx(10.0)
        assert pump[log.top_drive.time > 30.05] == pytest.approx(9.3)


def test_pressure_of_constant_flow_is_kept(log):
    holed = replace(log, mud_pump=without(log.mud_pump, 40.15, 41.55))
    assert mask_pressure_of_unknown_flow(holed) == (holed, [])


@pytest.mark.parametrize("limit", [20.0, 90.0])
@pytest.mark.parametrize("every", [10, 20])
def test_undersampled_drive_reverses_between_samples(log, rig, every, limit):
    """At one sample a second a cubic turns round half a radian early; the drive reverses in 0.4 s, as a sample that
    met it on its way shows, whatever the drive could do.
    """
    few = with_defect(f"samples={every}", log)
    rig = replace(rig, top_drive=replace(rig.top_drive, max_acceleration=limit))
    commands = commands_from_log(few, rig).commands
    assert np.diff(commands.time) == pytest.approx(0.1, abs=1e-6)
    whole = log.top_drive.time <= few.top_drive.time[-1]
    true = log.top_drive.position[whole]
    plain = few.top_drive
    still = np.zeros_like(plain.time)
    cubic = Commands(plain.time, plain.position, plain.velocity, still, still, still).resampled(
        log.top_drive.time[whole]
    )
    off = np.abs(np.interp(log.top_drive.time[whole], commands.time, commands.top_drive_angle) - true)
    assert off.max() < 0.03
    assert off.max() < 0.5 * np.abs(cubic.top_drive_angle - true).max()


def test_smooth_drive_keeps_the_cubic(rig):
    time = np.arange(0.0, 120.0, 1.0)
    angle, speed = 30.0 * np.sin(0.1 * time), 3.0 * np.cos(0.1 * time)
    found = fill_drive_gaps(time, angle, speed, 20.0)
    still = np.zeros_like(found[0])
    fine = np.arange(5.0, 110.0, 0.1)
    moved = Commands(*found, still, still, still).resampled(fine).top_drive_angle
    assert moved == pytest.approx(30.0 * np.sin(0.1 * fine), abs=0.02)


def test_undersampled_speed_only_drive_is_followed(log, rig):
    few = with_defect("samples=10", log)
    nothing = np.full_like(few.top_drive.time, NAN)
    commands = commands_from_log(replace(few, top_drive=replace(few.top_drive, position=nothing)), rig).commands
    assert np.interp(few.top_drive.time, commands.time, commands.top_drive_speed) == pytest.approx(
        few.top_drive.velocity
    )


def test_pressure_times_changes_of_undersampled_pump(log, rig):
    changed = 30.37
    share = -np.expm1(-np.maximum(log.standpipe_pressure.time - changed, 0.0) / 1.5)
    pump = replace(log.mud_pump, velocity=np.where(log.mud_pump.time < changed, 10.0, 9.3))
    pressed = replace(log.standpipe_pressure, value=2e7 * (1.0 - 0.14 * share))
    few = with_defect("samples=10", replace(log, mud_pump=pump, standpipe_pressure=pressed))
    commands = commands_from_log(few, rig).commands
    after = (commands.time > 30.0) & (commands.time < 31.05)
    mean = float(np.mean(commands.pump_speed[after]))
    assert mean == pytest.approx(10.0 - 0.7 * (31.0 - changed), abs=0.07)
    assert commands.pump_speed[commands.time < 30.25] == pytest.approx(10.0)
    assert commands.pump_speed[commands.time > 30.55] == pytest.approx(9.3)


def test_pump_jitter_is_no_flow_change(log):
    jitter = np.random.default_rng(5).normal(0.0, 0.05, log.mud_pump.time.size)
    pump = replace(log.mud_pump, velocity=log.mud_pump.velocity + jitter)
    few = with_defect("samples=10", replace(log, mud_pump=pump)).mud_pump
    assert few.time[hidden_flow_changes(few.time, few.velocity)].tolist() == [29.0]
    holed = without(pump, 40.15, 41.55)
    assert hidden_flow_changes(holed.time, holed.velocity).size == 0
