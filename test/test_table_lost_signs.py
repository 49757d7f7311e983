"""Speeds and torques whose recorder dropped the sign: it comes back from the rocking, or is asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from table_text import written

from slider_drilling.errors import InputError
from slider_drilling.log import read_log
from slider_drilling.table_import import read_table
from slider_drilling.table_import.rocking_signs import looks_unsigned, signed_by


def rocking(seconds: float = 200.0) -> tuple[np.ndarray, np.ndarray]:
    """Speed of a rocking drive and the torque of the string that it winds up, once a second."""
    time = np.arange(seconds)
    speed = 8.0 * np.tanh(3.0 * np.sin(2.0 * np.pi * time / 14.3))
    return speed, np.cumsum(speed) * 300.0 - 200.0 * np.sin(time)


@pytest.mark.parametrize("of_speed", [True, False])
def test_signs_come_back_from_the_rocking(of_speed: bool) -> None:
    speed, torque = rocking()
    torque = torque - torque.mean()
    lost, other = (speed, torque) if of_speed else (torque, speed)
    assert looks_unsigned(np.abs(lost), other, of_speed) and not looks_unsigned(lost, other, of_speed)
    found = signed_by(np.abs(lost), other, of_speed, "t")
    large = np.abs(lost) > 0.3 * np.abs(lost).max()
    assert np.mean(np.sign(found[large]) == np.sign(lost[large])) > 0.97


def test_torque_that_keeps_one_sign_has_lost_none() -> None:
    speed, torque = rocking()
    assert not looks_unsigned(torque - 1.01 * torque.min(), speed, of_speed=False)


@pytest.mark.parametrize("lost", ["RPM", "TQ"])
def test_lost_signs_of_the_paper_well_come_back(shared_data: Path, tmp_path: Path, lost: str) -> None:
    whole = (shared_data / "paper_well" / "edr.csv").read_text().splitlines()
    place = whole[0].split(",").index(lost)
    rows = [line.split(",") for line in whole]
    without = [",".join(cell.lstrip("-") if k == place else cell for k, cell in enumerate(row)) for row in rows]
    table = written(tmp_path, "\n".join(without) + "\n")
    true, found = read_table(shared_data / "paper_well" / "edr.csv").top_drive, read_table(table).top_drive
    assert true is not None and found is not None
    array = "velocity" if lost == "RPM" else "effort"
    expected, restored = getattr(true, array), getattr(found, array)
    large = np.abs(expected) > 0.2 * np.abs(expected).max()
    np.testing.assert_allclose(restored[large], expected[large])


@pytest.mark.parametrize("of_speed", [True, False])
def test_lost_signs_of_a_10_hz_log_come_back(shared_data: Path, of_speed: bool) -> None:
    drive = read_log(shared_data / "logs" / "blind_4.mcap").top_drive
    assert drive is not None
    lost, other = (drive.velocity, drive.effort) if of_speed else (drive.effort, drive.velocity)
    found = signed_by(np.abs(lost), other, of_speed, "t", interval=0.1)
    large = np.abs(lost) > 0.2 * np.nanmax(np.abs(lost))
    assert np.mean(np.sign(found[large]) == np.sign(lost[large])) > 0.99


def test_signs_that_nothing_tells_are_refused(tmp_path: Path) -> None:
    speed, torque = (np.abs(part) for part in rocking())
    rows = "".join(f"{k},{v * 9.55:.2f},{q:.0f}\n" for k, (v, q) in enumerate(zip(speed, torque, strict=True)))
    with pytest.raises(InputError, match="has no sign, and torque does not tell it"):
        read_table(written(tmp_path, "Time (s),RPM,TQ (ft-lbf)\n" + rows))
