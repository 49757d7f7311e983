"""Every code block of README and documentation works: Python runs, commands parse or run, tables and YAML are read."""

import ast
import re
import shlex
from pathlib import Path

import click
import numpy as np
import pytest
import yaml
from click.testing import CliRunner

import slider_drilling as sd
from slider_drilling.cli import COMMANDS, group
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import load_rig
from slider_drilling.schema.fields import build_dataclass

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
# Run by tests of their own: they need a folder or a controller of a certain make.
ELSEWHERE = {"logs.md", "nodes.md", "control.md", "user_effects.md"}
# Commands that are done in seconds, once the files that pages speak of are there.
QUICK = {"plot", "replay", "torque-drag", "info"}


def blocks(page: Path, language: str) -> list[str]:
    return [code for name, code in FENCE.findall(page.read_text()) if name == language]


def command_lines(page: Path) -> list[list[str]]:
    """The arguments of every `slider-drilling` line in an indented or fenced block."""
    # A line that ends in a backslash goes on in the next one.
    text, joined = re.sub(r" *\\\n *", " ", page.read_text()), []
    for _, code in FENCE.findall(text):
        joined += code.splitlines()
    joined += [line[4:] for line in FENCE.sub("", text).splitlines() if line.startswith("    ")]
    whole = re.sub(r" *\\\n *", " ", "\n".join(joined)).splitlines()  # a line that goes on in the next
    lines = [line.split("#")[0].strip().removeprefix("$ ") for line in whole]
    return [shlex.split(line)[1:] for line in lines if re.match(r"slider-drilling [a-z]", line)]


LINES = [(page, line) for page in PAGES for line in command_lines(page)]


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that holds what pages speak of: a rig file, a log, a path."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("rig.yaml", "nominal.yaml"):
        (tmp_path / name).write_text(installed_file("config/rig.example.yaml").read_text())
    path, *_ = blocks(ROOT / "docs" / "how_to" / "pages.md", "csv")
    (tmp_path / "path.csv").write_text(path)
    return tmp_path


def test_pages_with_command_lines_are_checked() -> None:
    assert {page.name for page, _ in LINES} >= {"quickstart.md", "pages.md", "diagnose.md", "control.md"}
    assert {line[0] for _, line in LINES} <= set(COMMANDS)


@pytest.mark.parametrize(("page", "line"), LINES, ids=lambda value: " ".join(value) if isinstance(value, list) else "")
def test_command_lines_of_pages_parse(desk: Path, page: Path, line: list[str]) -> None:
    parent = click.Context(group, info_name="slider-drilling")
    command = group.get_command(parent, line[0])
    assert command is not None
    for folder in ("sealed", "DIR"):
        (desk / folder).mkdir()
    try:
        command.make_context(line[0], line[1:], parent=parent)
    except click.exceptions.Exit as leaving:  # --help
        assert leaving.exit_code == 0


def test_quick_commands_of_pages_run(desk: Path) -> None:
    run = sd.simulate(sd.load_rig(), "slider_drilling.control:SlideController", 40.0, elements=20)
    for name in ("run.mcap", "out/slide/slide.mcap"):
        (desk / name).parent.mkdir(parents=True, exist_ok=True)
        run.save(desk / name)
    (desk / "out" / "diagnosis").mkdir()
    (desk / "out" / "diagnosis" / "rig.tuned.yaml").write_text((desk / "rig.yaml").read_text())
    (desk / "out" / "tuned").mkdir()
    done = 0
    for page, line in LINES:
        if line[0] not in QUICK or page.name == "logs.md":
            continue
        found = [str(next(iter(desk.glob(word)), word)) if "*" in word else word for word in line[1:]]
        command = group.get_command(click.Context(group), line[0])
        outcome = CliRunner().invoke(command, found, catch_exceptions=False)
        assert not outcome.exit_code, (line, outcome.output)
        done += 1
    assert done >= 5
    assert (desk / "out" / "tuned" / "replay.html").stat().st_size < 1_500_000


@pytest.mark.parametrize("page", [page for page in PAGES if page.name not in ELSEWHERE and blocks(page, "python")])
def test_python_of_pages_runs(page: Path, desk: Path) -> None:
    namespace: dict[str, object] = {"__name__": "page"}
    for code in blocks(page, "python"):
        exec(compile(code, str(page), "exec"), namespace)


def test_every_python_block_has_a_test() -> None:
    tested = (ROOT / "test").rglob("test_*.py")
    said = "".join(path.read_text() for path in tested if path.name != Path(__file__).name)
    for page in PAGES:
        for code in blocks(page, "python"):
            ast.parse(code)
            assert page.name not in ELSEWHERE or f'"{page.name}"' in said


def test_tutorial_controller_slides(desk: Path) -> None:
    code = blocks(ROOT / "docs" / "tutorial" / "your_controller.md", "python")[0]
    (desk / "mine.py").write_text(code)
    run = sd.simulate(sd.load_rig(), "mine:Mine", 5.0, elements=20)
    assert np.ptp(run.response.surface_torque) > 1e3


def test_yaml_of_pages_is_valid(desk: Path) -> None:
    found = [code for page in PAGES for code in blocks(page, "yaml")]
    trees = [yaml.safe_load(code) for code in found]
    effects = [tree["effects"] for tree in trees if isinstance(tree, dict) and "effects" in tree]
    assert effects
    kind = type(load_rig(desk / "rig.yaml").effects)
    for tree in effects:
        build_dataclass(kind, tree, "page")


def test_links_of_pages_resolve() -> None:
    made = {"pictures", "reference"}
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", page.read_text()):
            target = (page.parent / link).resolve()
            assert target.exists() or target.parent.name in made, (page.name, link)


def test_readme_links_to_every_page() -> None:
    text = (ROOT / "README.md").read_text()
    rooms = ("tutorial", "how_to", "explanation")
    pages = [page.relative_to(ROOT) for page in PAGES if page.parent.name in rooms]
    missing = [str(page) for page in pages if f"({page})" not in text]
    assert not missing


def test_site_navigation_lists_every_page() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text()
    for page in (ROOT / "docs").rglob("*.md"):
        assert f"{page.relative_to(ROOT / 'docs')}" in navigation, page


def test_pages_and_code_hold_no_history() -> None:
    """Neither pages nor code say how their figures came about."""
    forbidden = re.compile(r"\b[Ii]ssues? #?\d|\b[Ii]ssue's|\bthe issue\b|of its hour|\bthis session\b")
    sources = [*PAGES, *(ROOT / "slider_drilling").rglob("*.py"), *(ROOT / "config").glob("*.yaml")]
    assert not [(path.name, found[0]) for path in sources for found in forbidden.finditer(path.read_text())]
