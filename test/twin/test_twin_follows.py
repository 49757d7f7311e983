from dataclasses import fields, replace

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.rig import load_rig
from slider_drilling.twin import Twin


def _feed(twin, log, until):
    for second in np.arange(0.0, until, 1.0):
        for name, series, array in (
            ("top_drive_angle", log.top_drive, "position"), ("top_drive_speed", log.top_drive, "velocity"),
            ("surface_torque", log.top_drive, "effort"), ("block_position", log.draw_works, "position"),
            ("block_speed", log.draw_works, "velocity"), ("hook_load", log.draw_works, "effort"),
            ("standpipe_pressure", log.standpipe_pressure, "value"), ("pump_speed", log.mud_pump, "velocity"),
        ):  # fmt: skip
            if series is None:
                continue
            rows = (series.time >= second) & (series.time < second + 1.0)
            twin.add(name, series.time[rows], getattr(series, array)[rows])
        yield from twin.advance()


def test_twin_of_nominal_rig_follows_it(shared_data):
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    twin = Twin(log.rig())
    report = [*_feed(twin, log, 100.0)][-1]
    assert report.channels["surface_torque"].gap_60 < 0.5
    assert report.channels["standpipe_pressure"].gap_60 < 0.5


def test_unknown_channel_is_refused(repository):
    twin = Twin(load_rig(repository / "config" / "rig.short.yaml"))
    with pytest.raises(InputError, match="twin: torque: no such channel"):
        twin.add("torque", 0.0, 1.0)


@pytest.mark.parametrize(("times", "values"), [([0.0, 1.0], [1.0]), (0.0, [1.0, 2.0]), ([[0.0]], [[1.0]])])
def test_other_numbers_of_times_and_values_are_refused(repository, times, values):
    twin = Twin(load_rig(repository / "config" / "rig.short.yaml"))
    with pytest.raises(InputError, match=r"twin: hook_load: times of shape .*; give as many values as times"):
        twin.add("hook_load", times, values)


def test_rig_without_block_follows_the_pressure(shared_data):
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    twin, whole = Twin(log.rig()), Twin(log.rig())
    for _ in zip(_feed(twin, replace(log, draw_works=None), 100.0), _feed(whole, log, 100.0), strict=False):
        pass
    weight = whole._learner.follower.weight_on_bit
    assert weight > 1e4
    assert twin._learner.follower.weight_on_bit == pytest.approx(weight, rel=0.3)
    assert "the block is not sent" in twin.remarks[0]


def _from(series, begin):
    """A series without what comes before a time, s."""
    kept = series.time >= begin
    return replace(series, **{field.name: getattr(series, field.name)[kept] for field in fields(series)})


@pytest.mark.parametrize("late", [("draw_works",), ("draw_works", "standpipe_pressure"), ("standpipe_pressure",)])
def test_channel_that_comes_later_is_taken(shared_data, late):
    """Topics of a graph, and items of WITS, do not come up at once."""
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    twin = Twin(log.rig())
    begun = replace(log, **{name: _from(getattr(log, name), 10.0) for name in late})
    channels = list(_feed(twin, begun, 60.0))[-1].channels
    assert channels["surface_torque"].gap_10 < 1.0 and channels["hook_load"].gap_10 < 1.0
    assert channels["standpipe_pressure"].gap_10 < 1.0
    assert [("block comes only now" in each) for each in twin.remarks[-1:]] == (
        [True] if "draw_works" in late else []
    )


def test_remarks_outlast_learning_anew(shared_data):
    """They are said by their place."""
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    twin = Twin(log.rig())
    for report in _feed(twin, replace(log, draw_works=None), 70.0):
        if round(report.time) == 65:
            before = twin.remarks
            twin.recalibrate()
    assert before and twin.remarks == before


def test_torque_alone_is_compared_off_bottom(shared_data):
    log = read_log(shared_data / "field" / "well_c_2506m.mcap", next((shared_data / "field").glob("*.yaml"), None))
    twin = Twin(log.rig())
    reports = list(_feed(twin, log, 60.0))
    assert set(reports[-1].channels) == {"surface_torque"}
    assert "bit is taken to be off bottom" in twin.remarks[0]
    assert np.isfinite(reports[-1].channels["surface_torque"].gap_10)


def test_late_and_shuffled_samples_change_nothing(shared_data):
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    gaps = []
    for shuffled in (False, True):
        twin, random = Twin(log.rig()), np.random.default_rng(0)
        for begin in np.arange(0.0, 40.0, 1.0):
            rows = np.flatnonzero((log.top_drive.time >= begin) & (log.top_drive.time < begin + 1.0))
            works = np.flatnonzero((log.draw_works.time >= begin) & (log.draw_works.time < begin + 1.0))
            if shuffled:
                random.shuffle(rows)
            drive, block = log.top_drive, log.draw_works
            twin.add("top_drive_angle", drive.time[rows], drive.position[rows])
            twin.add("top_drive_speed", drive.time[rows], drive.velocity[rows])
            twin.add("surface_torque", drive.time[rows], drive.effort[rows])
            twin.add("block_position", block.time[works], block.position[works])
            twin.advance()
        twin.finish()
        gaps.append(twin.report.channels["surface_torque"].gap_10)
    assert gaps[0] == gaps[1]


def test_lost_samples_are_said(shared_data):
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    drive = log.top_drive
    kept = (drive.time < 30.0) | (drive.time > 45.0)
    lost = replace(drive, **{name: getattr(drive, name)[kept] for name in
                             ("time", "arrival", "position", "velocity", "effort")})  # fmt: skip
    notes = {round(report.time): report.note for report in _feed(Twin(log.rig()), replace(log, top_drive=lost), 60.0)}
    assert notes[40] == "samples of the top drive are missing"
    assert notes[55] == "samples of the top drive are missing"


def test_impossible_readings_are_left_out(repository):
    twin = Twin(load_rig(repository / "config" / "rig.short.yaml"))
    twin.add("standpipe_pressure", [0.0, 1.0, 2.0], [1.8e7, -9.99e9, 1.9e7])
    assert twin._buffers["standpipe_pressure"].value.tolist() == [1.8e7, 1.9e7]
