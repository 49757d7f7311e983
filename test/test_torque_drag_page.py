"""The broomstick against closed forms, a log's points on it, and paths from tables."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from slider_drilling.analysis.torque_drag import hook_load_chart, log_points, torque_drag_page
from slider_drilling.commands.torque_drag import command
from slider_drilling.commands.torque_drag_rig import charted_rig
from slider_drilling.errors import InputError
from slider_drilling.files.installed_files import installed_file
from slider_drilling.log import LogWriter, RigLog, read_log
from slider_drilling.log.series import JointSeries
from slider_drilling.pages import page_html
from slider_drilling.rig import Rig, load_rig
from slider_drilling.units import FIELD
from slider_drilling.wellbore.broomstick import broomstick, with_bit_at
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.survey_table import read_survey

GRAVITY = 9.81


@pytest.fixture(scope="module")
def rig() -> Rig:
    return load_rig(installed_file("config/rig.example.yaml"))


def test_vertical_hole_has_no_drag(rig: Rig) -> None:
    """Down to 1500 m the example is vertical: the string's buoyed weight, and no torque."""
    found = broomstick(rig, 0.3, [500.0, 1500.0])
    pipe, bha = rig.string.sections
    area = [math.pi / 4.0 * (one.outer_diameter**2 - one.inner_diameter**2) for one in (pipe, bha)]
    weight = GRAVITY * (rig.string.density - rig.mud.density) * (area[0] * (1500.0 - bha.length) + area[1] * bha.length)
    for loads in (found.pick_up, found.slack_off, found.rotating):
        assert loads[1] == pytest.approx(weight, rel=1e-9)
    assert found.torque == pytest.approx([0.0, 0.0], abs=1e-6)


def test_horizontal_pipe_adds_drag_per_metre(rig: Rig) -> None:
    """From 3000 to 4000 m pipe follows into open hole of 90 deg, where the side force is the pipe's weight."""
    friction = 0.25
    found = broomstick(rig, friction, [3000.0, 4000.0])
    pipe = rig.string.sections[0]
    area = math.pi / 4.0 * (pipe.outer_diameter**2 - pipe.inner_diameter**2)
    drag = friction * GRAVITY * (rig.string.density - rig.mud.density) * area * 1000.0
    assert found.torque[1] - found.torque[0] == pytest.approx(drag * pipe.outer_diameter / 2.0, rel=1e-3)
    # Lowered, the bend's drag falls with the tension that the horizontal pipe takes; raised, it grows.
    assert found.slack_off[1] < found.slack_off[0] - drag * 0.6
    assert found.pick_up[1] > found.pick_up[0] + drag
    assert found.rotating[1] == pytest.approx(found.rotating[0], rel=1e-9)


def test_total_depth_uses_the_whole_string(rig: Rig) -> None:
    found = broomstick(rig, None, [4000.0])
    assert found.slack_off[0] == static_loads(rig, 1.0).hook_load
    assert with_bit_at(rig, 4000.0).string == rig.string


def test_string_may_be_shorter_than_bha(rig: Rig) -> None:
    (left,) = with_bit_at(rig, 20.0).string.sections
    assert left.name == "bottom-hole assembly" and left.length == 20.0
    with pytest.raises(InputError, match="bit depth = 4100 m"):
        with_bit_at(rig, 4100.0)


def a_log(block_speed: float, turn: float, swing: float = 0.0, effort: float = 4e5) -> RigLog:
    time = np.arange(0.0, 60.0, 0.1)
    none = np.full_like(time, np.nan)
    angle = turn * time + swing * np.sin(2 * np.pi * time / 10.0)
    return RigLog("run.mcap", 0, top_drive=JointSeries(time, time, angle, none, 5e3 * np.cos(time)),
                  draw_works=JointSeries(time, time, block_speed * time, none, np.full_like(time, effort)))


@pytest.mark.parametrize(
    ("block_speed", "turn", "swing", "motion"),
    [(0.1, 0.0, 0.0, "lowered"), (-0.1, 0.0, 0.0, "raised"), (0.002, 0.0, 10.0, "lowered and rocked"),
     (0.002, 6.0, 0.0, "turned"), (0.0, 0.0, 0.0, "still")],
)  # fmt: skip
def test_motion_of_a_stretch_is_named(rig: Rig, block_speed: float, turn: float, swing: float, motion: str) -> None:
    points = log_points(a_log(block_speed, turn, swing), rig)
    assert points.motion == (motion, motion)
    assert points.hook_load == pytest.approx([4e5, 4e5])
    assert points.depth[0] == pytest.approx(4000.0 + 15.0 * block_speed, abs=0.1 * abs(block_speed) + 1e-9)
    if motion == "turned":
        assert abs(points.torque[0]) < 2e3
    else:
        assert points.torque[0] == pytest.approx(5e3, rel=1e-3)


