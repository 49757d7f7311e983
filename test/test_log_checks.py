"""Log checks: unusable logs are refused, glitches masked, and every valid log passes unchanged."""

from __future__ import annotations

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from fork_server import run_cli
from made_log import changed, error_of, recorded, rocking, rows_of
from short_well import short_rig

from slider_drilling.diagnosis.diagnose import diagnose
from slider_drilling.diagnosis.page import report_page
from slider_drilling.diagnosis.replay import measured_channels
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import RigLog, read_log
from slider_drilling.log.find_nulls import find_nulls, mask_shared_nulls
from slider_drilling.log.import_record import ImportRecord, IntegratedQuantity
from slider_drilling.log.series import JointSeries
from slider_drilling.log_checks import LogChecks, check_log, check_without_rig
from slider_drilling.log_checks.block_weight import check_block_weight
from slider_drilling.log_checks.glitches import find_glitches
from slider_drilling.log_inputs.commands_from_log import commands_from_log
from slider_drilling.pages import page_html
from slider_drilling.rig import Rig
from slider_drilling.units import KINDS, SI
from slider_drilling.wellbore.static_loads import static_loads


@pytest.fixture(scope="module")
def rig() -> Rig:
    return short_rig()


@pytest.fixture(scope="module")
def log(rig) -> RigLog:
    return recorded(rig, rocking())


def test_sound_log_passes_unchanged(log, rig):
    assert check_log(log, rig) == LogChecks(log, ())


def test_table_of_checks_of_a_sound_log(log, rig):
    rows = rows_of(check_log(log, rig))
    assert {result for result, _ in rows.values()} == {"ok", "not checked"}
    assert rows["rate"][1].endswith("10 samples a second") and rows["block weight"][0] == "not checked"
    alone = rows_of(check_without_rig(log))
    assert alone["units and levels"][0] == "not checked" and alone["gaps"][0] == "ok"


@pytest.mark.parametrize(("null", "unit"), [(-999.25, "klbf"), (-9999.0, "kN"), (-999.0, "N"), (65535.0, "kN")])
def test_nulls_in_a_recorded_log_are_masked(log, rig, null, unit):
    def filled(load):
        load[[50, 300, 301]] = null * KINDS["force"][unit]
        return load

    checked = check_log(changed(log, "draw_works", effort=filled), rig)
    assert np.flatnonzero(np.isnan(checked.log.draw_works.effort)).tolist() == [50, 300, 301]
    assert rows_of(checked)["nulls"] == (
        "noted", f"hook load: 3 of 800 samples are {null:g} {unit}, the first at 5.0 s: taken as no value"
    )  # fmt: skip


@pytest.mark.parametrize(("array", "unit"), [("effort", "N m"), ("effort", "ft lbf"), ("position", "deg")])
def test_a_null_of_one_channel_is_a_null_of_the_others(log, rig, array, unit):
    """It stands among the readings of the other channel, where only the first one shows what it is."""
    null = -999.25 * next(units[unit] for units in KINDS.values() if unit in units)

    def filled(values, number=null):
        values[[50, 300]] = number
        return values

    alone = changed(log, "top_drive", **{array: filled})
    assert not find_nulls(alone)
    both = changed(alone, "draw_works", effort=lambda load: filled(load, -999.25e3))
    masked = mask_shared_nulls(both)
    assert np.flatnonzero(np.isnan(getattr(masked.top_drive, array))).tolist() == [50, 300]
    label = {"effort": "surface torque", "position": "top drive angle"}[array]
    assert masked.notes == (
        f"{label}: 2 of 800 samples are -999.25 {unit}, a null as in hook load, the first at 5.0 s: left out",
    )
    assert f"2 of 800 samples are -999.25 {unit}, a null as in hook load" in rows_of(check_log(both, rig))["nulls"][1]


def test_lost_signs_are_unusable(log, rig):
    both = changed(log, "top_drive", velocity=np.abs, effort=np.abs)
    assert "speed and surface torque never turns negative while it rocks" in error_of(both, rig)
    assert "speed never turns negative" in error_of(changed(log, "top_drive", velocity=np.abs), rig)
    assert "surface torque never turns negative" in error_of(changed(log, "top_drive", effort=np.abs), rig)


def test_weight_of_the_block_is_noted(rig):
    time = np.arange(0.0, 60.0, 0.1)
    still = np.zeros_like(time)
    weight = static_loads(rig, elements=100).hook_load

    def turning(load):
        drive = JointSeries(time, time, 4.0 * time, 4.0 + still, 8e3 + still)
        return RigLog("t.mcap", 0, top_drive=drive, draw_works=JointSeries(time, time, still, still, load + still))

    (note,), _ = check_block_weight(turning(weight + 276e3), rig)
    assert note.severity == "note" and "the 276 kN above it look like the block" in str(note.text)
    assert check_block_weight(turning(1.05 * weight), rig) == ([], True)


