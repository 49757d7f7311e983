"""From papers to a rig file: sizes and names as written, tables, tally, defaults, and the whole way."""

from __future__ import annotations

import json
import math
import warnings
from pathlib import Path

import pytest
from click.testing import CliRunner

import slider_drilling as sd
from slider_drilling.commands.rig import command
from slider_drilling.errors import InputError
from slider_drilling.rig import load_rig
from slider_drilling.rig_papers.build import build_rig
from slider_drilling.rig_papers.defaults import mean_friction
from slider_drilling.rig_papers.equipment import MOTORS, TOP_DRIVES, find_by_name
from slider_drilling.rig_papers.equipment_tables import EQUIPMENT_TABLES
from slider_drilling.rig_papers.sheet import (
    read_circulating_pressure,
    read_motor,
    read_mud,
    read_pump,
    read_size,
    read_top_drive,
)
from slider_drilling.rig_papers.tally import read_tally
from slider_drilling.rig_papers.tubulars import (
    CONNECTIONS,
    DRILL_PIPE,
    adjusted_weight,
    make_up_torque,
    premium_outer_diameter,
    tool_joint_yield,
    torsional_yield,
)
from slider_drilling.wellbore.static_loads import static_loads

PSI, FOOT, FOOT_POUND, GALLON = 6894.757293168, 0.3048, 1.3558179483314, 3.785411784e-3
SHEET = {
    "mud": "9.6ppg OBM", "motor": "0.28rev/gal, 6600ft-lbf @ 1100psi, stall 9900ft-lbf", "pump": "4.2gal/stk",
    "top_drive": "45000 ft-lbf, 180 rpm", "circulating_pressure": "3000psi@500gpm", "casing_shoe": "2000ft",
}  # fmt: skip
SURVEY = "MD [ft],Inc [deg],Azi [deg]\n0,0,0\n2000,0,0\n3000,60,10\n4000,90,10\n6000,90,10\n"
TALLY = """\
Item,Description,OD (in),ID (in),Weight (lb/ft),Length (ft),Cum (ft)
1,8 1/2 PDC bit,8.5,,,1.0,1.0
2,6 3/4 motor,6.75,,96,30,31.0
3,NMDC w/ MWD,6.75,2.81,104,59,90.0
4,5 in HWDP,5,3.0,49.3,600,690.0
5,5 in 19.50# S-135 NC50,5,4.276,21.9,5310,6000.0
"""


@pytest.fixture
def papers(tmp_path: Path) -> tuple[Path, Path]:
    (tmp_path / "survey.csv").write_text(SURVEY)
    (tmp_path / "tally.csv").write_text(TALLY)
    return tmp_path / "survey.csv", tmp_path / "tally.csv"


@pytest.mark.parametrize(
    ("connection", "outer", "inner", "published"),
    [("NC50", 6.375, 3.5, 44673), ("NC50", 6.625, 2.75, 63406), ("NC38", 5.0, 2.125, 26515),
     ("NC26", 3.375, 1.75, 6875)],
)  # fmt: skip
def test_tool_joints_yield_as_published(connection: str, outer: float, inner: float, published: float) -> None:
    assert tool_joint_yield(CONNECTIONS[connection], outer, inner) == pytest.approx(published, rel=2e-3)


@pytest.mark.parametrize(
    ("outer", "inner", "strength", "published"),
    [(5.0, 4.276, 135e3, 74100), (3.5, 2.764, 75e3, 18551), (6.625, 5.901, 135e3, 137330), (4.5, 3.826, 95e3, 39022)],
)
def test_pipe_bodies_yield_as_published(outer: float, inner: float, strength: float, published: float) -> None:
    assert torsional_yield(outer, inner, strength) == pytest.approx(published, rel=1e-3)


def test_premium_pipe_yields_as_published() -> None:
    assert torsional_yield(premium_outer_diameter(5.0, 4.276), 4.276, 135e3) == pytest.approx(58100, rel=1e-3)