def test_chart_shows_the_log_points(rig: Rig) -> None:
    points = log_points(a_log(-0.1, 0.0), rig)
    chart = hook_load_chart([broomstick(rig, 0.2, [2000.0, 4000.0])], points)
    (dots,) = [mark for mark in chart.panels[0].marks if mark.style == "dots"]
    assert dots.name == "log: raised" and dots.x == pytest.approx([400.0, 400.0]) and chart.panels[0].inverted


def test_page_in_field_units(rig: Rig) -> None:
    html = page_html(torque_drag_page(rig, [broomstick(rig, 0.2, [4000.0])], units=FIELD), FIELD)
    assert "torque to turn, ft lbf" in html and "picking up, klbf" in html and "Example well" in html


def test_survey_table_in_feet(tmp_path: Path) -> None:
    path = tmp_path / "path.csv"
    path.write_text("Azimuth;MD [ft];Inclination;note\n30;1000;0;\n30;2000;45;kick-off\n\n35;3000;90;\n")
    survey = read_survey(path)
    assert survey.notes == ("begins at 304.8 m with 0 deg: taken as vertical from the surface to there",)
    assert survey.stations == (
        (0.0, 0.0, 30.0), pytest.approx((304.8, 0.0, 30.0)), pytest.approx((609.6, 45.0, 30.0)),
        pytest.approx((914.4, 90.0, 35.0)),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "empty"),
        ("md,inc,azi\n0,0,0\n1,1,1\n", "column 'md': has no unit; write md_m or md_ft"),
        ("md_m,inc\n0,0\n", "none of md_m, inc is the azimuth"),
        ("md_m,inc,azi\n0,0,0\n", "1 station"),
        ("md_m,inc,azi\n0,0,0\n10,x,0\n", "line 3: inc = 'x': not a number"),
        ("md_m,inc,azi\n0,0,0\n10,1,0\n10,2,0\n", "line 4: md_m: must increase"),
        ("md_bar,inc,azi\n0,0,0\n", "column 'md_bar': has no unit"),
        ("md [bar],inc,azi\n0,0,0\n", "is a unit of pressure"),
    ],
)
def test_invalid_survey_tables_are_refused(tmp_path: Path, text: str, complaint: str) -> None:
    (tmp_path / "path.csv").write_text(text)
    with pytest.raises(InputError, match=complaint.replace("[", r"\[").replace("?", r"\?")):
        read_survey(tmp_path / "path.csv")


def test_command_writes_rig_with_survey(tmp_path: Path, rig: Rig) -> None:
    lines = ["md_m,inclination,azimuth", *(f"{md},{inc},{azi}" for md, inc, azi in rig.well.survey)]
    (tmp_path / "path.csv").write_text("\n".join(lines))
    out = tmp_path / "out"
    out.mkdir()
    (out / "rig.yaml").write_text("a user's own, which was written over")
    arguments = ["--survey", str(tmp_path / "path.csv"), "--friction", "0.3", "-o", str(out), "--elements", "40"]
    outcome = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert outcome.exit_code == 0 and "friction 0.3" in outcome.output
    assert (out / "rig.yaml").read_text() == "a user's own, which was written over"
    expected = dataclasses.replace(rig, well=dataclasses.replace(rig.well, name=""))
    assert load_rig(out / "torque_drag.rig.yaml") == expected
    assert (out / "torque_drag.html").stat().st_size < 1_500_000 and (out / "torque_drag.png").exists()
    table = (out / "torque_drag.csv").read_text().splitlines()
    assert len(table) == 1 + 2 * 40 and table[-1].startswith("0.3,4000,")


def test_log_of_another_rig_is_said_to_be_one(tmp_path: Path, rig: Rig) -> None:
    """A rig file that is given beside a log with its own is compared with that."""
    own = installed_file("config/rig.example.yaml").read_text()
    log, given = tmp_path / "run.mcap", tmp_path / "other.yaml"
    with LogWriter(log, own) as writer:
        for step in range(50):
            writer.joint_state("top_drive/joint_states", 0.1 * step, "top_drive", 0.1 * step, 1.0, 5e3)
    given.write_text(own)
    assert not any("differs" in note for note in charted_rig(given, read_log(log, given), None)[1])
    given.write_text(installed_file("config/rig.short.yaml").read_text())
    (note,) = (note for note in charted_rig(given, read_log(log, given), None)[1] if "differs" in note)
    short = load_rig(given)
    assert f"the string reaches {rig.string.length:.5g} m, not {short.string.length:.5g} m" in note
    assert "well.survey" in note and "\n" not in note
