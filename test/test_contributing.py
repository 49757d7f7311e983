"""README's map and the lists of CONTRIBUTING.md are true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "slider_drilling"
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
TASKS = ("effect", "channel", "command", "node")


def _parts() -> set[str]:
    """Folders and root modules of the package."""
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    return folders | {path.stem for path in PACKAGE.glob("*.py") if path.stem != "__init__"}


def _rows(task: str) -> list[tuple[list[str], list[str]]]:
    """Files and anchors of each row of the table of a task."""
    section = re.search(rf"^## Add an? {task}\n(.*?)(?=^## )", CONTRIBUTING, re.DOTALL | re.MULTILINE)
    assert section is not None
    rows = re.findall(r"^\| (`.*?) \| (.*?) \|$", section[1], re.MULTILINE)
    code = re.compile(r"`([^`]+)`")
    return [(code.findall(files), code.findall(anchors)) for files, anchors in rows]


def test_readme_map_names_every_module() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    listed = re.search(r"^    slider_drilling/\n((?:      .*\n)+)", text, re.MULTILINE)
    assert listed is not None
    names = re.findall(r"^      (\w+)(?:\.py|/) ", listed[1], re.MULTILINE)
    assert sorted(names) == sorted(_parts())


def test_contributing_map_names_every_module() -> None:
    table = CONTRIBUTING[CONTRIBUTING.index("| layer |") : CONTRIBUTING.index("The exact order")]
    assert sorted(re.findall(r"`(\w+)`", table)) == sorted(_parts())


@pytest.mark.parametrize("task", TASKS)
def test_task_takes_three_files_at_most(task: str) -> None:
    assert 1 <= len(_rows(task)) <= 3


@pytest.mark.parametrize("task", TASKS)
def test_task_files_hold_their_anchor(task: str) -> None:
    for files, anchors in _rows(task):
        text = (ROOT / files[0]).read_text(encoding="utf-8")
        assert anchors and anchors[0] in text, files[0]


def test_contributing_names_files_that_exist() -> None:
    for name in re.findall(r"`((?:slider_drilling|docs|config)/[\w./]+)`", CONTRIBUTING):
        assert "NAME" in name or (ROOT / name).exists() or name == "docs/reference/cli.md", name