def test_adjusted_weights_as_published() -> None:
    by_name = {(pipe.outer_diameter, pipe.nominal_weight): pipe for pipe in DRILL_PIPE}
    assert adjusted_weight(by_name[5.0, 19.5], "S") == pytest.approx(22.6, rel=0.02)
    assert make_up_torque(CONNECTIONS["NC50"], 6.375, 3.5) == pytest.approx(26800, rel=1e-3)
    for pipe in DRILL_PIPE:
        assert 1.0 < adjusted_weight(pipe, "E") / pipe.nominal_weight < 1.12


@pytest.mark.parametrize(
    ("text", "name"),
    [("6 3/4 7/8 5.0", "6.75 in 7/8 5.0"), ("6.75in 7:8 lobe 5.0 stage", "6.75 in 7/8 5.0"), ("8 7/8", "8 in 7/8 4.0"),
     ("9 5/8 4/5", "9.625 in 4/5 6.0")],
)  # fmt: skip
def test_motors_are_found_by_name(text: str, name: str) -> None:
    assert find_by_name(text, MOTORS, "motor").name == name


def test_ambiguous_names_list_their_rows() -> None:
    with pytest.raises(InputError, match=r"fits several; one of 6.75 in 4/5 4.8, 6.75 in 7/8 3.0, 6.75 in 7/8 5.0"):
        find_by_name("6 3/4", MOTORS, "motor")
    with pytest.raises(InputError, match="not in the table; one of NOV TDS-8SA"):
        find_by_name("TDS-99", TOP_DRIVES, "top_drive")


def test_sheets_are_read_as_written() -> None:
    assert read_mud("9.6 ppg OBM").density == pytest.approx(1150.33, abs=0.01) and read_mud("9.6ppg OBM").base == "oil"
    assert read_mud("1.25 sg water based mud").base == "water"
    assert read_size("8 1/2 in PDC", "bit") == pytest.approx(0.2159) == read_size("215.9 mm", "bit")
    motor = read_motor("0.28 rev/gal, 1100 psi, 6600 ft.lbf, stall 9900 ft-lb")
    assert motor.stall_pressure == pytest.approx(1650 * PSI) and motor.max_pressure == pytest.approx(1100 * PSI)
    assert motor.displacement == pytest.approx(GALLON / 0.28)
    assert read_pump("0.1 bbl/stk").stroke_volume == pytest.approx(4.2 * GALLON)
    triplex = read_pump("6 in x 12 in triplex")
    assert triplex.stroke_volume == pytest.approx(0.96 * 4.406 * GALLON, rel=1e-3) and not triplex.measured
    assert read_pump("12-P-160 6 in").stroke_volume == pytest.approx(triplex.stroke_volume)
    assert read_top_drive("TDS-11SA")[0] == pytest.approx(37500 * FOOT_POUND)
    assert read_circulating_pressure("207 bar @ 1890 L/min") == pytest.approx((207e5, 1.89 / 60.0))


