"""Numbers, names and tables that no rig and no experiment has: left out with a note or refused in one line."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from slider_drilling.cli import group
from slider_drilling.contact.measured_friction import read_measured
from slider_drilling.errors import InputError
from slider_drilling.log import LogWriter, RigLog, read_log
from slider_drilling.messages.topics import TOPICS
from slider_drilling.table_import import read_table

MAPPING = """\
schema: slider_drilling/csv/1
time: {column: t, unit: s}
channels: {surface_torque: {column: torque, unit: N m}}
"""


def write(path: Path, torque: float) -> Path:
    with LogWriter(path, recorded_by="caf\udce9") as writer:
        for k in range(40):
            writer.joint_state("top_drive/joint_states", 0.1 * k, "top_drive", 0.1, 0.0, torque if k == 7 else 5e3)
    return path


@pytest.mark.parametrize("wild", [1e30, -1e308, float("inf"), 1.1e9, 9.1e5, -9.1e5])
def test_impossible_value_is_masked_and_noted(tmp_path: Path, wild: float) -> None:
    log = read_log(write(tmp_path / "run.mcap", wild))
    assert log.top_drive is not None
    assert np.flatnonzero(np.isnan(log.top_drive.effort)).tolist() == [7]
    (note,) = log.notes
    assert note.startswith("surface_torque: 1 of 40 values outside -500 to 500 kN m, which no rig has: left out")
    assert note.endswith("at 0.7 s")


@pytest.mark.filterwarnings("error")
def test_many_infinite_values_are_left_out_without_a_warning(tmp_path: Path) -> None:
    values = [np.inf if k % 9 == 0 else 4e5 + 1e3 * k for k in range(200)]
    log = write_hook_load(tmp_path / "run.mcap", values)
    assert log.draw_works is not None and np.count_nonzero(np.isnan(log.draw_works.effort)) == 23


def write_hook_load(path: Path, values: list[float]) -> RigLog:
    with LogWriter(path) as writer:
        for k, value in enumerate(values):
            writer.joint_state("draw_works/joint_states", 0.1 * k, "block", 0.1, 0.0, value)
    return read_log(path)


def test_a_null_throughout_is_not_used(tmp_path: Path) -> None:
    log = write_hook_load(tmp_path / "run.mcap", [-9999 * 4448.22] * 40)
    assert log.draw_works is not None and np.isnan(log.draw_works.effort).all()
    assert log.notes == (
        "hook_load: 40 of 40 values outside -500 to 20000 kN, which no rig has: left out; "
        "the first is -44478 kN at 0.0 s",
    )


def test_a_channel_in_another_unit_is_kept_and_said(tmp_path: Path) -> None:
    log = write_hook_load(tmp_path / "run.mcap", [9e8 + 1e6 * k for k in range(40)])
    assert log.draw_works is not None and np.isfinite(log.draw_works.effort).all()
    (note,) = log.notes
    assert note.startswith("hook_load: 40 of 40 values outside -500 to 20000 kN") and "in another unit" in note


@pytest.mark.parametrize("null", [-999.25, -9999.0, -999.0])
def test_nulls_in_oilfield_units_are_not_used(tmp_path: Path, null: float) -> None:
    """In klbf, psi and strokes a minute, between readings."""
    with LogWriter(tmp_path / "run.mcap") as writer:
        for k in range(40):
            is_null = k % 9 == 4
            hook, pressure, strokes = (null, null, null) if is_null else (200.0, 3000.0, 100.0)
            writer.joint_state("draw_works/joint_states", float(k), "block", 0.1, 0.0, hook * 4448.22)
            writer.fluid_pressure("standpipe_pressure", float(k), pressure * 6894.76)
            writer.joint_state("mud_pump/joint_states", float(k), "mud_pump", None, strokes * 0.10472, None)
    log = read_log(tmp_path / "run.mcap")
    assert log.draw_works is not None and log.standpipe_pressure is not None and log.mud_pump is not None
    for values in (log.draw_works.effort, log.standpipe_pressure.value, log.mud_pump.velocity):
        assert np.flatnonzero(np.isnan(values)).tolist() == [4, 13, 22, 31]


def test_every_measured_quantity_has_a_range() -> None:
    """But angles, which grow without end."""
    without = [quantity.column for topic in TOPICS.values() if topic.is_measured for quantity in topic.quantities
               if quantity.import_name and not np.isfinite(quantity.physical_range).all()]  # fmt: skip
    assert without == ["top_drive_angle"]


def test_a_name_that_is_not_utf_8_is_shown_by_its_bytes(tmp_path: Path) -> None:
    log = read_log(write(tmp_path / "caf\udce9.mcap", 1.0))
    assert log.source.endswith("caf\\udce9.mcap")
    assert log.metadata["recorded_by"] == "caf\\udce9"


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("1700000000000,1\n1700000000100,2\n", r"time.unit = 's': times would end in the year 55841; are they in ms"),
        ("1e300,1\n", "times would end in the year"),
        ('0,1\n1,"1\n' + "2,3\n" * 40_000, "line 3: .*; is a quote opened there"),
        ("0,1\n1,1e400\n", None),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_gets_one_line(tmp_path: Path, rows: str, said: str | None) -> None:
    (tmp_path / "t.csv").write_text(f"t,torque\n{rows}")
    (tmp_path / "m.yaml").write_text(MAPPING)
    if said is None:
        read_table(tmp_path / "t.csv", tmp_path / "m.yaml")
        return
    with pytest.raises(InputError, match=said) as error:
        read_table(tmp_path / "t.csv", tmp_path / "m.yaml")
    assert "\n" not in str(error.value) and len(str(error.value)) < 400


HEAD = "feed_m_per_s,vibration_m_per_s,frequency_hz,normal_force_n,friction_n\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + "0.01,0.1,10,1000,0\n" * 9, "friction_n is zero throughout: there is no friction to identify"),
        (HEAD + "0.01,0.1,10,1e300,200\n", r"line 2: normal_force_n is beyond 1e\+08"),
        (HEAD + "0.01,0.1,10,1000,1e308\n", r"line 2: friction_n is beyond 1e\+08"),
        (HEAD.replace("\n", ",friction_n\n") + "1,1,1,1,1,1\n", "friction_n: given twice"),
        (HEAD + '0.01,0.1,10,1000,"1\n' + "2,3\n" * 40_000, "not a CSV table: field larger"),
    ],
)  # fmt: skip
def test_friction_that_nothing_measures_gets_one_line(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "data.csv").write_text(text)
    with pytest.raises(InputError, match=said):
        read_measured(tmp_path / "data.csv")
    with pytest.raises(InputError, match="Is a directory"):
        read_measured(tmp_path)


@pytest.mark.parametrize(
    "options", ["--shape-factor 1e308", "--height-um 1e308", "--height-um nan", "--shear-factor 2"]
)
def test_a_contact_held_beyond_its_range_is_refused(tmp_path: Path, options: str) -> None:
    (tmp_path / "data.csv").write_text(HEAD + "0.01,0.1,10,1000,200\n" * 9)
    with pytest.raises(InputError, match=r"identify: contact held: .* = "):
        group.main(["identify", str(tmp_path / "data.csv"), "-o", str(tmp_path / "o"), *options.split()],
                   standalone_mode=False)  # fmt: skip


def test_notes_that_are_not_text_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--notes: not UTF-8 text"):
        group.main(["import", "t.csv", "--mapping", "m.yaml", "-o", str(tmp_path / "o.mcap"), "--notes", "caf\udce9"],
                   standalone_mode=False)  # fmt: skip


@pytest.mark.parametrize(("samples", "channels"), [(1, ("torque",)), (19, ("torque",)), (500, ())])
def test_a_share_that_leaves_too_little_to_fit_is_refused(samples: int, channels: tuple[str, ...]) -> None:
    from slider_drilling.diagnosis.diagnose import _first_share

    run = SimpleNamespace(time=np.arange(samples), channels=channels)
    model = SimpleNamespace(truncated=lambda share: SimpleNamespace(runs=(run,)))
    with pytest.raises(InputError, match=rf"^until 1e-09: leaves {samples} samples of run.mcap; give a larger share"):
        _first_share(model, 1e-9, ["run.mcap"])  # type: ignore[arg-type]
