"""Cells and heads of a table that can be read in two ways are refused or said, never guessed in silence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from slider_drilling.errors import InputError
from slider_drilling.table_import import read_table

MAPPING = """schema: slider_drilling/csv/1
time: {{column: Time, unit: {time}}}
{more}
channels:
  surface_torque: {{column: Torque, unit: kN m}}
"""


def torques(folder: Path, text: str, more: str = "", time: str = "s", unit: str = "kN m") -> np.ndarray:
    (folder / "m.yaml").write_text(MAPPING.format(time=time, more=more).replace("kN m", unit))
    (folder / "t.csv").write_text(text)
    log = read_table(folder / "t.csv", folder / "m.yaml")
    assert log.top_drive is not None
    return log.top_drive.effort / 1000.0


@pytest.mark.parametrize("cells", [
    ("8,1", "1.234", "8,3"), ("1.234", "8,2", "8,3"), ("8,1", "-1.234", "8,3"),
])  # fmt: skip
def test_a_point_among_decimal_commas_is_refused(tmp_path: Path, cells: tuple[str, ...]) -> None:
    text = "Time;Torque\n" + "".join(f"{k};{cell}\n" for k, cell in enumerate(cells))
    with pytest.raises(InputError, match=r"line \d: column 'Torque' = '.*': is its point .* set decimal"):
        torques(tmp_path, text)


def test_points_in_another_column_are_refused(tmp_path: Path) -> None:
    text = "Time;Torque\n" + "".join(f"{k},5;1.23{k}\n" for k in range(4))
    with pytest.raises(InputError, match=r"line 2: column 'Torque' = '1\.230': is its point a decimal mark"):
        torques(tmp_path, text)


@pytest.mark.parametrize(("cell", "value"), [("1.234", 1234.0), ("1.234,5", 1234.5), ("8,25", 8.25), ("12", 12.0)])
def test_a_decimal_mark_that_is_set_decides(tmp_path: Path, cell: str, value: float) -> None:
    values = torques(tmp_path, f"Time;Torque\n0;{cell}\n1;{cell}\n", "decimal: ','", unit="N m")
    np.testing.assert_allclose(values * 1000.0, value)


def test_two_decimals_behind_a_point_leave_no_doubt(tmp_path: Path) -> None:
    np.testing.assert_allclose(torques(tmp_path, "Time;Torque\n0;8,1\n1;8.25\n2;0.125\n"), [8.1, 8.25, 0.125])


@pytest.mark.parametrize(("text", "values"), [
    ("Time\tTorque\n0.5\t8,125\n1.5\t9,250\n", [8125.0, 9250.0]),  # points elsewhere: commas part thousands
    ("Time;Torque\n0.5;8,125\n1.5;9,250\n", [8125.0, 9250.0]),
    ("Time\tTorque\n0\t8,125\n1\t0,009,250\n", [8125.0, 9250.0]),
    ("Time\tTorque\n0,5\t8,125\n1,5\t9,250\n", [8.125, 9.25]),
    ('Time,Torque\n"0,5","8,125"\n"1,5","9,250"\n', [8.125, 9.25]),  # decimal commas elsewhere
    ('Time,Torque\n0,"8,125"\n1,"0,250"\n', [8.125, 0.25]),
    ('Time,Torque\n0,"8,125"\n1,"9,250"\n', [8125.0, 9250.0]),
    ("Time;Torque\n0;8,125\n1;9,250\n", [8.125, 9.25]),
])  # fmt: skip
def test_other_cells_tell_what_a_comma_before_three_digits_is(tmp_path: Path, text: str, values: list[float]) -> None:
    np.testing.assert_allclose(torques(tmp_path, text, unit="N m") * 1000.0, values)


@pytest.mark.parametrize("text", [
    "Time\tTorque\n0\t8,125\n1\t9,250\n", "Time|Torque\n0|8,125\n1|9,250\n", "Time\tTorque\n0,5\t8,125\n1.5\t9,250\n",
])  # fmt: skip
def test_a_comma_before_three_digits_is_refused_where_nothing_tells(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match=r"line 2: column 'Torque' = '8,125': is its comma .* set decimal"):
        torques(tmp_path, text)
    assert torques(tmp_path, text.replace("0,5", "0.5"), "decimal: '.'", unit="N m")[0] == pytest.approx(8.125)


def test_a_declared_null_does_not_tell_the_decimal_mark(tmp_path: Path) -> None:
    text = "Time\tTorque\n0\t-999.25\n1\t8,125\n"
    with pytest.raises(InputError, match="is its comma a decimal mark"):
        torques(tmp_path, text)


@pytest.mark.parametrize("cell", ["8_1", "1_000.5", "_8", "8__1"])
def test_an_underscore_is_no_part_of_a_number(tmp_path: Path, cell: str) -> None:
    with pytest.raises(InputError, match=rf"line 3: column 'Torque' = '{cell}': not a number"):
        torques(tmp_path, f"Time,Torque\n0,8\n1,{cell}\n")


def test_times_with_and_without_a_zone_are_refused(tmp_path: Path) -> None:
    text = "Time,Torque\n2024-10-27T02:58:00+02:00,8\n2024-10-27T02:59:00,8\n2024-10-27T03:00:00+02:00,8\n"
    with pytest.raises(InputError, match=r"line 3: column 'Time' = '.*': names no zone, others do; give it with"):
        torques(tmp_path, text, time="iso8601")
    assert torques(tmp_path, text, "time_zone: Europe/Berlin", "iso8601").size == 3


@pytest.mark.parametrize("head", ["Time,Torque\ns,kft lbf\n", "Time (s),Torque (kft lbf)\n", "Time,Torque [ft-lbf]\n"])
def test_a_unit_that_contradicts_the_table_is_noted(tmp_path: Path, head: str) -> None:
    names = head.splitlines()[0].split(",")
    (tmp_path / "m.yaml").write_text(MAPPING.format(time="s", more="").replace("Time", names[0]).replace(
        "column: Torque", f"column: {names[1]!r}"))  # fmt: skip
    (tmp_path / "t.csv").write_text(head + "0,8\n1,8.5\n")
    notes = read_table(tmp_path / "t.csv", tmp_path / "m.yaml").notes
    assert any("the table says" in note and "the mapping kN m" in note for note in notes)


@pytest.mark.parametrize("head", ["Time,Torque\ns,kN.m\n", "Time,Torque\ns,KNM\n", "Time,Torque\ns,\n"])
def test_other_spellings_of_the_same_unit_agree(tmp_path: Path, head: str) -> None:
    (tmp_path / "m.yaml").write_text(MAPPING.format(time="s", more=""))
    (tmp_path / "t.csv").write_text(head + "0,8\n1,8.5\n")
    assert read_table(tmp_path / "t.csv", tmp_path / "m.yaml").notes == ()


def test_marks_of_thousands_are_said_as_they_are(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(MAPPING.format(time="s", more=""))
    (tmp_path / "t.csv").write_text("Time;Torque\n0;1'408\n1;1'409\n")
    assert any("marks between thousands" in note for note in read_table(tmp_path / "t.csv", tmp_path / "m.yaml").notes)


@pytest.mark.parametrize("head", ["Torque (-)", "Torque [ ]", "Torque (--)"])
def test_a_head_without_a_unit_asks_for_it(tmp_path: Path, head: str) -> None:
    (tmp_path / "t.csv").write_text(f"Time (s),{head}\n0,8\n1,8.5\n")
    with pytest.raises(InputError, match=r"\(surface_torque\): no unit in the table; add --unit"):
        read_table(tmp_path / "t.csv")