@pytest.mark.parametrize(
    ("integrated", "severity", "said"),
    [
        (IntegratedQuantity(0.2), "note", "may be off by 0.20 rad"),
        (IntegratedQuantity(7.0), "uninformative", "may be off by 7.0 rad: too far to compare"),
        (IntegratedQuantity(0.2, 2, 3600.0), "uninformative", "which has 2 gaps of 3600 s"),
    ],
)
def test_integrated_angle_carries_its_error(log, rig, integrated, severity, said):
    imported = replace(log, imported=ImportRecord(integrated={"top_drive_angle": integrated}))
    (text,) = check_log(imported, rig).messages(severity)
    assert said in text


def test_diagnosis_of_an_integrated_angle_is_inconclusive(log, rig, monkeypatch):
    # The plan of the run that would tell more has tests of its own, and takes seconds.
    monkeypatch.setattr("slider_drilling.diagnosis.diagnose.recommend_first_run", lambda *arguments: None)
    imported = replace(log, imported=ImportRecord(integrated={"top_drive_angle": IntegratedQuantity(9.0)}))
    answer = diagnose([imported], rig)
    assert answer.verdict == "inconclusive"
    page = page_html(report_page(answer), SI)
    assert "Log checks" in page and "no conclusion" in page and "may be off by 9.0 rad" in page


def test_pressure_within_calibration_range_passes(log, rig):
    for factor in (0.7, 1.4):
        assert not check_log(changed(log, "standpipe_pressure", value=lambda x, f=factor: f * x), rig).messages(
            "unusable"
        )


def test_backward_stamp_and_set_clock_are_unusable(log, rig):
    def back(time):
        time[300] = time[298]
        return time

    assert "stamps do not ascend at 1 places" in error_of(changed(log, "top_drive", time=back), rig)

    def set_forward(time):
        time[400:] += 3600.0
        return time

    leapt = replace(log, top_drive=replace(log.top_drive, time=set_forward(log.top_drive.time.copy())))
    assert "stamps jump by +3600.0 s" in error_of(leapt, rig)


def test_dropped_samples_are_noted_and_unknown_motion_uninformative(log, rig):
    def without(series, begin, end):
        keep = np.r_[0:begin, end : series.time.size]
        return type(series)(*(getattr(series, f.name)[keep] for f in dataclasses.fields(series)))

    checks = check_log(replace(log, standpipe_pressure=without(log.standpipe_pressure, 100, 130)), rig)
    assert any("standpipe_pressure: 30 samples (3.8 %)" in text for text in checks.messages("note"))
    assert not checks.messages("uninformative")
    unlucky = check_log(replace(log, top_drive=without(log.top_drive, 200, 500)), rig)
    assert any("its motion there is unknown" in text for text in unlucky.messages("uninformative"))


@pytest.mark.parametrize("missing", [np.nan, 0.0])
@pytest.mark.parametrize(("turning", "found"), [(1.0, True), (0.0, False)])
def test_gap_without_an_angle_is_unknown_motion_where_the_drive_turns(log, rig, missing, turning, found):
    """A speed alone does not show what the drive turned in a gap."""
    speed = changed(log, "top_drive", position=lambda x: missing + 0.0 * x).top_drive
    near = (speed.time > 5.0) & (speed.time < 65.0)
    speed = replace(speed, velocity=np.where(near, turning, 1.0) * speed.velocity)
    keep = (speed.time < 20.0) | (speed.time > 50.0)
    arrays = (getattr(speed, f.name)[keep] for f in dataclasses.fields(speed))
    texts = check_log(replace(log, top_drive=JointSeries(*arrays)), rig).messages("uninformative")
    assert any("its motion there is unknown" in text for text in texts) == found


def test_log_that_is_nearly_all_gap_has_no_powers_of_ten(log, rig):
    late = changed(log, "top_drive", time=lambda t: np.where(t > 40.0, t + 86400.0, t))
    assert any("(100 %) are missing" in text for text in check_log(late, rig).messages("note"))


def test_drive_that_hardly_turns_is_uninformative(rig):
    checks = check_log(recorded(rig, rocking(amplitude=0.01)), rig)
    assert any("too little" in text for text in checks.messages("uninformative"))
    assert not checks.messages("unusable")


def test_lowering_without_flow_is_uninformative(log, rig):
    checks = check_log(changed(log, "mud_pump", velocity=lambda x: 0.01 * x), rig)
    assert any("neither motor nor bit turns" in text for text in checks.messages("uninformative"))


