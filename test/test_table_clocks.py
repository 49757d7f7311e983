"""Times of tables: formats, dates, zones, clocks that are set."""

from __future__ import annotations

import datetime
from pathlib import Path

import numpy as np
import pytest
from table_text import written

from slider_drilling.errors import InputError
from slider_drilling.table_import import import_table, read_table


@pytest.mark.parametrize(
    ("first", "second", "step"),
    [
        ("03/14/2026 11:59:59 PM", "03/15/2026 12:00:00 AM", 1.0),
        ("14.03.2026 23:59:59", "15.03.2026 00:00:00", 1.0),
        ("14-Mar-2026 02:10:00", "14-Mar-2026 02:10:00.5", 0.5),
        ("2026/03/14 02:10:00", "2026/03/14 02:10:02", 2.0),
        ("20260314 02:10:00", "20260314 02:10:02", 2.0),
        ("2026-03-14T02:10:00+01:00", "2026-03-14T01:10:02Z", 2.0),
        ("23:59:59", "00:00:01", 2.0),
        ("1773454200", "1773454202", 2.0),
        ("1773454200000", "1773454202000", 2.0),
        ("46095.0", "46095.5", 43200.0),
    ],
)
def test_times(tmp_path: Path, first: str, second: str, step: float) -> None:
    log = read_table(written(tmp_path, f"Time,HKLD (klbf)\n{first},200\n{second},201\n"))
    assert log.draw_works is not None
    np.testing.assert_allclose(np.diff(log.draw_works.time), step, atol=1e-6)


def test_date_in_its_own_column_and_order(tmp_path: Path) -> None:
    text = "Date,Time,HKLD (klbf)\n03/12/2024,23:59:59,200\n03/13/2024,00:00:00,201\n"
    log = read_table(written(tmp_path, text))
    assert datetime.datetime.fromtimestamp(log.start, datetime.timezone.utc).day == 12
    ambiguous = read_table(written(tmp_path, text.replace("03/13", "03/12").replace("00:00:00", "23:59:59.5")))
    assert any("read as MDY" in note for note in ambiguous.notes)


def test_dates_alone_are_no_times(tmp_path: Path) -> None:
    text = "Date,Watch,HKLD (klbf)\n" + "".join(f"2024-03-12,23:59:0{k},20{k}\n" for k in range(4))
    with pytest.raises(InputError, match=r"t\.csv: column 'Date': holds dates without times of day, and repeats them"):
        read_table(written(tmp_path, text))
    log = read_table(written(tmp_path, text.replace("Watch", "Uhrzeit")))
    assert log.draw_works is not None
    np.testing.assert_allclose(log.draw_works.time, [0.0, 1.0, 2.0, 3.0])


def test_times_that_are_coarser_than_the_rows_are_said_to_be(tmp_path: Path) -> None:
    text = "Time,HKLD (klbf)\n" + "".join(f"2024-03-12 23:{k // 60:02},{k}\n" for k in range(240))
    notes = read_table(written(tmp_path, text + ",7\n")).notes
    assert any("236 of 241 rows repeat a time: the last of each is kept; the times are coarser" in one for one in notes)
    assert "1 of 241 rows have no time: left out" in notes


@pytest.mark.parametrize(
    ("times", "length"),
    [
        (("2024-03-31T01:59:59", "2024-03-31T03:00:00"), 1.0),
        (("2024-10-27T02:59:59", "2024-10-27T02:00:00"), 1.0),
        (("2024-10-27T01:59:59", "2024-10-27T02:00:00"), 1.0),
    ],
)
def test_time_zone_undoes_clock_changes(tmp_path: Path, times: tuple[str, str], length: float) -> None:
    text = "Time,HKLD (klbf)\n" + "".join(f"{time},200\n" for time in times)
    log = import_table(written(tmp_path, text), time_zone="Europe/Berlin").log
    assert log.draw_works is not None
    np.testing.assert_allclose(np.diff(log.draw_works.time), length)


def test_clock_set_back_asks_for_the_zone(tmp_path: Path) -> None:
    text = "Time,HKLD (klbf)\n2024-10-27T02:59:59,200\n2024-10-27T02:00:00,200\n"
    with pytest.raises(InputError, match=r"goes back .* give its zone with --time-zone"):
        read_table(written(tmp_path, text))
    with pytest.raises(InputError, match="time_zone = 'Mars/Base': not known"):
        import_table(written(tmp_path, text), time_zone="Mars/Base")


@pytest.mark.parametrize(
    ("zones", "zone"), [(("Z", "+01:00"), ""), (("Z", "+01:00"), "Europe/Berlin"), (("", ""), "Etc/UTC")]
)
def test_zone_that_is_known_is_not_asked_for(tmp_path: Path, zones: tuple[str, str], zone: str) -> None:
    text = f"Time,HKLD (klbf)\n2024-03-31T02:00:00{zones[0]},200\n"
    text += f"2024-03-31T0{2 if zones[1] else 1}:00:01{zones[1]},200\n"
    with pytest.raises(InputError, match="goes back") as caught:
        import_table(written(tmp_path, text), time_zone=zone)
    assert "its zone" not in str(caught.value)
