"""Where programmes come from: built-in ones, pages, slide sheets; and `simulate` runs them."""

from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import slider_drilling as sd
from slider_drilling.commands.programme_file import prepare_programme
from slider_drilling.commands.run import command as run_command
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.programmes import (
    MakeConnection,
    Rest,
    Rotate,
    Slide,
    Step,
    dump_programme,
    open_loop_commands,
    parse_programme,
)
from slider_drilling.programmes.find_programme import BUILT_IN, find_programme
from slider_drilling.programmes.rig_check import nominal_times

ROOT = Path(__file__).parents[1]
BUILT_IN_FILE = ROOT / BUILT_IN["commissioning"]
PAGE = (ROOT / "docs/how_to/programmes.md").read_text()
SHEET = "from [ft],to [ft],mode,toolface,rpm\n13123.4,13152.9,rotate,,60\n13152.9,13182.4,slide,-45,\n,,connection,,\n"


@pytest.fixture(scope="module")
def rig() -> sd.Rig:
    return sd.load_rig()


@pytest.mark.parametrize("name", BUILT_IN)
def test_built_in_programmes_fit_the_example_rig(name: str, rig: sd.Rig) -> None:
    found = find_programme(name)
    assert sum(nominal_times(found.programme, rig, name)) > 200.0


def test_mistyped_name_gets_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"comissioning: no such programme; .* one of commissioning, stand"):
        find_programme("comissioning")


@pytest.mark.parametrize("text", re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL))
def test_programmes_of_the_page_fit_the_example_rig(text: str, rig: sd.Rig) -> None:
    nominal_times(parse_programme(text), rig)


def test_slide_sheet_of_the_page_is_read(tmp_path: Path, rig: sd.Rig) -> None:
    (text,) = re.findall(r"```csv\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "page.csv").write_text(text)
    prepared = prepare_programme(str(tmp_path / "page.csv"), rig, tmp_path)
    assert [step.key for step in sd.load_programme(prepared.path).steps] == ["rotate", "slide", "rotate", "connection"]
    assert text == (ROOT / "config/programmes/slide_sheet.csv").read_text()


def test_slide_sheet_is_converted_to_si(tmp_path: Path) -> None:
    (tmp_path / "sheet.csv").write_text(SHEET)
    found = find_programme(tmp_path / "sheet.csv")
    rotate, slide, connection = (step.action for step in found.programme.steps)
    assert isinstance(rotate, Rotate) and isinstance(slide, Slide) and isinstance(connection, MakeConnection)
    assert (rotate.length, rotate.speed) == pytest.approx((8.99, 2.0 * math.pi), abs=0.01)
    assert (slide.length, slide.tool_face) == pytest.approx((8.99, -math.pi / 4.0), abs=0.01)
    assert found.start == pytest.approx(4000.0, abs=0.1)


def test_slide_sheet_of_a_workbook_is_the_same(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl", reason="pip install '.[tables]'")
    (tmp_path / "sheet.csv").write_text(SHEET)
    book = openpyxl.Workbook()
    for row in SHEET.splitlines():
        book.active.append([float(cell) if re.fullmatch(r"-?[\d.]+", cell) else cell for cell in row.split(",")])
    book.save(tmp_path / "sheet.xlsx")
    of_text, of_book = (find_programme(tmp_path / name).programme for name in ("sheet.csv", "sheet.xlsx"))
    assert of_text.steps == of_book.steps


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("13152.9,13182.4", "13160.0,13182.4", "line 3: begins at 4011.17 m, the row above ends at 4009.00 m"),
        ("slide", "drill", "line 3: mode = 'drill': must be rotate, slide or connection"),
        ("-45", "", "line 3: no toolface"),
        ("-45", "400", "must be within -360 to 360"),
        (",60", ",0", "line 2: rpm = 0: must be above 0"),
        ("13182.4", "14182.4", "at most 60 m"),
        ("from [ft]", "from", "has no unit"),
        ("\n,,connection", "\n13182.4,13190,connection", "line 4: to = 4020.31 m: a connection drills nothing"),
    ],
)
def test_bad_slide_sheets_are_refused_by_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "sheet.csv"
    path.write_text(SHEET.replace(old, new))
    with pytest.raises(InputError, match=message):
        find_programme(path)


def test_slide_sheet_of_another_depth_is_refused(tmp_path: Path) -> None:
    (tmp_path / "sheet.csv").write_text(SHEET)
    with pytest.raises(InputError, match=r"begins at 4000.0 m, the bit of the rig file is at 2600.0 m"):
        prepare_programme(str(tmp_path / "sheet.csv"), sd.load_rig("short"), tmp_path)


def test_simulate_runs_and_keeps_the_programme(rig: sd.Rig, tmp_path: Path) -> None:
    programme = sd.Programme((Step(Rest(2.0)), Step(Rotate(6.0, time=4.0))), name="turn")
    run = sd.simulate(rig, programme=programme, elements=20)
    assert run.progress is not None and str(run.progress) == "all 2 steps done"
    assert run.driven_by == "ProgrammeController"
    assert np.ptp(run.commands.top_drive_angle) > 15.0
    kept = read_log(run.save(tmp_path / "run.mcap")).programme_text
    assert kept is not None and parse_programme(kept) == programme
    assert run.summary().tool_face is None


def test_a_programme_has_no_settings() -> None:
    """A setting of the controller that does not run would be ignored."""
    result = CliRunner().invoke(run_command, ["--programme", "commissioning", "--set", "gain=2"])
    assert isinstance(result.exception, InputError)
    assert "--set gain=2: a programme has no settings" in str(result.exception)


def test_simulate_takes_a_drive_or_a_programme(rig: sd.Rig) -> None:
    with pytest.raises(InputError, match="give a drive"):
        sd.simulate(rig)
    with pytest.raises(InputError, match="a programme gives the toolface"):
        sd.simulate(rig, programme="stand", target=1.0)


def test_a_simulated_rig_refuses_a_programme_that_starts_off_bottom(rig: sd.Rig, tmp_path: Path) -> None:
    """The guard of weight would believe the bit off bottom where it is not."""
    programme = dataclasses.replace(sd.load_programme(BUILT_IN_FILE), bit_height=1.2)
    nominal_times(programme, rig)  # a real rig may start so
    path = tmp_path / "high.yaml"
    path.write_text(dump_programme(programme))
    refused = pytest.raises(InputError, match=r"bit_height = 1\.2 m: .* leave it out and begin with a pick_up")
    with refused:
        sd.simulate(rig, programme=programme)
    with refused:
        prepare_programme(str(path), rig, tmp_path)
    with refused:
        open_loop_commands(programme, rig)
