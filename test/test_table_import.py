"""CSV tables into logs: units, signs, nulls, and every mistake named."""

import datetime
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from slider_drilling.cli import COMMANDS
from slider_drilling.commands.import_table import command
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import read_log, save_log
from slider_drilling.table_import import read_table
from slider_drilling.unit_spellings import SPELLINGS
from slider_drilling.units import KINDS, si_factor, unit_factor

BASE: dict[str, Any] = {
    "schema": "slider_drilling/csv/1",
    "time": {"column": "t", "unit": "s"},
    "channels": {"surface_torque": {"column": "torque", "unit": "N m"}},
}


def mapping_file(folder: Path, **changes: Any) -> Path:
    path = folder / "mapping.yaml"
    path.write_text(yaml.safe_dump(BASE | changes))
    return path


def table_file(folder: Path, text: str) -> Path:
    path = folder / "table.csv"
    path.write_text(text)
    return path


def test_a_saved_import_keeps_the_unit_of_each_channel(tmp_path: Path) -> None:
    channels = {"surface_torque": {"column": "torque", "unit": "KN.M"}}
    log = read_table(table_file(tmp_path, "t,torque\n0,1\n1,2\n2,3\n"), mapping_file(tmp_path, channels=channels))
    save_log(log, tmp_path / "x.mcap", "test")
    saved = read_log(tmp_path / "x.mcap").imported
    assert saved is not None and saved.units == {"surface_torque": "KN.M"}


@pytest.mark.parametrize(
    ("unit", "kind", "value"),
    [
        ("klbf", "force", 4448.2216152605),
        ("psi", "pressure", 6894.757293168361),
        ("ft lbf", "torque", 1.3558179483314004),
        ("ft-lbf", "torque", 1.3558179483314004),
        ("kN.m", "torque", 1000.0),
        ("rpm", "angular speed", math.pi / 30.0),
        ("gal/min", "flow", 6.30901964e-5),
        ("kdaN", "force", 10_000.0),
        ("deg", "angle", math.pi / 180.0),
        ("ft/h", "speed", 8.466666666666667e-5),
    ],
)
def test_units_against_their_definitions(unit: str, kind: str, value: float) -> None:
    assert si_factor(unit, kind, "here") == pytest.approx(value, rel=1e-9)


def test_first_unit_of_every_kind_is_si() -> None:
    assert all(next(iter(units.values())) == 1.0 for units in KINDS.values())


def test_wrong_unit_names_its_kind() -> None:
    with pytest.raises(InputError, match="'psi': is a unit of pressure, not of force"):
        si_factor("psi", "force", "map.yaml: channels.hook_load")


@pytest.mark.parametrize(
    ("spelling", "kind", "unit"),
    [
        ("PSI", "pressure", "psi"), ("KLBF", "force", "klbf"), ("klb", "force", "klbf"), ("1000 lbf", "force", "klbf"),
        ("kkgf", "force", "tf"), ("KDN", "force", "kdaN"), ("KN.M", "torque", "kN m"), ("kft.lbf", "torque", "kft lbf"),
        ("1000 ft.lbf", "torque", "kft lbf"), ("KFLB", "torque", "kft lbf"), ("lpm", "flow", "L/min"),
        ("l/min", "flow", "L/min"), ("galUS/min", "flow", "gpm"), ("usft", "length", "usft"), ("dega", "angle", "deg"),
        ("°", "angle", "deg"), ("RPM", "angular speed", "rpm"), ("ns", "time", "ns"), ("kpsi", "pressure", "kpsi"),
    ],
)  # fmt: skip
def test_spellings_of_recorders_keep_the_size(spelling: str, kind: str, unit: str) -> None:
    assert si_factor(spelling, kind, "here") == pytest.approx(KINDS[kind][unit], rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "kind"), [("ton", "force"), ("mPa", "pressure"), ("mN", "force"), ("kpm", "flow"), ("mph", "speed")]
)
def test_unknown_unit_gets_no_near_one(unit: str, kind: str) -> None:
    with pytest.raises(InputError, match=f"not a known unit of {kind}; use") as error:
        si_factor(unit, kind, "here")
    assert "did you mean" not in str(error.value)


@pytest.mark.parametrize("unit", ["", " ", "-", "--", ".", "*", "()", "[-]", "_", "1000", "x"])
def test_no_unit_is_no_unit_of_any_kind(unit: str) -> None:
    """A head such as "Torque (-)" was taken for mega newton metres."""
    assert [kind for kind in KINDS if unit_factor(unit, kind) is not None] == []


