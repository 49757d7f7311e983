"""Tables of recorders without a mapping file: formats, encodings, nulls, and what is refused."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from table_text import hook, written

from slider_drilling.commands.import_table import command
from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.null_values import without_undeclared_nulls
from slider_drilling.table_import import import_table, read_table
from slider_drilling.table_import.integrate import integrate

FTLBF = 1.3558179483314004
HEAD = "Time,HKLD,TQ,RPM\n,klbf,ft-lbf,rpm\n"
START = datetime.datetime(2026, 3, 14, 2, 10)


def lines(count: int = 5) -> str:
    stamps = [(START + datetime.timedelta(seconds=k)).isoformat() for k in range(count)]
    return "".join(f"{stamp},{200 + k},6000,40\n" for k, stamp in enumerate(stamps))


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_delimiters_and_encodings(tmp_path: Path, delimiter: str, encoding: str) -> None:
    text = ("Well: Groß 3\n" + HEAD + lines()).replace(",", delimiter)
    np.testing.assert_allclose(hook(read_table(written(tmp_path, text, encoding))), [200, 201, 202, 203, 204])


@pytest.mark.parametrize(
    ("cell", "value"), [("200,5", 200.5), ("1.200,5", 1200.5), ("200", 200.0), ("8,125", 8.125), ("1 200,5", 1200.5)]
)
def test_decimal_commas(tmp_path: Path, cell: str, value: float) -> None:
    text = f"Time;HKLD [klbf]\n2024-03-12T14:58:00;{cell}\n2024-03-12T14:58:01;{cell}\n"
    np.testing.assert_allclose(hook(read_table(written(tmp_path, text))), value)


def test_thousands_in_quotes(tmp_path: Path) -> None:
    log = read_table(written(tmp_path, 'Time (s),TQ (ft-lbf)\n0,"6,417"\n1,"16,417.5"\n'))
    assert log.top_drive is not None
    np.testing.assert_allclose(log.top_drive.effort / FTLBF, [6417, 16417.5])


@pytest.mark.parametrize("null", [-999.25, -999.0, -9999.0, -99999.0, 9999.0, -32768.0, 1e30])
def test_undeclared_nulls_are_found(null: float) -> None:
    values = np.r_[np.linspace(190, 210, 50), null, np.linspace(190, 210, 50), null]
    kept, found = without_undeclared_nulls(values, positive=True)
    assert found == ((null, 2),) and np.flatnonzero(np.isnan(kept)).tolist() == [50, 101]


@pytest.mark.parametrize("values", [np.linspace(900, 1100, 201), np.r_[np.zeros(50), np.full(50, 999.0)]])
def test_readings_that_look_like_nulls_stay(values: np.ndarray) -> None:
    assert without_undeclared_nulls(values, positive=True)[1] == ()


@pytest.mark.parametrize(
    ("odd", "found"),
    [((-1.0,) * 2, 0), ((-1.0,) * 5, 5), ((-1.0, -1.1, -1.0, -0.9, -1.0, -1.0, -1.0, -1.0), 0), ((1e9, 1e9), 2)],
)
def test_unusual_nulls_need_repeats(odd: tuple[float, ...], found: int) -> None:
    """Two readings of -1 are a sensor's zero; five, with nothing near them, are a null."""
    values = np.r_[200.0 + np.random.default_rng(0).normal(size=500), odd]
    assert sum(count for _, count in without_undeclared_nulls(values, positive=True)[1]) == found


@pytest.mark.parametrize("word", ["#N/A", "NULL", "Bad Input", "---", "n/a", "I/O Timeout"])
def test_nulls_in_words(tmp_path: Path, word: str) -> None:
    log = read_table(written(tmp_path, f"Time (s),HKLD (klbf)\n0,200\n1,{word}\n2,202\n"))
    np.testing.assert_allclose(hook(log), [200, 202])


