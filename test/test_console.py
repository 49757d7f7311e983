"""The consoles show text as it is: no markup, no escapes that steer a terminal."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.table import Table
from rich.text import Text

from slider_drilling.console import LiteralConsole
from slider_drilling.printable import is_text, printable


def shown(thing: object, terminal: bool = False) -> str:
    written = io.StringIO()
    LiteralConsole(
        width=100, file=written, force_terminal=terminal, color_system="standard" if terminal else None
    ).print(thing)
    return written.getvalue()


@pytest.mark.parametrize("text", ["a [backup].mcap", "[/x]", "[bold]b[/bold]", ":smile:", "[link=x]", "[red", "\\[a]"])
def test_brackets_and_colons_are_text(text: str) -> None:
    assert shown(text) == f"{text}\n"
    table = Table(text, title=text)
    table.add_row(text)
    assert shown(table).count(text) == 3


STEERING = ["\x1b]0;title\x07", "\x1b[31mred", "\x9b31m", "back\rover", "\x08\x08", "\u202egnp.exe", "caf\udce9"]


@pytest.mark.parametrize("text", STEERING)
def test_what_steers_a_terminal_is_escaped(text: str) -> None:
    for thing in (text, Text(text)):
        written = shown(thing)
        assert printable(written) == written
    table = Table("x")
    table.add_row(text)
    assert printable(shown(table)) == shown(table)


def test_styles_of_our_own_reach_the_terminal() -> None:
    assert "\x1b[1m" in shown(Text("bold \x1b[5m", "bold"), terminal=True)
    assert "\x1b[5m" not in shown(Text("bold \x1b[5m", "bold"), terminal=True)


@given(st.text())
def test_any_text_becomes_utf_8_that_steers_nothing(text: str) -> None:
    plain = printable(text)
    plain.encode("utf-8")
    assert printable(plain) == plain
    assert is_text(text) or plain != text
    assert is_text(plain)
