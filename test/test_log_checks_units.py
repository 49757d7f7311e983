"""Log checks: a channel in another unit, sign or rig is refused, and the unit that explains it named."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from made_log import changed, error_of, recorded, rocking
from short_well import short_rig

from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.log.import_record import ImportRecord
from slider_drilling.log.value_limits import mask_impossible_values
from slider_drilling.log_checks import check_log
from slider_drilling.rig import Rig
from slider_drilling.units import KINDS


@pytest.fixture(scope="module")
def rig() -> Rig:
    return short_rig()


@pytest.fixture(scope="module")
def log(rig) -> RigLog:
    return recorded(rig, rocking())


@pytest.mark.parametrize(
    ("series", "column", "kind", "unit", "channel"),
    [
        ("top_drive", "effort", "torque", "kN m", "surface_torque"),
        ("top_drive", "effort", "torque", "kft lbf", "surface_torque"),
        ("top_drive", "effort", "torque", "daN m", "surface_torque"),
        ("draw_works", "effort", "force", "kN", "hook_load"),
        ("draw_works", "effort", "force", "klbf", "hook_load"),
        ("draw_works", "effort", "force", "tf", "hook_load"),
        ("standpipe_pressure", "value", "pressure", "bar", "standpipe_pressure"),
        ("standpipe_pressure", "value", "pressure", "psi", "standpipe_pressure"),
        ("standpipe_pressure", "value", "pressure", "MPa", "standpipe_pressure"),
    ],
)
def test_channel_in_wrong_unit_is_unusable_and_unit_named(log, rig, series, column, kind, unit, channel):
    text = error_of(changed(log, series, **{column: lambda x: x / KINDS[kind][unit]}), rig)
    assert channel in text
    assert unit in text
    assert "with that unit" in text


@pytest.mark.parametrize(
    ("series", "column", "channel", "noise"),
    [
        ("draw_works", "effort", "hook_load", 1.0),
        ("draw_works", "effort", "hook_load", 0.0),
        ("draw_works", "effort", "hook_load", 300.0),
        ("top_drive", "effort", "surface_torque", 2.0),
        ("top_drive", "effort", "surface_torque", 0.0),
        ("standpipe_pressure", "value", "standpipe_pressure", 10.0),
        ("standpipe_pressure", "value", "standpipe_pressure", 0.0),
    ],
)
def test_dead_sensor_gets_no_unit(log, rig, series, column, channel, noise):
    random = np.random.default_rng(0)
    text = error_of(changed(log, series, **{column: lambda x: noise * random.normal(size=x.size)}), rig)
    assert f"{channel} " in text and "dead, not connected or tared" in text
    assert "looks like" not in text


def test_part_of_a_run_may_begin_while_wall_and_bit_carry_the_string(log, rig):
    loaded = changed(log, "draw_works", effort=lambda x: 0.25 * x)
    assert "hook_load starts at" in error_of(loaded, rig)
    assert not [issue for issue in check_log(loaded, rig, whole=False).issues if issue.severity == "unusable"]
    dead = check_log(changed(log, "draw_works", effort=lambda x: 0.0 * x), rig, whole=False)
    assert any("dead" in str(issue.text) for issue in dead.issues)


def test_hints_name_units_of_recorders(log, rig):
    assert "MN" not in error_of(changed(log, "draw_works", effort=lambda x: 1.0 + 0.0 * x + 1e-6 * x), rig)


@pytest.mark.parametrize(
    ("column", "factor", "says"),
    [
        ("velocity", 30.0 / np.pi, "speed looks like .*rpm"),
        ("velocity", 180.0 / np.pi, "speed looks like deg/s"),
        ("position", 180.0 / np.pi, "angle looks like deg"),
        ("position", 0.5 / np.pi, "angle looks like rev"),
        ("velocity", -1.0, "wrong sign"),
        ("velocity", 3.0, "not in rad and s"),
    ],
)
def test_angle_that_contradicts_speed_is_unusable(log, rig, column, factor, says):
    with pytest.raises(InputError, match=says):
        check_log(changed(log, "top_drive", **{column: lambda x: factor * x}), rig).raise_if_unusable()


def test_block_in_feet_and_pump_in_spm_are_unusable(log, rig):
    assert "the position looks like ft" in error_of(changed(log, "draw_works", position=lambda x: x / 0.3048), rig)
    assert "the speed looks like m/h" in error_of(changed(log, "draw_works", velocity=lambda x: 3600.0 * x), rig)
    strokes = error_of(changed(log, "mud_pump", velocity=lambda x: 30.0 / np.pi * x), rig)
    assert "mud_pump turns at 117.5 rad/s" in strokes
    assert "strokes per minute" in strokes


def test_drive_faster_than_its_limit_is_unusable(log, rig):
    both = changed(log, "top_drive", position=lambda x: 60.0 * x, velocity=lambda x: 60.0 * x)
    assert "max_speed is 12.6" in error_of(both, rig)
    assert "deg/s" in error_of(both, rig)


def test_toolface_in_degrees_is_unusable(log, rig):
    assert "looks like deg" in error_of(changed(log, "mwd_tool_face", position=lambda x: np.degrees(x) + 90.0), rig)


def test_wrong_signs_are_unusable(log, rig):
    against = error_of(changed(log, "top_drive", effort=lambda x: -x), rig)
    assert "surface_torque opposes the rotation" in against
    against = error_of(changed(log, "top_drive", position=lambda x: -x, velocity=lambda x: -x), rig)
    assert "surface_torque opposes the rotation" in against
    assert "hook_load is negative" in error_of(changed(log, "draw_works", effort=lambda x: -x), rig)
    assert "standpipe_pressure is negative" in error_of(changed(log, "standpipe_pressure", value=lambda x: -x), rig)
    turned = changed(log, "draw_works", position=lambda x: -x, velocity=lambda x: -x)
    assert "the block rises by 0.32 m" in error_of(turned, rig)


def test_block_that_really_rises_passes(rig):
    assert check_log(recorded(rig, rocking(lowering=-0.004)), rig).messages("unusable") == ()


def test_wrapping_encoder_is_unusable(log, rig):
    wrapped = changed(log, "top_drive", position=lambda x: np.mod(x, 2.0 * np.pi))
    assert "encoder that wraps" in error_of(wrapped, rig)


def test_other_rigs_file_is_unusable(log, rig):
    heavy = replace(rig, string=replace(rig.string, density=3.0 * rig.string.density))
    assert "hook_load starts at" in error_of(log, heavy)
    assert "do not belong together" in error_of(log, heavy)
    wide = replace(rig, hydraulics=replace(rig.hydraulics, reference_pressure=1e7, reference_flow=0.01))
    assert "standpipe_pressure" in error_of(log, wide)


@pytest.mark.parametrize(("true", "taken"), [*itertools.permutations(("psi", "bar", "MPa", "kPa"), 2)])
def test_unit_taken_for_another_is_named(log, rig, true, taken):
    factor = KINDS["pressure"][taken] / KINDS["pressure"][true]
    text = error_of(changed(log, "standpipe_pressure", value=lambda x: factor * x), rig)
    assert f"{true} that was imported as {taken}" in text
    assert "mud_pump" not in text, "the pump is right"


@pytest.mark.parametrize(("true", "taken"), [*itertools.permutations(("Pa", "psi", "bar", "MPa", "kPa"), 2)])
def test_of_an_imported_table_only_the_unit_that_explains_the_level_is_named(log, rig, true, taken):
    factor = KINDS["pressure"][taken] / KINDS["pressure"][true]
    wrong = changed(log, "standpipe_pressure", value=lambda x: factor * x)
    text = error_of(replace(wrong, imported=ImportRecord(units={"standpipe_pressure": taken})), rig)
    looks = text.partition("looks like ")[2] or text.partition("either it is in ")[2]
    named, told, _ = looks.partition(f" that was imported as {taken}")
    assert told and true in named.split(" or ") and taken not in named.split(" or ")


@pytest.mark.parametrize("steady", [False, True])
def test_pump_in_spm_is_named_though_its_speed_is_no_rigs(log, rig, steady):
    """A pump that runs steadily at 117.5 "rad/s" is one in strokes per minute, not a null."""
    fast = changed(log, "mud_pump", velocity=lambda x: 30.0 / np.pi * (x if steady else x + np.sin(np.arange(x.size))))
    text = error_of(mask_impossible_values(fast), rig)
    assert "mud_pump turns" in text and "import it with unit spm" in text


def test_repeated_null_of_a_pump_is_no_other_unit(log):
    fast = mask_impossible_values(changed(log, "mud_pump", velocity=lambda x: 999.0 + 0.0 * x))
    assert np.isnan(fast.mud_pump.velocity).all()


@pytest.mark.parametrize(("column", "unit"), [("position", "deg"), ("position", "rev"), ("velocity", "deg/s")])
def test_angle_or_speed_converted_twice_is_named_or_left_open(log, rig, column, unit):
    """rad imported as deg makes the speed look like deg/s: both causes are named where both explain the ratio."""
    kind = "angle" if column == "position" else "angular speed"
    text = error_of(changed(log, "top_drive", **{column: lambda x: x * KINDS[kind][unit]}), rig)
    si = "rad" if column == "position" else "rad/s"
    assert f"looks like {si} that was imported as {unit}" in text