def test_ragged_rows(tmp_path: Path) -> None:
    log = read_table(written(tmp_path, "Time (s),HKLD (klbf),TQ (ft-lbf)\n0,200,1,\n1,201\n2,202,3,,\n"))
    assert log.top_drive is not None
    np.testing.assert_allclose(log.top_drive.effort / FTLBF, [1, 3])
    with pytest.raises(InputError, match="line 2: 4 cells where 3 columns"):
        read_table(written(tmp_path, "Time (s),HKLD (klbf),TQ (ft-lbf)\n0,200,1,7\n"))


def test_last_line_that_breaks_off_is_left_out(tmp_path: Path) -> None:
    log = read_table(written(tmp_path, "Time,HKLD (klbf)\n2024-03-12 14:58:00,200\n2024-03-12 14:58:01,201\n2024-0"))
    np.testing.assert_allclose(hook(log), [200, 201])
    assert "line 4 breaks off: left out" in log.notes


def test_equal_heads_with_equal_values_are_one(tmp_path: Path) -> None:
    text = "Time (s),HKLD,HKLD\n,klbf,klbf\n0,200,200\n1,201,{}\n"
    np.testing.assert_allclose(hook(read_table(written(tmp_path, text.format(201)))), [200, 201])
    unequal = written(tmp_path, text.format(7))
    with pytest.raises(InputError, match=r"2 such columns .*, write 'HKLD \(1\)' for the first, 'HKLD \(2\)' for "):
        read_table(unequal)
    for name, values in (("HKLD (1)", [200, 201]), ("HKLD (2)", [200, 7])):
        mapping = f"""schema: slider_drilling/csv/1
time: {{column: Time (s), unit: s}}
channels:
  hook_load: {{column: {name}, unit: klbf}}
"""
        np.testing.assert_allclose(hook(read_table(unequal, written(tmp_path, mapping, name="m.yaml"))), values)


@pytest.mark.parametrize(
    ("units", "rows"),
    [
        ("klbf,kN", ("200,889.6", "210,934.1")),
        ("kN,klbf", ("889.6443,200", "934.1265,210")),
        ("klbf,kN", ("200,890", ",", "210,934")),
        ("klbf,kdaN", ("200.0,88.96", "-999.25,-999.25", "210.0,93.41")),
    ],
)
def test_equal_heads_with_equal_quantities_are_one(tmp_path: Path, units: str, rows: tuple[str, ...]) -> None:
    body = "".join(f"{second},{row}\n" for second, row in enumerate(rows))
    log = read_table(written(tmp_path, f"Time (s),HKLD,HKLD\n,{units}\n{body}"))
    np.testing.assert_allclose(hook(log), [200, 210], rtol=1e-4)
    first, other = units.split(",")
    assert f"'HKLD' is there in {first} and in {other} with equal values: that in {first} is used" in log.notes


@pytest.mark.parametrize("rows", [("200,889.6", "210,938.6"), ("200,889.6", ",934.1"), ("200,200", "210,210")])
def test_equal_heads_with_other_quantities_are_refused(tmp_path: Path, rows: tuple[str, ...]) -> None:
    body = "".join(f"{second},{row}\n" for second, row in enumerate(rows))
    with pytest.raises(InputError, match="2 such columns"):
        read_table(written(tmp_path, f"Time (s),HKLD,HKLD\n,klbf,kN\n{body}"))


GERMAN = "Datum;Uhrzeit;Hakenlast [kN];Drehmoment [kNm];{};Drehzahl [1/min];{};Hubzahl;{};Teufe [m];Bitandruck [kN]\n"