def test_every_spelling_means_one_size() -> None:
    for kind, units in SPELLINGS.items():
        for unit, spellings in units.items():
            for spelling in spellings.split(", "):
                assert unit_factor(spelling, kind) == KINDS[kind][unit], (kind, unit, spelling)


def test_every_channel_and_option(tmp_path: Path) -> None:
    lines = ["t,rpm,torque,block,load,psi,p1,p2,tf"]
    lines += [f"{k},60,1000,{100 - k},200,2000,30,30,{90 if k < 5 else 270}" for k in range(10)]
    channels = {
        "top_drive_angle": {"column": "rpm", "unit": "rpm", "integral": True},
        "top_drive_speed": {"column": "rpm", "unit": "rpm"},
        "surface_torque": {"column": "torque", "unit": "ft lbf", "sign": -1},
        "block_position": {"column": "block", "unit": "ft", "sign": -1, "from_first": True},
        "hook_load": {"column": "load", "unit": "klbf"},
        "standpipe_pressure": {"column": "psi", "unit": "psi"},
        "pump_speed": {"column": "p1", "plus": ["p2"], "unit": "spm"},
        "tool_face": {"column": "tf", "unit": "deg", "on_change": True, "delay": 6.0},
    }
    log = read_table(table_file(tmp_path, "\n".join(lines)), mapping_file(tmp_path, channels=channels))
    second = np.arange(10.0)
    assert log.top_drive is not None and log.draw_works is not None and log.standpipe_pressure is not None
    assert log.mud_pump is not None and log.mwd_tool_face is not None
    np.testing.assert_allclose(log.top_drive.time, second)
    np.testing.assert_allclose(log.top_drive.velocity, 2.0 * math.pi)
    np.testing.assert_allclose(log.top_drive.position, 2.0 * math.pi * second)
    np.testing.assert_allclose(log.top_drive.effort, -1355.8179483314004)
    np.testing.assert_allclose(log.draw_works.position, 0.3048 * second)
    np.testing.assert_allclose(log.draw_works.effort, 200 * 4448.2216152605)
    np.testing.assert_allclose(log.standpipe_pressure.value, 2000 * 6894.757293168361)
    np.testing.assert_allclose(log.mud_pump.velocity, 2.0 * math.pi)
    np.testing.assert_allclose(log.mwd_tool_face.position, [math.pi / 2, -math.pi / 2])
    np.testing.assert_allclose(log.mwd_tool_face.arrival, [0.0, 5.0])
    np.testing.assert_allclose(log.mwd_tool_face.time, [-6.0, -1.0])


def test_nulls_repeats_and_unit_line(tmp_path: Path) -> None:
    text = "made by somebody\nt,torque,angle\ns,Nm,rad\n1,10,\n2,-999.25,-999.25\n3,,7\n3,30,8\n\n4,nan,9\n"
    channels = {**BASE["channels"], "top_drive_angle": {"column": "angle", "unit": "rad"}}
    log = read_table(
        table_file(tmp_path, text), mapping_file(tmp_path, skip_lines=1, unit_line=True, channels=channels)
    )
    assert log.top_drive is not None
    np.testing.assert_allclose(log.top_drive.time, [0.0, 2.0, 3.0])
    np.testing.assert_array_equal(log.top_drive.effort, [10.0, 30.0, np.nan])
    np.testing.assert_array_equal(log.top_drive.position, [np.nan, 8.0, 9.0])
    assert "1 of 5 rows repeat a time: the last of each is kept" in log.notes
    assert log.start == 1.0


def test_dates_as_times(tmp_path: Path) -> None:
    text = "t,torque\n2024-05-01T12:00:00Z,1\n2024-05-01T14:00:00.5+02:00,2\n2024-05-01 12:00:01.1234567Z,3\n"
    log = read_table(table_file(tmp_path, text), mapping_file(tmp_path, time={"column": "t", "unit": "iso8601"}))
    assert log.start == datetime.datetime(2024, 5, 1, 12, tzinfo=datetime.timezone.utc).timestamp()
    assert log.top_drive is not None
    np.testing.assert_allclose(log.top_drive.time, [0.0, 0.5, 1.1234567])


def test_flow_needs_the_rig(tmp_path: Path) -> None:
    table = table_file(tmp_path, "t,q\n0,32\n1,32\n")
    mapping = mapping_file(tmp_path, channels={"pump_flow": {"column": "q", "unit": "L/s"}})
    with pytest.raises(InputError, match=r"pump_flow: needs the rig file's mud_pump\.displacement"):
        read_table(table, mapping)
    log = read_table(table, mapping, installed_file("config/rig.example.yaml"))
    assert log.mud_pump is not None
    np.testing.assert_allclose(log.mud_pump.velocity, 0.032 / 0.0026)
    assert log.rig().mud_pump.displacement == 0.0026


