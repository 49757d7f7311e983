"""YAML reads the same with libyaml and without it: values, errors and their lines."""

from __future__ import annotations

from pathlib import Path
from unittest import mock

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from slider_drilling.errors import InputError
from slider_drilling.schema.yaml_tree import parse_yaml

CONFIG = Path(__file__).parents[1] / "config"
PIECES = (
    "a", "b: ", "b:", "- ", "\n", "\n  ", "[", "]", "{", "}", ", ", "1", "1e3", "-.5", "'", '"', "#", " # c", "&x ",
    "*x", "|\n", ">-\n", "? ", "!t ", "%", "~", "\t", "\\", "°", "---\n", "...\n", "null", "012", "\x00", "<<: ",
)  # fmt: skip


def outcome(text: str, with_libyaml: bool) -> str:
    """A text's tree, or its error."""
    with mock.patch.object(yaml, "__with_libyaml__", with_libyaml):
        try:
            return repr(parse_yaml(text, "text"))
        except InputError as error:
            return str(error)


@pytest.mark.parametrize("path", sorted(CONFIG.rglob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_files_read_the_same(path: Path) -> None:
    assert outcome(path.read_text(), True) == outcome(path.read_text(), False)


@settings(max_examples=400)
@given(st.lists(st.sampled_from(PIECES), max_size=12).map("".join))
def test_any_text_reads_the_same(text: str) -> None:
    assert outcome(text, True) == outcome(text, False)


@pytest.mark.parametrize("text", ["[" * 5000 + "]" * 5000, "- " * 3000 + "a", "{a: " * 2000 + "1" + "}" * 2000])
def test_deep_nesting_is_refused_by_both(text: str) -> None:
    assert outcome(text, True) == outcome(text, False) == "text: not usable: lists or keys nested too deeply"