@pytest.mark.parametrize(
    "names",
    [("Standrohrdruck [bar]", "Blockposition [m]", "Meißelteufe [m]"),
     ("Pumpendruck (bar)", "Blockhöhe (m)", "Bohrmeißelteufe (m)"),
     ("SPUELUNGSDRUCK [bar]", "BLOCKHOEHE [m]", "Meisseltiefe [m]")],
)  # fmt: skip
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_german_heads_are_known(tmp_path: Path, names: tuple[str, ...], encoding: str) -> None:
    body = "".join(f"03.04.2024;14:58:0{k};890,5;8,2;210,5;60;{20 - k},5;80;2510,5;2600,0;45,5\n" for k in range(4))
    log = read_table(written(tmp_path, GERMAN.format(*names) + body, encoding))
    top_drive, block, pump, pressure, bit = (
        log.top_drive, log.draw_works, log.mud_pump, log.standpipe_pressure, log.bit_depth
    )  # fmt: skip
    assert top_drive is not None and block is not None and pump is not None and bit is not None
    assert pressure is not None
    np.testing.assert_allclose(top_drive.effort, 8200.0)
    np.testing.assert_allclose(top_drive.velocity, 2.0 * np.pi)
    np.testing.assert_allclose(block.effort, 890.5e3)
    np.testing.assert_allclose(block.position, [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(pump.velocity, 80 * 2.0 * np.pi / 60.0)
    np.testing.assert_allclose(pressure.value, 210.5e5)
    np.testing.assert_allclose(bit.position, 2510.5)


def test_german_pumps_are_added_up(tmp_path: Path) -> None:
    log = read_table(written(tmp_path, "Zeit [s];Pumpe 1 [1/min];Hubzahl Pumpe 2\n0;40;30\n1;40;30\n"))
    assert log.mud_pump is not None
    np.testing.assert_allclose(log.mud_pump.velocity, 70 * 2.0 * np.pi / 60.0)


def test_a_unit_of_one_letter_ends_the_head_of_a_channel(tmp_path: Path) -> None:
    log = read_table(written(tmp_path, "time_s,hook_load_N,block_position_m,bit_depth_f\n0,200,10,1\n1,201,9,2\n"))
    assert log.draw_works is not None and log.bit_depth is not None
    np.testing.assert_allclose(log.draw_works.position, [0.0, 1.0])
    np.testing.assert_allclose(log.draw_works.effort, [200.0, 201.0])
    np.testing.assert_allclose(log.bit_depth.position, [0.3048, 0.6096])


def test_times_of_day_of_a_workbook_pass_midnight(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (["Time", "HKLD (klbf)"], [datetime.time(23, 59, 59), 200], [datetime.time(0, 0, 1), 201]):
        book.active.append(row)
    book.save(tmp_path / "t.xlsx")
    log = read_table(tmp_path / "t.xlsx")
    assert log.draw_works is not None
    np.testing.assert_allclose(log.draw_works.time, [0.0, 2.0])
    assert "the times have no date: counted from 1970-01-01; give the first row's with start" in log.notes


def test_a_unit_that_is_not_known_does_not_drop_its_column_in_silence(tmp_path: Path) -> None:
    table = written(tmp_path, "Time (s),HKLD (klbf),RPM (umdr./min),Weight (x)\n0,200,30,1\n1,201,60,2\n")
    (note,) = [note for note in read_table(table).notes if "not used" in note]
    assert note.startswith("'RPM (umdr./min)' is not used: 'umdr./min' is not a known unit of angular speed; if it is ")
    log = import_table(table, units={"RPM (umdr./min)": "rpm"}).log
    assert log.top_drive is not None
    np.testing.assert_allclose(log.top_drive.velocity, [np.pi, 2.0 * np.pi])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Time (s),HKLD\n0,200\n", r"column 'HKLD' \(hook_load\): no unit in the table; add --unit 'HKLD=UNIT'"),
        ("Time (s),HKLD (psi)\n0,200\n", "unit 'psi': not a known unit of force"),
        ("Time (s),Gamma\n0,200\n", "no column is a channel of a rig"),
        ("Depth (m),HKLD (klbf)\n0,200\n", "no column of times"),
        ("0.97,44.3,34\n1.8,44.3,35\n", "has no heads"),
        ("", "is empty"),
        ("Time (s),HKLD (klbf)\n0,abc\n", "line 2: column 'HKLD .klbf.' = 'abc': not a number"),
        ("Time,HKLD (klbf)\nyesterday,1\n", "line 2: column 'Time' = 'yesterday': not a time"),
    ],
)
def test_what_cannot_be_recognised_gets_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as error:
        read_table(written(tmp_path, text))
    assert "\n" not in str(error.value)


def test_pumps_are_added_up(tmp_path: Path) -> None:
    log = read_table(written(tmp_path, "Time (s),SPM1,SPM2,SPM3\n0,60,50,0\n1,60,50,10\n"))
    assert log.mud_pump is not None
    np.testing.assert_allclose(log.mud_pump.velocity * 30.0 / np.pi, [110, 120])


def test_tare_offset_and_abs(tmp_path: Path) -> None:
    mapping = written(tmp_path, """\
schema: slider_drilling/csv/1
time: {column: t, unit: s}
channels:
  hook_load: {column: h, unit: klbf, tare: 62}
  surface_torque: {column: q, unit: ft lbf, abs: true, offset: 10}
""", name="m.yaml")  # fmt: skip
    log = read_table(written(tmp_path, "t,h,q\n0,262,-100\n1,263,200\n"), mapping)
    assert log.top_drive is not None
    np.testing.assert_allclose(hook(log), [200, 201])
    np.testing.assert_allclose(log.top_drive.effort / FTLBF, [110, 210])


def test_saved_mapping_reads_the_same(tmp_path: Path) -> None:
    table = written(tmp_path, HEAD + lines())
    saved, log, again = tmp_path / "m.yaml", tmp_path / "a.mcap", tmp_path / "b.mcap"
    first = CliRunner().invoke(command, [str(table), "-o", str(log), "--save-mapping", str(saved)])
    second = CliRunner().invoke(command, [str(table), "-o", str(again), "--mapping", str(saved)])
    assert first.exit_code == second.exit_code == 0
    np.testing.assert_array_equal(hook(read_log(log)), hook(read_log(again)))


def test_no_integral_over_a_gap() -> None:
    time = np.r_[np.arange(60.0), 3600.0 + np.arange(60.0)]
    integral = integrate(np.full(120, 8.0), time)
    assert integral.gaps == 1 and integral.in_gaps == pytest.approx(3541.0)
    assert integral.values[60] == integral.values[59] and integral.values[-1] == pytest.approx(8.0 * 118.0)


def test_speed_that_no_rig_has_does_not_turn_the_angle(tmp_path: Path) -> None:
    text = "Time (s),RPM\n" + "".join(f"{k},{40 if k not in (20, 70) else -12345 - k}\n" for k in range(100))
    log = read_table(written(tmp_path, text))
    assert log.top_drive is not None
    np.testing.assert_allclose(np.nanmax(log.top_drive.position), 40.0 * np.pi / 30.0 * 99.0, rtol=1e-6)
    assert np.nanmin(log.top_drive.velocity) > 0.0


def test_gap_and_integral_are_kept_in_the_log(tmp_path: Path) -> None:
    text = "Time (s),RPM\n" + "".join(f"{k if k < 50 else k + 900},40\n" for k in range(100))
    output = tmp_path / "o.mcap"
    assert CliRunner().invoke(command, [str(written(tmp_path, text)), "-o", str(output)]).exit_code == 0
    record = read_log(output).imported
    assert record is not None and record.integrated["top_drive_angle"].gaps == 1
    assert "stands still over a gap" in dict(record.checks)["integrated"]


def test_las_2_and_3(tmp_path: Path) -> None:
    two = ("~V\nVERS. 2.0 :\nWRAP. NO :\n~W\nNULL. -9999 :\n~C\nTIME.DD/MM/YYYY-HH:MM:SS :\nHKLA.KLB : \n~A\n"
           "12/03/2024-14:58:00 200\n12/03/2024-14:58:01 -9999\n12/03/2024-14:58:02 202\n")  # fmt: skip
    log = read_table(written(tmp_path, two, name="t.las"))
    np.testing.assert_allclose(hook(log), [200, 202])
    assert datetime.datetime.fromtimestamp(log.start, datetime.timezone.utc).month == 3
    three = ("~Version\nVERS. 3.0 :\nWRAP. NO :\nDLM. COMMA :\n~Well\nNULL. -999.25 :\n~Log_Definition\nTIME.S :\n"
             "HKLA.klbf :\n~Log_Data | Log_Definition\n0,200\n1,-999.25\n2,202\n")  # fmt: skip
    np.testing.assert_allclose(hook(read_table(written(tmp_path, three, name="t.las"))), [200, 202])
    with pytest.raises(InputError, match="is a log by depth"):
        read_table(written(tmp_path, two.replace("TIME.DD/MM/YYYY-HH:MM:SS", "DEPT.M"), name="t.las"))


def test_workbook_with_dates_and_units_row(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (["Well 3H"], ["Date", "Time", "HKLD"], [None, None, "klbf"]):
        book.active.append(row)
    for k in range(3):
        moment = START + datetime.timedelta(seconds=k)
        book.active.append([moment.date(), moment.time(), 200 + k])
    book.save(tmp_path / "t.xlsx")
    log = read_table(tmp_path / "t.xlsx")
    np.testing.assert_allclose(hook(log), [200, 201, 202])
    assert log.start == START.replace(tzinfo=datetime.timezone.utc).timestamp()


def test_parquet(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    stamps = pyarrow.array([START + datetime.timedelta(seconds=k) for k in range(3)], pyarrow.timestamp("us"))
    parquet.write_table(pyarrow.table({"timestamp": stamps, "HKLA (klbf)": [200, None, 202]}), tmp_path / "t.parquet")
    np.testing.assert_allclose(hook(read_table(tmp_path / "t.parquet")), [200, 202])


WITSML_1 = """<?xml version="1.0"?><logs xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1"><log>
<indexType>date time</indexType><nullValue>-9999</nullValue><logData><mnemonicList>TIME,HKLA</mnemonicList>
<unitList>unitless,1000 lbf</unitList><data>2024-03-12T14:58:00Z,200</data><data>2024-03-12T14:58:01Z,-9999</data>
<data>2024-03-12T14:58:02Z,202</data></logData></log></logs>"""
WITSML_2 = """<?xml version="1.0"?><Log xmlns="http://www.energistics.org/energyml/data/witsmlv2"><ChannelSet><Index>
<IndexKind>date time</IndexKind><Mnemonic>Time</Mnemonic></Index><Channel><Mnemonic>HKLA</Mnemonic><Uom>klbf</Uom>
</Channel><Data><Data>[[["2024-03-12T14:58:00Z"],[200]],[["2024-03-12T14:58:01Z"],[null]],
[["2024-03-12T14:58:02Z"],[202]]]</Data></Data></ChannelSet></Log>"""


@pytest.mark.parametrize("text", [WITSML_1, WITSML_2])
def test_witsml(tmp_path: Path, text: str) -> None:
    np.testing.assert_allclose(hook(read_table(written(tmp_path, text, name="t.xml"))), [200, 202])
    with pytest.raises(InputError, match="cannot read this XML"):
        read_table(written(tmp_path, text[:-20], name="t.xml"))


def test_found_nulls_and_gaps(shared_data: Path) -> None:
    folder = shared_data / "found" / "null_not_declared"
    log = read_table(folder / "t.csv", folder / "m.yaml")
    np.testing.assert_allclose(hook(log)[np.isfinite(hook(log))], 205.0)
    assert log.top_drive is not None and np.nanmax(np.abs(log.top_drive.position)) == 0.0
    assert "'hook': -9999, once, is no value of a rig: taken as null; declare it in null_values" in log.notes
    folder = shared_data / "found" / "angle_integrated_over_gap"
    log = read_table(folder / "t.csv", folder / "m.yaml")
    assert log.top_drive is not None and np.nanmax(np.abs(log.top_drive.position)) < 8.0
    assert any("stands still over a gap of 3601 s" in note for note in log.notes)
    assert any("the clock goes ahead by an hour at 2024-03-31 01:59:59" in note for note in log.notes)
    zoned = import_table(folder / "t.csv", folder / "m.yaml", time_zone="Europe/Berlin").log
    assert zoned.imported is not None and zoned.imported.integrated["top_drive_angle"].gaps == 0


@pytest.mark.parametrize(
    ("name", "mapping", "torque"),
    [(f"{name}.csv", "plain.yaml", (8100, 8200)) for name in
     ("ampm", "cp1252", "date_and_time", "ragged", "utf16")]
    + [("text_null.csv", "plain.yaml", (8100, 8200)), ("semicolon_comma.csv", "semicolon.yaml", (8100, 8200)),
       ("time.las", "las.yaml", (8100, 8200)), ("time.las", "", (8100, 8200)),
       ("rig.wits", "", (8100, 8200))],
)  # fmt: skip
def test_found_formats(shared_data: Path, name: str, mapping: str, torque: tuple[float, float]) -> None:
    folder = shared_data / "found" / "missing_table_formats"
    log = import_table(folder / name, folder / mapping if mapping else None, wits_units="metric").log
    assert log.top_drive is not None
    known = log.top_drive.effort[np.isfinite(log.top_drive.effort)]
    np.testing.assert_allclose(known, torque)


def test_well_of_the_paper_in_one_command(shared_data: Path, tmp_path: Path) -> None:
    output = tmp_path / "edr.mcap"
    table = shared_data / "paper_well" / "edr.csv"
    assert CliRunner().invoke(command, [str(table), "-o", str(output)], catch_exceptions=False).exit_code == 0
    log = read_log(output)
    assert set(log.series()) == {"top_drive", "draw_works", "standpipe_pressure", "mud_pump", "mwd_tool_face"}
    assert log.draw_works is not None and hook(log)[0] == pytest.approx(194.9)
    assert log.top_drive is not None and log.top_drive.effort[0] == pytest.approx(6417 * FTLBF)


@pytest.mark.parametrize("null", ["-32768", "-9999", "-999", "32767"])
@pytest.mark.parametrize("alone", [False, True])
def test_null_of_one_column_is_a_null_of_all(tmp_path: Path, null: str, alone: bool) -> None:
    """A torque in ft lbf reads thousands: only the other columns show what the number is."""
    size = 0.1 if alone else 1.0  # a null that is the torque's alone must at least lie outside its readings
    rows = [[f"{size * 20000.0 * np.sin(0.3 * k):.1f}", f"{200.0 + np.sin(k):.2f}"] for k in range(100)]
    rows[30] = [null, null]
    rows[60][0 if alone else 1] = null
    text = "Time (s),TORQUE (ft.lbf),HKLD (klbf)\n" + "".join(f"{k},{a},{b}\n" for k, (a, b) in enumerate(rows))
    log = import_table(written(tmp_path, text)).log
    assert log.top_drive is not None and log.draw_works is not None
    assert np.nanmax(np.abs(log.top_drive.effort)) < 20001.0 * 1.356
    assert np.isnan(log.top_drive.effort[log.top_drive.time == 30.0]).all()
    assert np.isnan(log.draw_works.effort[log.draw_works.time == 30.0]).all()
    assert any(note.startswith("'TORQUE (ft.lbf)': ") and "taken as null" in note for note in log.notes)


def test_reading_that_another_column_has_as_null_stays(tmp_path: Path) -> None:
    """An angle of 9999 deg in a row of its own is a reading."""
    cells = [(9990 + k, 200.0 + np.sin(k)) for k in range(40)]
    text = "Time (s),ANGLE (deg),HKLD (klbf)\n" + "".join(
        f"{k},{a},{9999 if k == 20 else b:.8g}\n" for k, (a, b) in enumerate(cells)
    )
    mapping = tmp_path / "m.yaml"
    mapping.write_text(
        "schema: slider_drilling/csv/1\ntime: {column: Time (s), unit: s}\nchannels:\n"
        "  top_drive_angle: {column: ANGLE (deg), unit: deg}\n  hook_load: {column: HKLD (klbf), unit: klbf}\n"
    )
    log = read_table(written(tmp_path, text), mapping)
    assert log.top_drive is not None and np.isfinite(log.top_drive.position).all()
