"""The friction in a log: what torque and angle say alone, and what the plant fitted to them says."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.analysis.analyse import analyse
from slider_drilling.analysis.cycles import breakover, rocking_cycles
from slider_drilling.analysis.fit_friction import fit_friction
from slider_drilling.analysis.report import analysis_study, to_json
from slider_drilling.cli import group
from slider_drilling.control.rocking import Rocking
from slider_drilling.drillstring import simulate
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog, read_log
from slider_drilling.log.series import JointSeries
from slider_drilling.paper_studies.whole_well import slide
from slider_drilling.rig import FrictionInterval, dump_rig
from slider_drilling.rig.example import example_rig

ELEMENTS = 60


def test_friction_work_is_the_area_of_the_loop():
    """A rigid Coulomb string: torque is +-T, so the loop is a rectangle of 2 T times the swing."""
    t = np.arange(0.0, 100.0, 0.01)
    wave = Rocking(5.0, 20.0, 0.2)
    angle, speed = np.array([wave.point(x) for x in t]).T
    cycles = rocking_cycles(t, angle, 1000.0 * np.sign(speed))
    assert len(cycles) == 4
    for cycle in cycles:
        assert cycle.end - cycle.start == pytest.approx(20.0, abs=0.02)
        assert cycle.swing == pytest.approx(2.0 * wave.turning_angle, rel=1e-4)
        assert cycle.work == pytest.approx(2.0 * 1000.0 * cycle.swing, rel=2e-3)


def test_moved_rocking_centre_adds_no_work():
    """A string without friction is a spring: wherever the centre goes, its loop has no area."""
    t = np.arange(0.0, 100.0, 0.01)
    angle = 5.0 * np.sin(2.0 * math.pi * t / 20.0) + 0.05 * t
    for cycle in rocking_cycles(t, angle, 400.0 * angle):
        assert abs(cycle.work) < 1e-6 * 400.0 * 100.0


def test_still_pipe_and_steady_rotation_have_no_cycles():
    t = np.arange(0.0, 100.0, 0.1)
    assert rocking_cycles(t, 0.1 * np.sin(t), t) == []
    assert rocking_cycles(t, 3.0 * t, t) == []


def test_breakover_is_the_peak_before_steady_rotation():
    t = np.arange(0.0, 120.0, 0.1)
    speed = np.clip((t - 10.0) / 5.0, 0.0, 1.0) * 8.0
    torque = 9000.0 * np.clip((t - 10.0) / 5.0, 0.0, 1.0) + 4000.0 * np.exp(-(((t - 18.0) / 2.0) ** 2))
    found = breakover(t, -speed, -torque)
    assert found.peak == pytest.approx(-13000.0, rel=1e-3)
    assert found.steady == pytest.approx(-9000.0, rel=1e-3)
    assert found.at == pytest.approx(18.0, abs=0.2)


def test_rocking_never_breaks_over():
    t = np.arange(0.0, 120.0, 0.1)
    assert breakover(t, np.sin(t), np.cos(t)) is None
    assert breakover(t, 0.0 * t, 0.0 * t) is None


def shorter_rig():
    """The example rig with 1000 m less horizontal hole: a third of the work."""
    rig = example_rig()
    pipe, *below = rig.string.sections
    cased, open_hole = rig.well.friction_intervals
    return replace(
        rig,
        well=replace(
            rig.well, survey=(*rig.well.survey[:-1], (3000.0, 90.0, 0.0)),
            friction_intervals=(cased, replace(open_hole, to=3000.0)),
        ),
        string=replace(rig.string, sections=(replace(pipe, length=pipe.length - 1000.0), *below)),
    )  # fmt: skip


def recorded(rig, true_factors, noise=150.0, seed=4, block=True):
    """A log of the rig with other friction than its file says."""
    own = rig.well.friction_intervals
    intervals = tuple(FrictionInterval(i.to, f) for i, f in zip(own, true_factors, strict=True))
    true = replace(rig, well=replace(rig.well, friction_intervals=intervals))
    commands = slide(rig, 120.0, 9.0 if block else 0.0, 10.0, 20.0)
    response = simulate(true, commands, ELEMENTS)
    random = np.random.default_rng(seed)
    n = commands.time.size
    drive = JointSeries(
        commands.time, commands.time, commands.top_drive_angle, commands.top_drive_speed,
        response.surface_torque + noise * random.standard_normal(n),
    )  # fmt: skip
    works = JointSeries(
        commands.time, commands.time, commands.block_position, commands.block_speed,
        response.hook_load + 4000.0 * random.standard_normal(n),
    )  # fmt: skip
    pump = JointSeries(commands.time, commands.time, 0.0 * commands.time, commands.pump_speed, 0.0 * commands.time)
    return RigLog(
        "made.mcap", 0, rig_text=dump_rig(rig), top_drive=drive, draw_works=works if block else None,
        mud_pump=pump if block else None,
    )  # fmt: skip


@pytest.fixture(scope="module")
def analysed():
    rig = shorter_rig()
    return analyse(recorded(rig, (0.95, 0.8)), rig, ELEMENTS)


def test_fit_finds_friction_unlike_the_rig_file(analysed):
    cased, open_hole = analysed.fit.intervals
    assert (cased.kind, open_hole.kind) == ("cased", "open hole")
    assert cased.factor == pytest.approx(0.95, rel=0.03)
    assert open_hole.factor == pytest.approx(0.80, rel=0.03)
    for row, true in ((cased, 0.95), (open_hole, 0.80)):
        low, high = row.factor_interval
        assert low - 0.01 < true < high + 0.01
        assert high - low < 0.2
        assert row.is_determined
    assert analysed.fit.rms["surface_torque"] == pytest.approx(150.0, rel=0.1)
    assert analysed.fit.rms_before["surface_torque"] > 1.3 * analysed.fit.rms["surface_torque"]


def test_rocking_lets_more_weight_through(analysed):
    found = to_json(analysed)
    axial, transfer = found["axial_friction"], found["weight_transfer"]
    assert axial["with_rocking"]["over_coulomb"] < 0.6 * axial["without_rocking"]["over_coulomb"] <= 0.6
    assert transfer["with_rocking"]["weight_on_bit_mean"] > transfer["without_rocking"]["weight_on_bit_mean"]
    assert transfer["with_rocking"]["share_reaching_the_bit"] > transfer["without_rocking"]["share_reaching_the_bit"]


def test_zones_and_breakover_are_consistent(analysed):
    found = to_json(analysed)
    assert found["zones"]
    for zone in found["zones"]:
        assert 0.0 < zone["rocked_to"] <= 3000.0
    assert found["breakover_torque"]["measured"] is None
    assert found["breakover_torque"]["to_turn_the_whole_string"] > 3000.0
    assert any("breakover" in sentence for sentence in found["not_found"])


def test_friction_work_is_bounded_by_the_fit(analysed):
    rocking = to_json(analysed)["rocking"]
    most = 2.0 * rocking["swing"] * 0.5 * (rocking["clockwise_torque"] - rocking["counter_torque"])
    assert 0.02 * most < rocking["friction_work_per_cycle"]["median"] < most


def test_result_is_json_and_makes_a_page(analysed):
    found = to_json(analysed)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    shown = analysis_study(analysed)
    assert {table.caption for table in shown.tables} == {"Apparent friction", "Results"}
    assert any("zones" in figure.title.lower() for figure in shown.figures)


def test_torque_only_log_names_what_is_undetermined():
    """Rocked off bottom, as a torque-only log is: the plant takes the block to stand still."""
    rig = shorter_rig()
    found = analyse(recorded(rig, (0.8, 1.2), block=False), rig, ELEMENTS)
    assert found.fit.channels == ("surface_torque",)
    assert found.fit.intervals[1].factor == pytest.approx(1.2, rel=0.1)
    assert found.still is None
    said = " ".join(map(str, found.undetermined))
    assert "weight transfer" in said and "breakover" in said
    assert to_json(found)["weight_transfer"] is None


def test_log_without_rig_gives_cycles_and_breakover():
    found = analyse(recorded(shorter_rig(), (0.8, 1.0)), None)
    assert to_json(found)["friction"] is None
    assert to_json(found)["rocking"]["cycles"] >= 4
    assert "no rig file" in " ".join(map(str, found.undetermined))


def test_a_log_without_torque_is_refused():
    log = recorded(shorter_rig(), (0.8, 1.0))
    silent = replace(log, top_drive=replace(log.top_drive, effort=np.full_like(log.top_drive.effort, math.nan)))
    with pytest.raises(InputError, match="holds no surface torque"):
        analyse(silent, None)


@pytest.mark.parametrize("name", ["nominal_base", "nominal_short", "nominal_long"])
def test_friction_of_reference_log_within_3_percent(shared_data, name):
    log = read_log(shared_data / "logs" / f"{name}.mcap")
    for row in fit_friction(log, log.rig()).intervals:
        assert row.factor == pytest.approx(row.in_rig_file, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["labelled_stribeck", "labelled_cuttings_bed", "labelled_top_drive_backlash"])
def test_friction_of_noisy_log_within_15_percent(shared_data, name):
    log = read_log(shared_data / "logs" / f"{name}.mcap")
    fit = fit_friction(log, log.rig())
    for row in fit.intervals:
        assert row.factor == pytest.approx(row.in_rig_file, rel=0.15)
    assert (fit.bed is not None) == (name == "labelled_cuttings_bed")
    if fit.bed is not None:
        assert fit.bed.top < 3264.0 and fit.bed.bottom > 2944.0


def test_command_analyses_a_real_torque_only_log(shared_data, tmp_path):
    log = shared_data / "field" / "well_b_1733m.mcap"
    rig = shared_data / "field" / "well_b_1733m.rig.yaml"
    out = tmp_path / "out"
    result = CliRunner().invoke(group, ["analyse", str(log), "--rig", str(rig), "-o", str(out), "--elements", "40"])
    assert result.exit_code == 0, (result.output, result.exception)
    found = json.loads((out / "analysis.json").read_text())
    assert found["breakover_torque"]["largest_in_log"] > 1000.0
    assert found["weight_transfer"] is None
    assert any("weight transfer" in sentence for sentence in found["not_found"])
    assert (out / "analysis.html").stat().st_size < 1_500_000


def test_long_log_is_cut_to_busiest_hour(tmp_path):
    """Ten hours of standing still and rotating with rocking in between: bounded work, and said."""
    time = np.arange(0.0, 36_000.0, 0.5)
    rocking = (time >= 20_000.0) & (time < 23_000.0)
    speed = np.where(rocking, 3.0 * np.cos(2.0 * np.pi * time / 20.0), np.where(time > 30_000.0, 6.0, 0.0))
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    log = RigLog("day.mcap", 0, top_drive=JointSeries(time, time, angle, speed, 5000.0 * np.tanh(3.0 * speed)))
    found = analyse(log, None)
    assert len(found.time) == pytest.approx(7200, abs=2) and len(found.cycles) == pytest.approx(150, abs=3)
    first = found.log.start_ns * 1e-9
    assert first <= 20_000.0 and first + 3600.0 >= 23_000.0
    assert any("where the top drive rocks most" in str(text) for text in found.undetermined)
