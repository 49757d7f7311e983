"""`info` fits on a screen: at most 25 lines of 80 columns, whatever the log holds."""

import math
from pathlib import Path

import pytest
from click.testing import CliRunner

from slider_drilling.cli import group
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