@pytest.mark.parametrize(
    ("read", "text", "said"),
    [
        (read_mud, "9.6 kg/m3", "9.6 kg/m3 is no drilling mud; is it 9.6 lb/gal?"),
        (read_mud, "9.6", "has no unit; is it 9.6 lb/gal?"),
        (read_mud, "1150", "has no unit; is it 1150 kg/m3?"),
        (read_mud, "9.6 psi", "is a unit of pressure"),
        (read_motor, "0.28 rev/gal", r"max_differential (1100 psi): missing"),
        (read_motor, "0.28 rev/gal, 1100 psi, 6600 ft-lbf, stall 600 psi", "are they swapped?"),
        (read_motor, "some motor", "not in the table"),
        (read_motor, "absent.csv", "absent.csv: no such motor"),
        (read_pump, "4.2 gal", "give the volume per stroke"),
        (read_pump, "60 in x 12 in", "no mud pump's"),
        (read_top_drive, "45000 ft-lbf", "give torque and speed"),
        (read_circulating_pressure, "3000 psi", "give pressure and flow"),
        (read_circulating_pressure, "3,000 psi @ 500 gpm", "is the comma within a number a decimal one?"),
    ],
)
def test_unclear_sheets_are_refused(read: object, text: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        read(text)  # type: ignore[operator]
    assert said in str(error.value) and "\n" not in str(error.value)


def test_tally_becomes_sections(papers: tuple[Path, Path]) -> None:
    tally = read_tally(papers[1])
    names = [section.name for section in tally.sections]
    assert names == ["5 in 19.50# S-135 NC50", "5 in HWDP", "bottom-hole assembly"]
    assert math.fsum(section.length for section in tally.sections) == pytest.approx(6000 * FOOT)
    pipe, heavy, assembly = tally.sections
    assert pipe.weight_per_length == pytest.approx(21.9 * 14.5939, rel=1e-5)
    assert pipe.torsional_yield == pytest.approx(74100 * FOOT_POUND, rel=1e-3)
    assert heavy.make_up_torque == pytest.approx(make_up_torque(CONNECTIONS["NC50"], 6.5, 3.0625) * FOOT_POUND)
    assert assembly.length == pytest.approx(90 * FOOT)
    assert assembly.weight_per_length == pytest.approx((31 * 96 + 59 * 104) / 90 * 14.5939, rel=1e-5)
    assert tally.bit_diameter == pytest.approx(0.2159)


def test_tally_from_the_surface_down_is_the_same(papers: tuple[Path, Path]) -> None:
    head, *items = TALLY.replace(",Cum (ft)", "").splitlines()
    expected = read_tally(papers[1])
    papers[1].write_text("\n".join([head, *reversed([line.rsplit(",", 1)[0] for line in items])]))
    assert read_tally(papers[1]).sections == expected.sections


@pytest.mark.parametrize("name", ["5 in 19.50# S-135 NC50", "5 in 19.50# S-135 NC50, joint {}"])
def test_equal_joints_are_one_section(papers: tuple[Path, Path], name: str) -> None:
    before = read_tally(papers[1]).sections
    lines = TALLY.splitlines()
    lengths = [30.0 + 0.1 * (k % 5) for k in range(175)]
    lengths.append(5310.0 - sum(lengths))
    joints = [f"{5 + k},{name.format(k).replace(',', ' ')},5,4.276,21.9,{length:.3f},"
              for k, length in enumerate(lengths)]  # fmt: skip
    papers[1].write_text("\n".join([*lines[:-1], *joints]) + "\n")
    tally = read_tally(papers[1])
    assert [section.length for section in tally.sections] == pytest.approx([section.length for section in before])
    assert tally.sections[1:] == before[1:] and tally.sections[0].make_up_torque == before[0].make_up_torque
    assert any(note.startswith("176 equal items are one section of 1618.5 m") for note in tally.notes)
    assert len(tally.notes) < 10


def test_joints_of_another_weight_are_another_section(papers: tuple[Path, Path]) -> None:
    papers[1].write_text(TALLY.replace("5,5 in 19.50# S-135 NC50,5,4.276,21.9,5310,6000.0",
                                       "5,5 in 19.50# S-135 NC50,5,4.276,21.9,2000,\n"
                                       "6,5 in 19.50# S-135 NC50,5,4.276,22.5,3310,"))  # fmt: skip
    assert len(read_tally(papers[1]).sections) == 4


def test_tables_fill_in_what_a_tally_lacks(tmp_path: Path) -> None:
    path = tmp_path / "tally.csv"
    path.write_text("Description,Length [m]\n8 1/2 in PDC bit,0.3\n6 3/4 in motor,9\n6 3/4 in NMDC,18\n"
                    "5 in HWDP,180\n5 in 19.5# G-105 NC50 DP,1800\n")  # fmt: skip
    tally = read_tally(path, 26800 * FOOT_POUND)
    pipe, heavy, _ = tally.sections
    assert pipe.inner_diameter == pytest.approx(4.276 * 0.0254)
    assert pipe.weight_per_length == pytest.approx(21.93 * 14.5939, rel=0.01)
    assert pipe.make_up_torque == pytest.approx(26800 * FOOT_POUND)
    assert heavy.weight_per_length == pytest.approx(49.3 * 14.5939, rel=1e-5)
    assert any("weight with tool joints" in note for note in tally.notes)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("8 1/2 PDC bit", "thing"), "neither the first nor the last item is a bit"),
        (("5310", "5410"), "line 6: lengths add up to"),
        (("59,90", "-59,90"), "must be above 0"),
        (("104", "1040"), None),
        ((",96,", ",960,"), "more than a solid steel bar"),
        (("Length (ft)", "Length"), "has no unit"),
        (("Description", "What"), "none of Item, What"),
    ],
)
def test_impossible_tallies_are_refused(papers: tuple[Path, Path], change: tuple[str, str], said: str | None) -> None:
    assert change[0] in TALLY
    papers[1].write_text(TALLY.replace(*change))
    if said is None:
        assert read_tally(papers[1]).sections[-1].weight_per_length > 3e3
        return
    with pytest.raises(InputError) as error:
        read_tally(papers[1])
    assert said in str(error.value) and "\n" not in str(error.value)


