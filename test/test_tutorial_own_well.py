"""The tutorial on a reader's own well: its six commands run on the papers of the example well."""

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from slider_drilling.cli import group
from slider_drilling.rig import load_rig

PAPERS = ("survey.csv", "tally.csv", "edr.csv")


def commands(repository: Path) -> list[list[str]]:
    """The arguments of each command of the tutorial's steps."""
    text = (repository / "docs" / "tutorial" / "your_own_well.md").read_text()
    blocks = re.findall(r"^```sh\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    lines = re.sub(r"\\\n", " ", "".join(blocks)).splitlines()
    return [shlex.split(line)[1:] for line in lines if line.startswith("slider-drilling ")]


def test_tutorial_has_six_commands(repository: Path) -> None:
    assert 1 <= len(commands(repository)) <= 6


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_tutorial_runs_on_papers(
    repository: Path, shared_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in PAPERS:
        shutil.copy(shared_data / "paper_well" / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    for line in commands(repository):
        if line[0] == "diagnose":  # minutes: the test of the diagnosis itself is elsewhere
            line += ["--only", "stribeck"]
        outcome = CliRunner().invoke(group, line)
        assert not outcome.exit_code, (line, outcome.output)
    assert load_rig(tmp_path / "torque_drag" / "torque_drag.rig.yaml").string.length == pytest.approx(14500 * 0.3048)
    assert (tmp_path / "rocking_plan" / "rocking_plan.pdf").stat().st_size > 1000
    (slide,) = json.loads((tmp_path / "day" / "activities.json").read_text())["slides"]
    assert slide["is_rocking"] and slide["tool_face"] == pytest.approx(-0.5, abs=0.1)
    assert json.loads((tmp_path / "diagnosis" / "diagnosis.json").read_text())["verdict"]
