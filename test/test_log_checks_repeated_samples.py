"""Columns that are held between two renewals, and columns that nobody filled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from slider_drilling.diagnosis.replay import replay
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import RigLog
from slider_drilling.log.series import JointSeries, ScalarSeries
from slider_drilling.log_checks.position_and_speed import check_position_and_speed
from slider_drilling.log_checks.repeated_samples import mask_repeated_samples
from slider_drilling.log_inputs.commands_from_log import commands_from_log, unfilled_field
from slider_drilling.rig import load_rig

RIG = load_rig(installed_file("config/rig.example.yaml"))
TIME = 0.1 * np.arange(900)


def log_of(held=1):
    """A rocked drive whose columns, but its speed, are renewed with every so many samples."""
    noise = np.random.default_rng(3)
    turn = np.abs(TIME % 16.0 - 8.0)
    speed = np.where(TIME % 16.0 < 8.0, -1.0, 1.0)
    torque, pressure = 1e3 * turn + 100.0 * noise.normal(size=900), 2e7 + 4e4 * noise.normal(size=900)
    at, nothing = (np.arange(900) // held) * held, np.full(900, np.nan)
    drive = JointSeries(TIME, TIME, turn[at], speed, torque[at])
    return RigLog("run.mcap", 0, top_drive=drive, standpipe_pressure=ScalarSeries(TIME, TIME, pressure[at], nothing))


def test_columns_renewed_with_every_sample_stay():
    log = log_of()
    assert mask_repeated_samples(log) == (log, [])


@pytest.mark.parametrize("held", [2, 5, 10])
def test_repeated_samples_are_masked_and_noted(held):
    log = log_of(held)
    found, notes = mask_repeated_samples(log)
    for values in (found.top_drive.effort, found.top_drive.position, found.standpipe_pressure.value):
        assert np.flatnonzero(np.isfinite(values)).tolist() == list(range(0, 900, held))
    words = "top-drive angle, top-drive speed, surface_torque, standpipe_pressure"
    assert [str(note.text).split(":")[0] for note in notes] == [words]
    assert f"renewed every {0.1 * held:.3g} s" in str(notes[0].text) and notes[0].severity == "note"


def test_resting_rig_is_sampled_as_often():
    log = log_of(5)
    drive = log.top_drive
    rests = np.where((TIME > 20.0) & (TIME < 50.0), drive.position[200], drive.position)
    found, _ = mask_repeated_samples(replace(log, top_drive=replace(drive, position=rests)))
    known = TIME[np.isfinite(found.top_drive.position)]
    assert np.max(np.diff(known)) == pytest.approx(0.5)


def test_coarse_values_are_not_masked():
    """A resolution repeats values too, but a fast change takes one sample."""
    log = log_of()
    coarse = replace(log.top_drive, effort=500.0 * np.round(log.top_drive.effort / 500.0))
    assert mask_repeated_samples(replace(log, top_drive=coarse))[1] == []


def test_renewals_at_another_rate_are_found():
    """Three renewals a second in a log of ten samples a second: three or four samples each."""
    log = log_of()
    at = (np.floor(TIME * 3.0) / 3.0 / 0.1).astype(int)
    pressure = replace(log.standpipe_pressure, value=log.standpipe_pressure.value[at])
    found, notes = mask_repeated_samples(replace(log, standpipe_pressure=pressure))
    assert np.isfinite(found.standpipe_pressure.value).sum() == pytest.approx(270, abs=40) and len(notes) == 1


@pytest.mark.parametrize("column", ["velocity", "position"])
def test_all_zero_column_is_computed_and_noted(column):
    log = log_of()
    drive = replace(log.top_drive, **{column: np.zeros(900)})
    assert unfilled_field(log.top_drive) is None and unfilled_field(drive) == column
    own, given = (commands_from_log(replace(log, top_drive=one), RIG).commands for one in (log.top_drive, drive))
    assert own.top_drive_speed[100:150] == pytest.approx(given.top_drive_speed[100:150], abs=0.3)
    assert np.ptp(own.top_drive_angle) == pytest.approx(np.ptp(given.top_drive_angle), rel=0.05)
    (note,) = check_position_and_speed(replace(log, top_drive=drive), RIG)
    assert note.severity == "note" and "is zero throughout" in str(note.text)


def test_zero_speed_at_rest_counts_as_filled():
    assert unfilled_field(JointSeries(TIME, TIME, np.full(900, 3.0), np.zeros(900), np.zeros(900))) is None


def test_slow_coarse_sensor_is_not_masked():
    """A block position in centimetres, lowered at one rate after the other: steps of one size, at uneven times."""
    log = log_of()
    rate = np.where(TIME < 40.0, 0.02, 0.035)
    position = np.cumsum(0.1 * rate)
    noise = np.random.default_rng(5)
    works = JointSeries(TIME, TIME, 0.01 * np.round(position / 0.01), rate, 1e6 + 3e3 * noise.normal(size=900))
    assert mask_repeated_samples(replace(log, draw_works=works))[1] == []


@pytest.mark.parametrize("held", [2, 10])
def test_missing_renewal_shifts_no_other(held):
    """One sample in a hundred is lost, and a stretch: what is kept was measured when it is stamped."""
    log, fresh = log_of(held), log_of()
    came = np.random.default_rng(6).uniform(size=900) > 0.01
    came[300:313] = False
    drive = log.top_drive
    lost = JointSeries(*(getattr(drive, name)[came] for name in ("time", "arrival", "position", "velocity", "effort")))
    found, notes = mask_repeated_samples(replace(log, top_drive=lost))
    kept = np.isfinite(found.top_drive.effort)
    measured = np.interp(found.top_drive.time[kept], TIME, fresh.top_drive.effort)
    assert np.array_equal(found.top_drive.effort[kept], measured)
    assert kept.sum() > 0.95 * 900 / held and "surface_torque" in str(notes[0].text)


def test_constant_pump_is_renewed_with_other_messages():
    log = log_of(5)
    nothing = np.full(900, np.nan)
    speed = np.where(np.arange(900) < 455, 12.0, 11.0)
    found, notes = mask_repeated_samples(replace(log, mud_pump=JointSeries(TIME, TIME, nothing, speed, nothing)))
    assert np.flatnonzero(np.isfinite(found.mud_pump.velocity)).tolist() == list(range(0, 900, 5))
    assert "pump speed" in str(notes[0].text)
    elsewhere = np.where(np.arange(900) < 457, 12.0, 11.0)
    found, _ = mask_repeated_samples(replace(log, mud_pump=JointSeries(TIME, TIME, nothing, elsewhere, nothing)))
    assert np.isfinite(found.mud_pump.velocity).all()


def test_replay_masks_repeated_samples_and_says_so():
    run = replay(log_of(5), RIG, elements=32)
    assert any("renewed every 0.5 s" in sentence for sentence in run.assumptions)
    assert run.channels["surface_torque"].channel.time.size == 180


@pytest.mark.parametrize("rate", [0.0004, 0.0014, 0.0025, 0.02])
@pytest.mark.parametrize(("step", "speed_step"), [(0.001, 0.0), (0.01, 0.0), (0.001, 0.001), (0.0, 0.001)])
def test_coarse_block_position_is_accepted_as_metres(rate, step, speed_step):
    """Its position steps seldom, and from one sample to the next much faster than it moves."""
    time = 0.1 * np.arange(2000)
    rates = rate * (1.0 + 0.3 * (time > 80.0))
    position = np.cumsum(0.1 * rates)
    rounded = step * np.round(position / step) if step else position
    speed = speed_step * np.round(rates / speed_step) if speed_step else rates
    nothing = np.full(time.size, np.nan)
    works = JointSeries(time, time, rounded, speed, nothing)
    drive = JointSeries(time, time, 2.0 * time, np.full(time.size, 2.0), nothing)
    log = RigLog("run.mcap", 0, top_drive=drive, draw_works=works)
    assert [one for one in check_position_and_speed(log, RIG) if one.severity == "unusable"] == []
    if step < 0.01 and not speed_step and rate > 0.001:
        feet = replace(log, draw_works=replace(works, position=rounded / 0.3048))
        (refused,) = check_position_and_speed(feet, RIG)
        assert refused.severity == "unusable" and "looks like ft" in str(refused.text)