@pytest.mark.parametrize(
    ("series", "column", "value"),
    [
        ("top_drive", "effort", 1e6),
        ("top_drive", "effort", -4e4),
        ("top_drive", "position", 300.0),
        ("top_drive", "velocity", 80.0),
        ("draw_works", "effort", 0.0),
        ("standpipe_pressure", "value", 1e9),
        ("mud_pump", "velocity", 0.0),
    ],
)
def test_single_glitch_is_masked_and_noted(log, rig, series, column, value):
    def spoil(values):
        values[417] = value
        return values

    checks = check_log(changed(log, series, **{column: spoil}), rig)
    assert [issue.severity for issue in checks.issues] == ["note"]
    assert "1 of 800 samples is a glitch" in str(checks.issues[0].text)
    assert "at 41.7 s" in str(checks.issues[0].text)
    masked = getattr(getattr(checks.log, series), column)
    whole = getattr(getattr(log, series), column)
    assert np.flatnonzero(np.isnan(masked) & ~np.isnan(whole)).tolist() == [417]
    assert np.array_equal(np.delete(masked, 417), np.delete(whole, 417))


def test_glitch_reaches_neither_channels_nor_commands(log, rig):
    """What is fitted differs from the sound log by one missing sample, so that no verdict can hang on it."""

    def spoiled(value):
        def spoil(values):
            values[417] = value
            return values

        return spoil

    bad = changed(changed(log, "top_drive", effort=spoiled(1e6)), "top_drive", position=spoiled(300.0))
    checks = check_log(bad, rig)
    sound, masked = measured_channels(log, rig), measured_channels(checks.log, rig)
    assert np.array_equal(masked["surface_torque"].measured, np.delete(sound["surface_torque"].measured, 417))
    driven, by = (commands_from_log(one, rig).commands for one in (log, checks.log))
    assert by.top_drive_angle == pytest.approx(driven.top_drive_angle, abs=0.05)


def test_signal_features_are_not_glitches():
    random = np.random.default_rng(3)
    time, noise = np.arange(4000.0), random.normal(size=4000)
    steps = np.repeat(random.normal(size=40), 100)
    pulses = np.zeros(4000)
    for shape, at in (((0.3, 0.7, 1.0, 0.7, 0.3), 900), ((0.4, 1.0, 0.4), 2100)):
        pulses[at : at + len(shape)] = shape
    square = np.where(np.arange(4000) % 60 < 30, 0.0, 40.0)
    slow = 10.0 * np.sin(0.02 * np.arange(4000))
    rare = np.zeros(4000)
    rare[::40] = 30.0
    for signal in (
        noise,
        steps,
        10.0 * pulses + slow + 0.1 * noise,
        square + noise,
        rare + noise,
        np.sin(noise.cumsum()),
    ):
        assert not find_glitches(time, signal).any()
    assert np.flatnonzero(find_glitches(time, np.where(np.arange(4000) == 77, 1e3, noise))).tolist() == [77]
    gaps = np.where(np.arange(4000) % 7 == 0, np.nan, noise)
    gaps[78] = -1e3
    assert np.flatnonzero(find_glitches(time, gaps)).tolist() == [78]


def test_motion_across_missing_samples_is_not_a_glitch():
    """Three samples about a reversal, those before and behind them lost: the drive had the time to get there."""
    time = 0.1 * np.arange(1200.0)
    angle = 20.0 * np.abs((0.06 * time) % 2.0 - 1.0)
    come = np.ones(1200, dtype=bool)
    come[[*range(155, 165), *range(168, 178)]] = False
    assert np.ptp(angle[come][150:160]) > 1.0
    assert not find_glitches(time[come], angle[come], 0.5).any()
    spoiled = np.where(np.arange(1200) == 166, angle + 90.0, angle)
    assert time[come][find_glitches(time[come], spoiled[come], 0.5)].tolist() == [time[166]]


def test_every_shared_log_passes(shared_data):
    paths = [*sorted((shared_data / "logs").glob("*.mcap")), *sorted((shared_data / "field").glob("*.mcap"))]
    assert len(paths) >= 14
    for path in paths:
        log = read_log(path)
        assert check_log(log, log.rig()) == LogChecks(log, ()), path.name


def test_real_log_with_other_rig_file_is_refused(shared_data, tmp_path):
    """No well or string of this recording is known; the example's are another rig's."""
    table, mapping = shared_data / "rig_1hz" / "SampleData1.csv", installed_file("config/import.surface_1hz.yaml")
    rows = ("--rows", "14245:15583")
    made = run_cli("import", table, "--mapping", mapping, *rows, "-o", tmp_path / "1.mcap", folder=tmp_path)
    assert made.returncode == 0, made.stderr
    rig_file = installed_file("config/rig.example.yaml")
    process = run_cli("diagnose", "1.mcap", "--rig", rig_file, "-o", "out", folder=tmp_path)
    assert process.returncode == 2
    assert "standpipe_pressure is 35.1 bar, but the rig file gives 289 bar" in process.stderr
    assert len(process.stderr.strip().splitlines()) == 1
