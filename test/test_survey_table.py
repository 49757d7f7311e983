"""Surveys as planners and directional drillers write them."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from slider_drilling.api.rigs import load_rig
from slider_drilling.api.simulate import simulate
from slider_drilling.commands.torque_drag import command
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log.save import save_log
from slider_drilling.wellbore.survey_table import read_survey

SHORT = str(installed_file("config/rig.short.yaml"))
STATIONS = ((0.0, 0.0, 60.0), (914.4, 0.0, 60.0), (1828.8, 90.0, 60.0))


@pytest.mark.parametrize(
    "content",
    [
        "MD (ft),Inc (deg),Azi (deg)\n0,0,60\n3000,0,60\n6000,90,60\n",
        "MD (ft);Inc (°);Azi (°)\n0;0;60\n3000,0;0,0;60,0\n6000,0;90,0;60,0\n",
        "Measured Depth\tIncl\tAzim\nft\tdeg\tdeg\n0\t0\t60\n3000\t0\t60\n6000\t90\t60\n",
        "Well: A-1\nRig: 7\n\nTVD (ft),MD (FT),INC,AZIMUTH\n0,0,0,60\n3000,3000,0,60\n4900,6000,90,60\n",
        "MD [m],Inclination [rad],Azimuth\n0,0,60\n914.4,0,60\n1828.8,1.5707963267948966,60\n",
        'MD (ft),Inc,Azi\n"0.0",0,60\n"3,000.0",0,60\n"6,000.0",90,60\n',
        "Meas. Depth (ft) , Inc. (dega) , Azi. True (dega)\n0, 0, 60\n3000 ft, 0, 60\n6000, 90, 60\n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_tables_of_planners_are_read(tmp_path: Path, content: str, encoding: str) -> None:
    path = tmp_path / "survey.csv"
    path.write_bytes(content.encode(encoding))
    survey = read_survey(path)
    assert survey.stations == tuple(pytest.approx(row, abs=1e-9) for row in STATIONS)
    assert survey.notes == ()


@pytest.mark.parametrize(
    ("depths", "read"),
    [
        (("0,000", "914,400", "1828,800"), 1828.8),
        (("0", "914,4", "1,000"), None),
        (("0,0", "0,500", "1,000"), 1.0),
        (("0", "1,500.0", "2,000"), 2000.0),
    ],
)
def test_commas_of_depths_are_read_as_their_column_shows(
    tmp_path: Path, depths: tuple[str, str, str], read: float | None
) -> None:
    path = tmp_path / "survey.csv"
    path.write_text("MD (m);Inc;Azi\n" + "".join(f"{depth};{k}0.5;60\n" for k, depth in enumerate(depths)))
    if read is None:
        with pytest.raises(InputError, match="must increase"):
            read_survey(path)
    else:
        assert read_survey(path).length == read


@pytest.mark.parametrize("depths", [("0", "1,000", "2,600"), ("0", "500", "1,000"), ("100,000", "200,000", "300,000")])
@pytest.mark.parametrize("angle", ["0,5", "10", "10,123"])
def test_commas_that_could_be_either_are_refused(tmp_path: Path, depths: tuple[str, str, str], angle: str) -> None:
    path = tmp_path / "survey.csv"
    path.write_text("MD (m);Inc;Azi\n" + "".join(f"{depth};{angle};60\n" for depth in depths))
    with pytest.raises(InputError) as error:
        read_survey(path)
    said = str(error.value)
    assert "line " in said and "\n" not in said
    assert "is its comma a decimal one or between thousands? write a decimal point, and nothing between" in said


def test_commas_of_two_kinds_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "survey.csv"
    path.write_text("MD (ft);Inc;Azi\n0;0,5;60\n3,000.0;12,5;60\n6,000.0;90,0;60\n")
    with pytest.raises(InputError, match=r"line 2: Inc = '0,5': not a number; is its comma"):
        read_survey(path)


def test_survey_feet_differ_from_feet(tmp_path: Path) -> None:
    path = tmp_path / "survey.csv"
    path.write_text("MD (usft),Inc (°),Azi (°)\n0,0,0\n9000,90,60\n")
    assert read_survey(path).length == pytest.approx(9000.0 * 1200.0 / 3937.0)


def test_sheet_of_a_book_is_read(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "tally"
    sheet = book.create_sheet("survey")
    for row in (("MD [ft]", "Inc [deg]", "Azi [deg]"), (0, 0, 60), (3000, 0, 60), (6000, 90, 60)):
        sheet.append(row)
    book.save(tmp_path / "well.xlsx")
    assert read_survey(tmp_path / "well.xlsx").stations == tuple(pytest.approx(row, abs=1e-9) for row in STATIONS)


def test_hole_above_a_deep_survey_is_not_made_up(tmp_path: Path, shared_data: Path) -> None:
    deep = shared_data / "found" / "survey_begins_deep" / "lateral.csv"
    if not deep.is_file():
        pytest.skip("no such input")
    with pytest.raises(InputError, match="begins at 1200 m with 40 deg: the hole above it is not known"):
        read_survey(deep)
    nearly = tmp_path / "survey.csv"
    nearly.write_text("MD (m),Inc,Azi\n300,1.5,60\n600,20,60\n")
    survey = read_survey(nearly)
    assert survey.stations[0] == (0.0, 0.0, 60.0)
    assert survey.notes == ("begins at 300 m with 1.5 deg: taken as vertical from the surface to there",)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("MD (m),Inc,Azi,Azi Grid\n0,0,0,0\n10,0,0,0\n", "more than one of MD (m), Inc, Azi, Azi Grid is the azimuth"),
        ("MD (m);Inc;Azi\n0;0;0\n1,000;0;0\n", "is its comma a decimal one"),
        ("MD (m),Inc,Azi\n-10,0,0\n10,0,0\n", "must not be negative"),
        ("MD (m),Inc,Azi\n0,0,0\n10,,0\n", "line 3: Inc = '': not a number"),
        ("MD (m),Inc,Azi\n0,0,0\n10,nan,0\n", "line 3: Inc = 'nan': not a number"),
        ("PK\x03\x04\x00\x00", "neither text nor an XLSX book"),
    ],
)
def test_unclear_surveys_are_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "survey.csv"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_survey(path)
    assert said in str(error.value) and str(path) in str(error.value) and "\n" not in str(error.value)


def outcome(tmp_path: Path, *arguments: str) -> tuple[list[str], str]:
    """Notes of the JSON answer on what belongs together, and stderr."""
    words = [*arguments, "-o", str(tmp_path / "out"), "--elements", "20", "--friction", "0.2", "--json"]
    result = CliRunner().invoke(command, words, catch_exceptions=False)
    notes = json.loads(result.stdout)["notes"]
    return [note for note in notes if "friction" not in note], result.stderr


def test_example_well_is_named(tmp_path: Path) -> None:
    notes, printed = outcome(tmp_path)
    assert notes == ["no rig file: this is the example well, not yours; give yours with --rig"]
    assert notes[0] in printed
    assert outcome(tmp_path, "--rig", SHORT)[0] == []


def test_survey_on_the_examples_string_is_named(tmp_path: Path) -> None:
    path = tmp_path / "survey.csv"
    path.write_text("MD (m),Inc,Azi\n0,0,0\n2000,0,0\n3000,90,0\n5000,90,0\n")
    notes, _ = outcome(tmp_path, "--survey", str(path))
    assert "string, mud, hole and casing are the example well's, not those of survey.csv" in notes[0]
    assert notes[1] == "survey.csv reaches 5000 m, the example well's string 4000 m: the chart ends there"
    path.write_text("MD (m),Inc,Azi\n0,0,0\n2000,90,0\n")
    notes, _ = outcome(tmp_path, "--survey", str(path))
    assert notes[1] == "survey.csv ends at 2000 m: the example well's string of 4000 m was cut to that"
    with pytest.raises(InputError, match="ends at 2000 m, but the rig file's string reaches 2600 m; give a rig file"):
        outcome(tmp_path, "--survey", str(path), "--rig", SHORT)


@pytest.mark.parametrize("last", ["8530.1 ft", "2599.9996 m", "2599.95 m"])
def test_string_is_cut_to_a_rounded_survey(tmp_path: Path, last: str) -> None:
    """Depths in tenths of feet, and a string whose length is in metres."""
    depth, unit = last.split()
    path = tmp_path / "survey.csv"
    path.write_text(f"MD ({unit}),Inc,Azi\n0,0,0\n{0.5 * float(depth):g},0,0\n{depth},90,0\n")
    (note,), _ = outcome(tmp_path, "--survey", str(path), "--rig", SHORT)
    assert "the rig file's string of 2600 m was cut to that" in note and "ends at 2600 m" not in note


def test_a_metre_that_is_missing_is_refused_with_its_decimals(tmp_path: Path) -> None:
    path = tmp_path / "survey.csv"
    path.write_text("MD (m),Inc,Azi\n0,0,0\n1300,0,0\n2599.73,90,0\n")
    with pytest.raises(InputError, match=r"ends at 2599\.73 m, but the rig file's string reaches 2600 m"):
        outcome(tmp_path, "--survey", str(path), "--rig", SHORT)


def test_log_of_another_well_is_named(tmp_path: Path) -> None:
    log = simulate(load_rig("short"), "slider_drilling.control:SlideController", 5.0, elements=20).log
    own, stranger = tmp_path / "own.mcap", tmp_path / "stranger.mcap"
    save_log(log, own, "a recorder")
    save_log(dataclasses.replace(log, rig_text=None), stranger, "a recorder")
    assert outcome(tmp_path, "--log", str(own))[0] == []
    notes, _ = outcome(tmp_path, "--log", str(stranger))
    assert "has no rig file: its points are drawn on the example well" in notes[0]
    assert "its bit is at 2600 m, the rig's string reaches 4000 m" in notes[1]


def test_hook_load_of_another_string_is_named(tmp_path: Path) -> None:
    log = simulate(load_rig("short"), "slider_drilling.control:SlideController", 5.0, elements=20).log
    heavier = dataclasses.replace(log.draw_works, effort=log.draw_works.effort + 6e5)
    save_log(dataclasses.replace(log, draw_works=heavier), tmp_path / "log.mcap", "a recorder")
    (note,) = outcome(tmp_path, "--log", str(tmp_path / "log.mcap"))[0]
    assert "another string, or the block's weight is in it" in note
