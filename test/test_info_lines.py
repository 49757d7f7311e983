"""`info` fits on a screen: at most 25 lines of 80 columns, whatever the log holds."""

import math
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from slider_drilling.cli import group
from slider_drilling.commands.info_lines import _shortened
from slider_drilling.log import TOPICS, LogWriter
from slider_drilling.messages.message_types import JOINT_STATE, WRENCH_STAMPED


def printed(*words: str) -> list[str]:
    done = CliRunner(env={"COLUMNS": "80"}).invoke(group, ["info", *words])
    assert done.exit_code == 0, done.output
    return done.stdout.splitlines()


def height(lines: list[str]) -> int:
    return sum(max(1, math.ceil(len(line) / 80)) for line in lines)


@pytest.fixture
def crowded(tmp_path: Path, repository: Path) -> Path:
    """Every topic of a rig in a long namespace, twenty others, and something wrong with each."""
    path = tmp_path / "run.mcap"
    with LogWriter(path, (repository / "config" / "rig.example.yaml").read_text()) as writer:
        for step in range(60):
            now = 0.1 * step + (5.0 if step > 30 else 0.0)
            for topic in TOPICS.values():
                name = f"/a_long_name_of_a_company/rig_17/{topic.name}"
                # An impossible value and a repeated stamp.
                value = 1e20 if step % 17 == 3 else 1.0
                stamp = now - 0.1 if step == 20 else now
                if topic.type == JOINT_STATE:
                    writer.joint_state(name, stamp, topic.joint, value, value, value, now)
                elif topic.type == WRENCH_STAMPED:
                    writer.wrench(name, stamp, (value, 0.0, 0.0), log_time_s=now)
                else:
                    writer.fluid_pressure(name, stamp, value, log_time_s=now)
            for number in range(20):
                writer.wrench(f"/another_machine/force_{number}", now, (0.0, 0.0, 0.0))
    return path


def test_a_crowded_log_fits_on_a_screen(crowded: Path) -> None:
    lines = printed(str(crowded))
    assert height(lines) <= 25 and max(map(len, lines[:15])) <= 80
    assert any("--all shows them" in line for line in lines)
    assert any(line.startswith(f"and {len(TOPICS) + 20 - 12} other topics: ") for line in lines)
    assert "truth" in " ".join(lines[2:15]) and "expected" not in " ".join(lines[2:15]), "measurements first"
    whole = printed(str(crowded), "--all")
    assert len(whole) > 25 and sum("force_" in line for line in whole) == 20


def test_a_log_of_a_rig_fits_on_a_screen(tmp_path: Path, repository: Path) -> None:
    with LogWriter(tmp_path / "run.mcap", (repository / "config" / "rig.example.yaml").read_text()) as writer:
        for step in range(100):
            writer.joint_state("top_drive/joint_states", 0.1 * step, "top_drive", 0.1 * step, 1.0, 5e3)
    lines = printed(str(tmp_path / "run.mcap"))
    assert height(lines) <= 25 and not any("--all" in line for line in lines)
    assert "replay: ready; diagnosis" in "\n".join(lines)


def written(path: Path, rig: str, joint: str = "top_drive", hook_load: float = 3e5, stamp: float = 0.0) -> str:
    """A log of 30 s in which the drive rocks."""
    with LogWriter(path, rig) as writer:
        for step in range(300):
            now = 0.1 * step
            writer.joint_state(f"{joint}/joint_states", now, joint, 5.0 * math.sin(now), 5.0 * math.cos(now), 5e3)
            writer.joint_state("draw_works/joint_states", now, "draw_works", 0.0, 0.0, hook_load)
            writer.fluid_pressure("standpipe_pressure", now, 5e8 if step == 5 else 1.8e7)
    return str(path)


def test_reasons_and_notes_are_in_the_chosen_units(tmp_path: Path, repository: Path) -> None:
    """No quantity stays in SI units beside one in those of the field."""
    path = written(tmp_path / "run.mcap", (repository / "config" / "rig.example.yaml").read_text(), hook_load=-3e5)
    text = " ".join(printed(path, "--units", "field", "--all"))
    assert "hook_load is negative (" in text and " klbf): tension" in text
    assert "note: standpipe_pressure: 1 of 300" in text
    assert not re.search(r"\d (bar|kN|Pa|rad/s)\b", text)


def test_info_does_not_advise_info(tmp_path: Path, repository: Path) -> None:
    path = written(tmp_path / "run.mcap", (repository / "config" / "rig.example.yaml").read_text(), joint="table")
    text = " ".join(" ".join(printed(path, "--all")).split())
    assert "slider-drilling info" not in text
    assert "not checked needs top_drive/joint_states, which the log does not hold" in text


@pytest.mark.parametrize("room", [11, 14, 17, 20, 40])
def test_shortened_names_stay_distinct(room: int) -> None:
    names = ["/draw_works/joint_states", "/twin_of_works/joint_states", "/mud_pump/joint_states", "/clock"]
    shown = _shortened(names, room)
    assert len(set(shown)) == len(names) and max(map(len, shown)) <= room and shown[3] == "/clock"


def test_lag_of_another_clock_takes_no_room(tmp_path: Path) -> None:
    """A simulator's stamps count from zero, the recorder's from 1970."""
    with LogWriter(tmp_path / "run.mcap") as writer:
        for step in range(30):
            writer.joint_state("top_drive/joint_states", 0.1 * step, "top_drive", 0.0, 0.0, 5e3, 1.8e9 + 0.1 * step)
    row = next(line for line in printed(str(tmp_path / "run.mcap"), "--all") if "top_drive/joint_states" in line)
    assert row.endswith(" 1.8e9") and len(row) <= 80
