"""The rocking plan against closed forms, against full simulation, and what it writes."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner
from short_well import short_rig

import slider_drilling as sd
from slider_drilling.benchmarks.rocking_plan import checked_plans
from slider_drilling.cli import group
from slider_drilling.control import FixedRocking, SlideController
from slider_drilling.control.fixed_rocking import FixedRockingSettings
from slider_drilling.control.slide_settings import SlideSettings
from slider_drilling.errors import InputError
from slider_drilling.rig import dump_rig
from slider_drilling.rocking_design.closed_forms import bit_load_of_pressure, bit_load_of_rate, weight_without_rocking
from slider_drilling.rocking_design.plan import PlanOptions, drive_for
from slider_drilling.units import FIELD
from slider_drilling.wellbore.mesh import build_mesh, torsional_compliances
from slider_drilling.wellbore.static_loads import static_loads

RIG = short_rig()
OPTIONS = PlanOptions(elements=40, make_up_torque=30e3)


@pytest.fixture(scope="module")
def result() -> sd.RockingPlanResult:
    return sd.rocking_plan(RIG, [1000.0], options=OPTIONS)


@pytest.mark.slow
def test_plans_agree_with_full_simulation():
    """Reach within 5 %, weight on bit within 10 %, with and without rocking; every other well has weak connections."""
    for plan in checked_plans(2):
        assert abs(plan.reach_error) < 0.05
        assert abs(plan.weight_error) < 0.10
        assert abs(plan.still_error) < 0.10


def test_turning_points_lie_around_the_offset(result):
    (row,) = result.rows
    compliance = float(torsional_compliances(RIG, build_mesh(RIG, 100)).sum())
    assert row.offset == pytest.approx(row.load.torque * compliance, rel=0.02)
    assert row.right + row.left == pytest.approx(2.0 * row.amplitude)
    assert row.drive.turning_angle == pytest.approx(row.amplitude, rel=1e-3)


def test_plan_holds_its_limits(result):
    (row,) = result.rows
    assert 0.5 * row.steady.bit_swing <= OPTIONS.tool_face_swing
    assert row.limited_by == "toolface"
    assert row.steady.torque_right <= row.limits.right
    assert row.limits.back_off == pytest.approx(0.6 * 30e3)
    assert row.make_up_share == pytest.approx(row.steady.torque_right / 30e3)


def test_rocking_brings_more_weight(result):
    (row,) = result.rows
    assert row.steady.weight_on_bit == pytest.approx(row.load.weight_on_bit, rel=0.03)
    assert row.weight_without_rocking < row.load.weight_on_bit
    assert row.weight_let_down > row.load.weight_on_bit


def test_weak_connections_limit_the_torque(result):
    free = result.rows[0].steady.torque_right
    weak = 0.9 * free / 0.8
    (row,) = sd.rocking_plan(RIG, [1000.0], options=PlanOptions(elements=40, make_up_torque=weak)).rows
    assert row.limited_by == "make-up torque"
    assert 0.9 * row.limits.right < row.steady.torque_right <= row.limits.right
    assert row.steady.rocked_to < result.rows[0].steady.rocked_to


def test_connections_too_weak_are_refused():
    with pytest.raises(InputError, match="even the smallest rocking exceeds the limit of the make-up torque"):
        sd.rocking_plan(RIG, [1000.0], options=PlanOptions(elements=40, make_up_torque=1000.0))


def test_bit_load_agrees_with_the_motor():
    load = bit_load_of_pressure(RIG, 18e5)
    assert load.torque == pytest.approx(18e5 * RIG.motor.torque_per_pressure)
    assert load.weight_on_bit * RIG.bit.lever == pytest.approx(load.torque)
    assert bit_load_of_rate(RIG, load.rate_of_penetration).weight_on_bit == pytest.approx(load.weight_on_bit, rel=1e-4)


def test_weight_without_rocking_inverts_static_loads():
    mesh = build_mesh(RIG, 100)
    hook_load = static_loads(RIG, axial_speed=1.0, weight_on_bit=30e3, mesh=mesh).hook_load
    assert weight_without_rocking(RIG, hook_load, mesh) == pytest.approx(30e3, abs=5.0)
    assert weight_without_rocking(RIG, 1e9, mesh) == 0.0


@pytest.mark.parametrize(("options", "message"), [
    (PlanOptions(differential_pressure=80e5), "below motor.max_pressure"),
    (PlanOptions(rate_of_penetration=0.5), "below what stalls the motor"),
    (PlanOptions(make_up_torque=-1.0), "make_up_torque = -1.0: must be a finite number above 0"),
    (PlanOptions(tool_face_swing=math.nan), "tool_face_swing = nan"),
])  # fmt: skip
def test_impossible_options_are_refused(options: PlanOptions, message: str):
    with pytest.raises(InputError, match=message):
        sd.rocking_plan(RIG, [1000.0], options=options)


def test_depth_outside_the_string_is_refused():
    with pytest.raises(InputError, match="at most the string's 1000 m"):
        sd.rocking_plan(RIG, [1200.0])


def test_period_too_short_for_the_drive_is_refused():
    with pytest.raises(InputError, match="the top drive needs"):
        drive_for(RIG, 40.0, 0.3, period=10.0)


def test_settings_drive_the_controllers(result, tmp_path: Path):
    paths = result.save(tmp_path)
    for path, controller, settings in ((paths[3], FixedRocking, FixedRockingSettings),
                                       (paths[4], SlideController, SlideSettings)):  # fmt: skip
        given = yaml.safe_load(path.read_text())["/**/rocking_controller"]["ros__parameters"]
        assert given.pop("controller") == f"slider_drilling.control:{controller.__name__}"
        made = controller(RIG, settings(**given))
        assert made.settings.period == pytest.approx(result.rows[0].drive.period, abs=1e-3)


def test_sheet_is_one_page(result, tmp_path: Path):
    sheet = result.save(tmp_path, FIELD)[1].read_bytes()
    assert sheet.startswith(b"%PDF")
    assert sheet.count(b"/Type /Page ") == 1 or sheet.count(b"/Type /Page\n") == 1
    assert sheet == result.save(tmp_path / "again", FIELD)[1].read_bytes()


def test_columns_hold_every_depth(result):
    frame = result.columns()
    assert frame.units["torque_right"] == "N m"
    assert frame.values["depth"] == pytest.approx([1000.0])


def test_command_plans_in_field_units(tmp_path: Path):
    rig = tmp_path / "rig.yaml"
    rig.write_text(dump_rig(RIG))
    common = ["rocking-plan", "--rig", str(rig), "-o", str(tmp_path / "out"), "--elements", "30"]
    done = CliRunner().invoke(group, [*common, "--depths", "3200ft", "--make-up-torque", "20000ft.lbf",
                                      "--differential-pressure", "200psi"])  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "bit depth, ft" in done.output
    assert "klbf" in (tmp_path / "out" / "rocking_plan.html").read_text()
    tree = json.loads((tmp_path / "out" / "rocking_plan.json").read_text())
    assert tree["rows"][0]["differential_pressure"] == pytest.approx(200 * 6894.757, rel=1e-4)
    assert tree["rows"][0]["make_up_torque"] == pytest.approx(20000 * 1.3558179, rel=1e-4)


@pytest.mark.parametrize(("depths", "message"), [
    ("3000", "expected a number and its unit"),
    ("3000ft:2000ft", "FROM below TO"),
    ("1ft:2ft:3ft:4ft", "expected FROM:TO or FROM:TO:STEP"),
    ("2000ft:3000ft:0ft", "expected FROM:TO or FROM:TO:STEP"),
])  # fmt: skip
def test_faulty_depths_are_refused(tmp_path: Path, depths: str, message: str):
    rig = tmp_path / "rig.yaml"
    rig.write_text(dump_rig(RIG))
    done = CliRunner().invoke(group, ["rocking-plan", "--rig", str(rig), "-o", str(tmp_path), "--depths", depths])
    assert isinstance(done.exception, InputError)
    assert message in str(done.exception)
