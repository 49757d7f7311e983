"""The pages that the site's build makes of the code: complete, and equations as the browser's own mathematics."""

import re
import sys
from pathlib import Path

import pytest

from slider_drilling.cli import COMMANDS
from slider_drilling.messages.topics import TOPICS
from slider_drilling.programmes.programme import programme_numbers
from slider_drilling.programmes.steps import ACTIONS
from slider_drilling.rig.ranges_table import ranges_table

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(autouse=True)
def site_build(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT)
    yield
    for name in [name for name in sys.modules if name.startswith("site_build")]:
        del sys.modules[name]


def test_rig_reference_has_every_key() -> None:
    from site_build.rig_reference import rig_page

    page = rig_page()
    for row in ranges_table():
        assert f"| `{row[0]}` | {row[1]} |" in page
    headings = re.findall(r"^## `(\w+)`$", page, re.MULTILINE)
    assert headings[0] == "well" and headings[-1] == "effects" and len(headings) == len(set(headings)) >= 11


def test_programme_reference_has_every_step_and_number() -> None:
    from site_build.programme_reference import programme_page

    page = programme_page()
    assert re.findall(r"^## `(\w+)`$", page, re.MULTILINE) == list(ACTIONS)
    for row in programme_numbers():
        assert f"| `{row.key}` | {row.range.unit} |" in page


def test_topics_page_has_every_topic() -> None:
    from site_build.topics_reference import topics_page

    page = topics_page()
    assert page.startswith("# Topics\n") and "(docs/" not in page
    assert all(f"`{topic.name}`" in page for topic in TOPICS.values())
    assert all(f"`{quantity.column}`" in page for topic in TOPICS.values() for quantity in topic.quantities)


def test_readme_has_topics_table() -> None:
    from site_build.topics_reference import topic_table

    assert topic_table() in (ROOT / "README.md").read_text()


def test_command_reference_has_every_command_and_option() -> None:
    from site_build.cli_reference import cli_page

    page = cli_page()
    assert re.findall(r"^## ([\w-]+)$", page, re.MULTILINE) == list(COMMANDS)
    run = page[page.index("## run\n") : page.index("## plot\n")]
    for option in ("--rig", "--duration", "--units [si\\|field]", "--target"):
        assert option in run


def test_equations_become_mathml() -> None:
    pytest.importorskip("latex2mathml", reason="pip install '.[docs]'")
    pytest.importorskip("mkdocs", reason="pip install '.[docs]'")
    from site_build.hooks import on_page_markdown

    drawn = on_page_markdown((ROOT / "docs" / "explanation" / "model.md").read_text())
    assert drawn.count('<div class="equation"><math') == 7
    assert "$" not in drawn and "\\frac" not in drawn


def test_dollars_in_code_stay() -> None:
    pytest.importorskip("latex2mathml", reason="pip install '.[docs]'")
    pytest.importorskip("mkdocs", reason="pip install '.[docs]'")
    from site_build.hooks import on_page_markdown

    text = "`$HOME` and\n\n```sh\necho $A $B\n```\n"
    assert on_page_markdown(text) == text
