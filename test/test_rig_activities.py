"""A day is split into what the rig did; slides are found with their ends, depths, wraps and torques."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import slider_drilling as sd
from slider_drilling.cli import group
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import save_log
from slider_drilling.log.rig_log import RigLog
from slider_drilling.log.series import JointSeries, ScalarSeries
from slider_drilling.rig_activities.classify import CONNECTION, KINDS, ROCKING, ROTATING, SLIDING, TRIPPING
from slider_drilling.rig_activities.split import split_day
from slider_drilling.table_import import read_table

BLOCK, STRING = 130e3, 700e3  # N
FLOW = 12.0  # rad/s of the pump
RATE = 0.004  # m/s of penetration
# First and last 0-based row of each slide, from the README of the recording; a row is a second.
SLIDES_1HZ = ((14245, 15583), (24110, 25085), (22231, 23188), (31746, 32689), (27576, 28485), (30063, 30853))


def made_day(signed: bool = True) -> tuple[RigLog, dict[str, tuple[float, float]]]:
    """A stand drilled rotating, a connection, a slide with rocking and one without, a trip of three stands."""
    parts: list[tuple[str, int, float, float, float, float]] = []  # kind, s, block m/s, rpm, pump, hook load

    def add(kind: str, seconds: int, block: float, rpm: float = 0.0, pump: float = FLOW, load: float = STRING) -> None:
        parts.append((kind, seconds, block, rpm, pump, load))

    add("start", 120, 0.0)
    add(ROTATING, 2000, RATE, 60.0)
    add("pick up", 20, -0.2)
    add(CONNECTION, 240, -0.1, 0.0, 0.0, BLOCK)
    add("wash", 40, 0.1)
    add(ROCKING, 1500, RATE, 30.0)
    add("back to bottom", 20, -0.2)
    add("and down", 40, 0.1)
    add(SLIDING, 1200, RATE)
    add("off", 20, -0.2)
    for _ in range(4):
        add(TRIPPING, 60, -0.5, 0.0, 0.0)
        add(TRIPPING, 60, 0.5, 0.0, 0.0, BLOCK)
    rng = np.random.default_rng(5)
    block, rpm, pump, load = ([], [], [], [])
    times, clock = {}, 0.0
    for kind, seconds, speed, turn, flow, weight in parts:
        block += [speed] * seconds
        phase = 2.0 * math.pi * np.arange(seconds) / 12.0
        wave = np.clip(2.0 * np.sin(phase), -1.0, 1.0) if kind == ROCKING else np.ones(seconds)
        rpm += list(turn * wave)
        pump += [flow] * seconds
        load += [weight] * seconds
        first = times.get(kind, (clock, 0.0))[0]
        times[kind] = (first, clock + seconds)
        clock += seconds
    speed = np.array(rpm) * math.pi / 30.0
    if not signed:
        speed = np.abs(speed)
    time = np.arange(len(speed), dtype=float)
    nan = np.full(len(time), np.nan)
    torque = 8e3 + 6e3 * np.tanh(speed) + rng.normal(0.0, 50.0, len(time))
    on_bottom = np.array([value == RATE for value in block])
    pressure = 15e6 * (np.array(pump) > 0.0) + 2e6 * on_bottom + rng.normal(0.0, 1e4, len(time))
    around_180 = np.radians(179.0) * np.sign(time % 2 - 0.5)
    return RigLog(
        source="made", start_ns=0,
        top_drive=JointSeries(time, time, np.cumsum(speed), speed, torque),
        draw_works=JointSeries(time, time, np.cumsum(block), np.array(block), np.array(load)),
        standpipe_pressure=ScalarSeries(time, time, pressure, nan),
        mud_pump=JointSeries(time, time, nan, np.array(pump), nan),
        mwd_tool_face=JointSeries(time, time, around_180, nan, nan),
    ), times  # fmt: skip


@pytest.mark.parametrize("signed", [True, False])
def test_each_second_gets_its_activity(signed: bool) -> None:
    log, times = made_day(signed)
    day = split_day(log)
    for kind in (ROTATING, ROCKING, SLIDING, TRIPPING):
        found = [part for part in day.activities if part.kind == kind]
        first, last = times[kind]
        if kind == TRIPPING:  # begins two stands off bottom
            first += 173.0
        longest = max(found, key=lambda part: part.duration)
        assert longest.start == pytest.approx(first, abs=15.0), kind
        assert sum(part.duration for part in found) == pytest.approx(last - first, abs=60.0), kind
    assert any(part.start == times[CONNECTION][0] for part in day.activities if part.kind == CONNECTION)


def test_activities_follow_without_holes() -> None:
    day = split_day(made_day()[0])
    assert all(before.end == after.start for before, after in zip(day.activities, day.activities[1:], strict=False))
    assert {part.kind for part in day.activities} <= set(KINDS)


def test_slides_have_depth_wraps_and_torques() -> None:
    log, times = made_day()
    rocked, still = split_day(log, start_depth=4000.0).slides
    first, last = map(int, times[ROCKING])
    stroke = np.ptp(log.top_drive.position[first:last])  # type: ignore[union-attr]
    assert rocked.is_rocking and not still.is_rocking
    assert rocked.wraps == pytest.approx(0.5 * stroke, rel=0.05)
    assert rocked.period == pytest.approx(12.0, abs=1.0)
    assert (rocked.torque_right, rocked.torque_left) == pytest.approx((14e3, 2e3), abs=200.0)
    assert rocked.length == pytest.approx(1500 * RATE, abs=0.3) and rocked.rate == pytest.approx(RATE, rel=0.05)
    assert rocked.depth_from == pytest.approx(4000.0 + 2000 * RATE, abs=0.3)
    assert rocked.differential_pressure == pytest.approx(2e6, rel=0.05)
    assert abs(rocked.tool_face) == pytest.approx(math.pi, abs=0.02)  # the mean of +-179 deg is not 0
    assert still.wraps == 0.0


def test_large_turn_of_resting_drive_parts_slides() -> None:
    log, times = made_day()
    assert log.top_drive is not None
    for degrees, slides in ((30.0, 2), (90.0, 3)):
        speed = log.top_drive.velocity.copy()
        at = int(np.mean(times[SLIDING]))
        speed[at : at + 2] = math.radians(degrees) / 2.0
        drive = JointSeries(log.top_drive.time, log.top_drive.time, np.cumsum(speed), speed, log.top_drive.effort)
        turned = RigLog(source="made", start_ns=0, top_drive=drive, draw_works=log.draw_works, mud_pump=log.mud_pump)
        assert len(split_day(turned).slides) == slides


def test_interruption_is_no_activity() -> None:
    log, times = made_day()
    kept = np.ones(len(log.draw_works.time), dtype=bool)  # type: ignore[union-attr]
    middle = int(np.mean(times[ROTATING]))
    kept[middle - 100 : middle + 100] = False
    part = {key: type(series)(*(getattr(series, name)[kept] for name in series.__dataclass_fields__))
            for key, series in log.series().items()}  # fmt: skip
    lost = [each for each in split_day(RigLog(source="made", start_ns=0, **part)).activities
            if each.kind == "not recorded"]  # fmt: skip
    assert len(lost) == 1 and abs(lost[0].start - (middle - 100)) < 5.0 and abs(lost[0].duration - 200.0) < 5.0


@pytest.mark.parametrize("missing", ["draw_works", "top_drive", "pumps"])
def test_missing_channel_is_named(missing: str) -> None:
    held = made_day()[0].series()
    for key in ("mud_pump", "standpipe_pressure") if missing == "pumps" else (missing,):
        del held[key]
    with pytest.raises(InputError, match=r"^made: holds n"):
        split_day(RigLog(source="made", start_ns=0, **held))


def test_recorded_day_has_the_listed_slides(shared_data: Path) -> None:
    table = shared_data / "rig_1hz" / "SampleData1.csv"
    log = read_table(table, installed_file("config/import.surface_1hz.yaml"))
    found = [(slide.start, slide.end) for slide in split_day(log).slides]
    for first, last in SLIDES_1HZ:
        assert any(abs(start - first) <= 30.0 and abs(end - last) <= 30.0 for start, end in found), (first, last, found)


def test_simulated_slide_is_rocking(shared_data: Path) -> None:
    day = sd.activities(shared_data / "logs" / "nominal_base.mcap")
    assert [part.kind for part in day.activities] == [ROCKING]
    assert repr(day) == "ActivitiesResult(1 activities, 0 slides)"


def test_command_writes_page_tables_and_slides(tmp_path: Path) -> None:
    save_log(made_day()[0], tmp_path / "day.mcap", "test")
    arguments = ["activities", str(tmp_path / "day.mcap"), "-o", str(tmp_path / "out"), "--depth", "13500 ft",
                 "--extract", "slide", "--extract", "rotating", "--units", "field"]  # fmt: skip
    result = CliRunner().invoke(group, arguments)
    assert result.exit_code == 0, result.output
    tree = json.loads((tmp_path / "out" / "activities.json").read_text())
    assert len(tree["slides"]) == 2
    assert tree["slides"][0]["depth_from"] == pytest.approx(13500.0 * 0.3048 + 8.0, abs=0.5)
    with (tmp_path / "out" / "slides.csv").open() as lines:
        assert len(list(csv.DictReader(lines))) == 2
    assert "ft lbf" in (tmp_path / "out" / "activities.html").read_text()
    slide = sd.read_log(tmp_path / "out" / "day.slide_01.mcap")
    assert slide.columns().values["time"][-1] == pytest.approx(1500.0, abs=30.0)
    assert (tmp_path / "out" / "day.rotating_01.mcap").exists()


@pytest.mark.parametrize(
    ("option", "value"), [("--depth", "13500"), ("--depth", "13500 psi"), ("--extract", "slides")]
)
def test_unusable_option_is_named(tmp_path: Path, option: str, value: str) -> None:
    result = CliRunner().invoke(group, ["activities", "day.mcap", option, value])
    assert result.exit_code == 2 and value in result.output