def test_everything_assumed_has_spread_and_reason(papers: tuple[Path, Path]) -> None:
    rig = build_rig(*papers, SHEET).rig
    assert len(rig.assumed) >= 20
    assert all(item.spread > 0.0 and item.why for item in rig.assumed)
    cased, open_hole = rig.well.friction_intervals
    assert cased.to == pytest.approx(2000 * FOOT)
    assert open_hole.factor == pytest.approx(0.21 / mean_friction(), abs=0.01)
    on_papers = ("motor.stall", "motor.torque", "mud.density", "mud_pump")
    assert not any(item.key.startswith(on_papers) for item in rig.assumed)


def test_motor_of_the_table_is_assumed(papers: tuple[Path, Path]) -> None:
    rig = build_rig(*papers, SHEET | {"motor": "6 3/4 7/8 5.0", "pump": "6in x 12in", "casing_shoe": "0 ft"}).rig
    keys = {item.key for item in rig.assumed}
    assert {"motor.torque_per_pressure", "motor.max_pressure", "motor.stall_pressure", "motor.leak",
            "mud_pump.displacement", "well.friction_intervals[0].factor"} <= keys  # fmt: skip
    assert len(rig.well.friction_intervals) == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mud": ""}, "rig new: missing: --mud '9.6 ppg OBM'"),
        ({"casing_shoe": "7000 ft"}, "casing_shoe = '7000 ft': not above the bit"),
        ({"bit": "12 1/4 in"}, "bit = '12 1/4 in': the tally has one of 0.2159 m"),
        ({"circulating_pressure": "3000 gpm @ 500 psi", "top_drive": "x"}, "top_drive = 'x': not in the table"),
    ],
)
def test_papers_that_contradict_are_refused(papers: tuple[Path, Path], change: dict[str, str], said: str) -> None:
    with pytest.raises(InputError) as error:
        build_rig(*papers, SHEET | change)
    assert said in str(error.value)


def test_survey_is_kept_to_the_bit(papers: tuple[Path, Path]) -> None:
    papers[0].write_text(SURVEY.replace("6000,90", "5940,90"))
    made = build_rig(*papers, SHEET)
    assert made.rig.well.survey[-1] == pytest.approx((6000 * FOOT, 90.0, 10.0))
    assert any("ends 18.3 m above the bit" in note for note in made.notes)
    papers[0].write_text(SURVEY.replace("6000,90", "5000,90"))
    with pytest.raises(InputError, match=r"ends at 1524 m, the string of the tally reaches 1828\.8 m"):
        build_rig(*papers, SHEET)