@pytest.mark.parametrize(
    ("text", "changes", "message"),
    [
        ("", {}, "is empty"),
        ("t,torque\n", {}, "no rows of numbers"),
        ("t,torque\n0,1\n1,abc\n", {}, "line 3: column 'torque' = 'abc': not a number"),
        ("t,torque\n0,1\n1,2,3\n", {}, "line 3: 3 cells where 2 columns are named"),
        ("t,torque\n0,1\n5,1\n4,1\n", {}, "line 4: time goes back from 5 s to 4 s"),
        ("t,torque\n0,\n1,-999.25\n", {}, "all mapped columns are empty or null"),
        ("t,torque\n,1\n", {}, "no row with a time"),
        ("t,torque\n-5,1\n", {}, "start: times begin at -5 s"),
        ("t,other\n0,1\n", {}, r"channels\.surface_torque: column 'torque': no such column in .*, which has t, other"),
        ("t,torque,torque\n0,1,2\n", {}, "column 'torque': 2 such column"),
        ("t,torque\n0,1\n", {"schema": "x"}, "schema = 'x'"),
        ("t,torque\n0,1\n", {"time": {"column": "t", "unit": "iso8601"}}, "line 2: column 't' = '0': not a time"),
        ("t,torque\n0,1\n", {"delimiter": ""}, "delimiter = ''"),
        ("t,torque\n0,1\n", {"skip_lines": -1}, "skip_lines = -1"),
        ("t,torque\n0,1\n", {"skip_lines": "2"}, "skip_lines = '2': expected a whole number"),
        ("t,torque\n0,1\n", {"colums": []}, "colums: unknown key"),
        ("t,torque\n0,1\n", {"channels": {}}, "channels: missing"),
        ("t,torque\n0,1\n", {"channels": {"torque": {}}}, r"channels\.torque: unknown channel"),
        (
            "t,torque\n0,1\n",
            {"channels": {"surface_torque": {"column": "torque", "unit": "N m", "sign": 2}}},
            "must be at most 1",
        ),
        (
            "t,torque\n0,1\n",
            {"channels": {"surface_torque": {"column": "torque", "unit": "N m", "sign": 0.5}}},
            "must be 1 or -1",
        ),
        (
            "t,torque\n0,1\n",
            {"channels": {"surface_torque": {"column": "torque", "unit": "N m", "integral": True}}},
            "only angles and positions",
        ),
        (
            "t,torque\n0,1\n",
            {
                "channels": {
                    "pump_speed": {"column": "torque", "unit": "spm"},
                    "pump_flow": {"column": "torque", "unit": "gpm"},
                }
            },
            "pump_(flow|speed): is the same quantity as pump_(speed|flow)",
        ),
    ],
)
def test_mistakes_are_named(tmp_path: Path, text: str, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_table(table_file(tmp_path, text), mapping_file(tmp_path, **changes))


@settings(max_examples=25)
@given(values=hnp.arrays(np.float64, st.integers(1, 30), elements=st.floats(-4e5, 4e5)))
def test_table_to_log_and_back(tmp_path_factory: pytest.TempPathFactory, values: np.ndarray) -> None:
    folder = tmp_path_factory.mktemp("table")
    text = "t,torque\n" + "".join(f"{k * 0.5},{value!r}\n" for k, value in enumerate(values.tolist()))
    log = read_table(table_file(folder, text), mapping_file(folder, null_values=[]))
    save_log(log, folder / "log.mcap", recorded_by="test")
    again = read_log(folder / "log.mcap")
    assert again.notes == () and log.top_drive is not None and again.top_drive is not None
    np.testing.assert_allclose(again.top_drive.time, 0.5 * np.arange(len(values)), atol=1e-9)
    np.testing.assert_array_equal(again.top_drive.effort, values)
    np.testing.assert_array_equal(log.top_drive.effort, values)


def test_example_mapping_file_is_usable(tmp_path: Path) -> None:
    table = table_file(
        tmp_path,
        "time,rpm,torque,block_height,hook_load,pressure,pump_1,pump_2,tool_face\n"
        "0,10,8000,60,210,2900,60,60,15\n1,10,8100,59.9,211,2910,60,60,15\n",
    )
    log = read_table(table, installed_file("config/import.example.yaml"))
    assert log.notes == ()
    assert log.mwd_tool_face is not None and len(log.mwd_tool_face.time) == 1


def test_saved_log_equals_the_recording(shared_data: Path, tmp_path: Path) -> None:
    log = read_log(shared_data / "logs" / "nominal_short.mcap")
    save_log(log, tmp_path / "copy.mcap", recorded_by="test", notes="copy")
    copy = read_log(tmp_path / "copy.mcap")
    assert copy.rig_text == log.rig_text
    for key in ("top_drive", "draw_works", "mud_pump", "mwd_tool_face"):
        one, other = getattr(log, key), getattr(copy, key)
        np.testing.assert_allclose(other.time, one.time, atol=1e-6)
        np.testing.assert_allclose(other.arrival, one.arrival, atol=1e-6)
        for array in ("position", "velocity", "effort"):
            np.testing.assert_array_equal(getattr(other, array), getattr(one, array))


def test_field_table_equals_the_field_log(shared_data: Path) -> None:
    table = read_table(shared_data / "field" / "well_b_2235m.csv", installed_file("config/import.start_up.yaml"))
    log = read_log(shared_data / "field" / "well_b_2235m.mcap")
    assert table.top_drive is not None and log.top_drive is not None
    np.testing.assert_allclose(table.top_drive.time, log.top_drive.time, atol=1e-6)
    np.testing.assert_allclose(table.top_drive.velocity, log.top_drive.velocity)
    np.testing.assert_allclose(table.top_drive.effort, log.top_drive.effort)


def test_command_imports_slide_of_1_hz_log(shared_data: Path, tmp_path: Path) -> None:
    output = tmp_path / "slide.mcap"
    arguments = [str(shared_data / "rig_1hz" / "SampleData1.csv"), "-o", str(output), "--rows", "30063:30853"]
    arguments += ["--mapping", str(installed_file("config/import.surface_1hz.yaml"))]
    answer = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert answer.exit_code == 0
    log = read_log(output)
    assert log.top_drive is not None and log.draw_works is not None and log.standpipe_pressure is not None
    assert len(log.top_drive.time) == 791
    # A slide: the block goes down by metres, the drive hardly turns, the hook carries tonnes.
    assert 1.0 < log.draw_works.position[-1] < 30.0
    assert 1e5 < np.median(log.draw_works.effort) < 1e6
    assert 1e6 < np.median(log.standpipe_pressure.value) < 4e7


@pytest.mark.parametrize("rows", ["5", "5:", "a:b", "9:3"])
def test_command_refuses_rows(tmp_path: Path, rows: str) -> None:
    table = table_file(tmp_path, "t,torque\n0,1\n1,2\n")
    arguments = [str(table), "--mapping", str(mapping_file(tmp_path)), "-o", str(tmp_path / "o.mcap"), "--rows", rows]
    answer = CliRunner().invoke(command, arguments)
    assert answer.exit_code == 2 or isinstance(answer.exception, InputError)
    assert not (tmp_path / "o.mcap").exists()


def test_command_does_not_overwrite_the_table(tmp_path: Path) -> None:
    table = table_file(tmp_path, "t,torque\n0,1\n")
    answer = CliRunner().invoke(command, [str(table), "--mapping", str(mapping_file(tmp_path)), "-o", str(table)])
    assert isinstance(answer.exception, InputError)
    assert table.read_text() == "t,torque\n0,1\n"


@pytest.mark.parametrize(("units", "shown"), [("si", r"1\.000 to 2\.000 +kN m"), ("field", r"737\.6 to 1475 +ft lbf")])
def test_command_lists_contents_in_chosen_units(tmp_path: Path, units: str, shown: str) -> None:
    table = table_file(tmp_path, "t,torque,tf\n0,1000,-90\n1,2000,45\n")
    channels = {"surface_torque": {"column": "torque", "unit": "N m"}, "tool_face": {"column": "tf", "unit": "deg"}}
    mapping = mapping_file(tmp_path, channels=channels)
    arguments = [str(table), "--mapping", str(mapping), "-o", str(tmp_path / "o.mcap")]
    answer = CliRunner().invoke(command, [*arguments, "--units", units], catch_exceptions=False)
    assert re.search(shown, answer.output)
    assert re.search(r"-90\.00 to 45\.00 +deg", answer.output), "a toolface is in degrees, never in turns"


def test_command_is_in_the_table_of_commands() -> None:
    assert COMMANDS["import"].module == "slider_drilling.commands.import_table"


@pytest.mark.parametrize(("key", "value"), [("time_zone", "Europe/Oslo"), ("start", "2024-05-01"), ("decimal", ",")])
def test_key_in_the_wrong_place_is_told_the_right_one(tmp_path: Path, key: str, value: str) -> None:
    mapping = mapping_file(tmp_path, time={"column": "t", "unit": "s", key: value})
    with pytest.raises(InputError, match=rf"time\.{key}: stands beside time, not in it; write {key} at the top level"):
        read_table(table_file(tmp_path, "t,torque\n0,1\n"), mapping)