def run(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(command, list(arguments), catch_exceptions=False)
    return result.exit_code, result.stdout, result.stderr


def options(papers: tuple[Path, Path]) -> list[str]:
    given = [word for name, text in SHEET.items() for word in (f"--{name.replace('_', '-')}", text)]
    return ["new", "--survey", str(papers[0]), "--tally", str(papers[1]), *given]


def test_command_writes_a_rig_that_reads_back(papers: tuple[Path, Path], tmp_path: Path) -> None:
    output = tmp_path / "rig.yaml"
    code, printed, _ = run(*options(papers), "-o", str(output), "--units", "field")
    assert code == 0 and "string.weight_factor" in printed and "numbers are on no paper" in printed
    assert load_rig(output) == build_rig(*papers, SHEET).rig
    code, printed, _ = run(*options(papers), "-o", str(output), "--json")
    assert {row["key"] for row in json.loads(printed)["assumed"]} == {item.key for item in load_rig(output).assumed}


def test_templates_are_read_when_filled_in(papers: tuple[Path, Path], tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    folder = tmp_path / "papers"
    assert run("new", "--template", str(folder), "--units", "field")[0] == 0
    assert {path.name for path in folder.iterdir()} == {"survey.csv", "tally.csv", "sheet.csv", "rig_papers.xlsx"}
    with pytest.raises(InputError, match="exists already"):
        run("new", "--template", str(folder))
    book = openpyxl.load_workbook(folder / "rig_papers.xlsx")
    for line in SURVEY.splitlines()[1:]:
        book["survey"].append([float(cell) for cell in line.split(",")])
    for line in TALLY.splitlines()[1:]:
        _, name, outer, inner, weight, length, _ = line.split(",")
        book["tally"].append([name, float(length), float(outer), inner and float(inner), weight and float(weight)])
    for row in book["sheet"].iter_rows(min_row=2):
        row[1].value = SHEET.get(row[0].value)
    book.save(folder / "rig_papers.xlsx")
    path = folder / "rig_papers.xlsx"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert sd.new_rig(path, path, path) == sd.new_rig(*papers, **SHEET)


def test_questions_are_asked_until_answered(papers: tuple[Path, Path], tmp_path: Path) -> None:
    answers = ["absent.csv", str(papers[0]), str(papers[1]), "", "9.6", "9.6 ppg OBM", SHEET["motor"], SHEET["pump"],
               SHEET["top_drive"], SHEET["circulating_pressure"], "", "", SHEET["casing_shoe"], "", ""]  # fmt: skip
    output = tmp_path / "rig.yaml"
    result = CliRunner().invoke(command, ["new", "--ask", "-o", str(output)], input="\n".join(answers) + "\n")
    assert result.exit_code == 0, result.output
    assert "is it 9.6 lb/gal?" in result.stderr and "absent.csv: no such survey" in result.stderr
    assert load_rig(output) == build_rig(*papers, SHEET).rig


def test_tables_name_their_sources() -> None:
    code, printed, _ = run("tables")
    assert code == 0
    for words in ("API RP 7G (1998)", "API Spec 5DP (2009)", "PowerPak", "2004", "TDS-11SA technical bulletin, 1998"):
        assert words in printed
    assert printed.count("compared with published text") == len(EQUIPMENT_TABLES)
    assert "drill-pipe" not in run("tables", "motors")[1]


def test_paper_well_hangs_as_its_driller_says(shared_data: Path) -> None:
    folder = shared_data / "paper_well"
    if not folder.is_dir():
        pytest.skip("no such papers")
    rig = build_rig(folder / "survey.csv", folder / "tally.csv", SHEET | {"casing_shoe": "6200 ft"}).rig
    klbf, block = 4448.2216, 62.0
    up, down, turning = (static_loads(rig, *speeds) for speeds in ((-1.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
    for loads, driller in ((up, 260.0), (down, 121.0), (turning, 193.0)):
        assert loads.hook_load / klbf + block == pytest.approx(driller, rel=0.1)
    assert turning.surface_torque / FOOT_POUND == pytest.approx(7000.0, rel=0.25)


def test_new_rig_simulates(papers: tuple[Path, Path]) -> None:
    rig = build_rig(*papers, SHEET).rig
    run = sd.simulate(rig, "slider_drilling.control:SlideController", 60.0, elements=40)
    assert abs(float(run.response.hook_load[-1])) < 1e6 and float(run.response.standpipe_pressure[-1]) > 1e7
