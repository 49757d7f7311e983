"""The consoles print text literally: no markup, no control characters."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from rich.table import Table
from rich.text import Text

from slider_drilling.console import progress_lines
from slider_drilling.console.printable import is_valid_utf8, printable
from slider_drilling.console.progress_lines import FIRST_LINE_AFTER, ProgressLines
from slider_drilling.console.streams import LiteralConsole, progress_stages, stderr


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
def test_control_characters_are_escaped(text: str) -> None:
    for thing in (text, Text(text)):
        written = shown(thing)
        assert printable(written) == written
    table = Table("x")
    table.add_row(text)
    assert printable(shown(table)) == shown(table)


def test_own_styles_reach_the_terminal() -> None:
    assert "\x1b[1m" in shown(Text("bold \x1b[5m", "bold"), terminal=True)
    assert "\x1b[5m" not in shown(Text("bold \x1b[5m", "bold"), terminal=True)


@given(st.text())
def test_any_text_becomes_printable_utf8(text: str) -> None:
    plain = printable(text)
    plain.encode("utf-8")
    assert printable(plain) == plain
    assert is_valid_utf8(text) or plain != text
    assert is_valid_utf8(plain)


WIDE = ("channel", "lowest", "mean", "highest", "what it is, and how it was measured")
ROWS = [("standpipe_pressure", "17882558.18", "18552502.87", "19704031.93", "of the pump's discharge, by its sensor"),
        ("surface_torque", "-5008.49", "213.5", "7648.37", "what the top drive feels; noise and lag of the sensor")]


def at_width(width: int, table: Table) -> str:
    written = io.StringIO()
    LiteralConsole(width=width, file=written).print(table)
    return written.getvalue()


@pytest.mark.parametrize("width", [200, 120, 100, 80, 72, 60, 40, 24])
def test_tables_fit_without_losing_text(width: int) -> None:
    table = Table(*WIDE, title="What was measured")
    for row in ROWS:
        table.add_row(*row)
    written = at_width(width, table)
    assert max(len(line.rstrip()) for line in written.splitlines()) <= width
    for row in ROWS:
        for cell in row[:4]:
            assert cell in written, cell
        for word in row[4].split():
            assert word in written, word


def test_narrow_tables_are_unchanged() -> None:
    plain, fits = (Table("a", "b", box=None) for _ in range(2))
    for table in (plain, fits):
        table.add_row("1.5", "two words")
    written = io.StringIO()
    Console(file=written, width=100).print(plain)
    assert at_width(100, fits) == written.getvalue()


def test_rows_that_do_not_fit_keep_headers() -> None:
    table = Table(*WIDE)
    table.add_row(*ROWS[0])
    lines = [line.split(maxsplit=1) for line in at_width(46, table).splitlines()]
    assert ["highest", "19704031.93"] in [[part.strip() for part in line] for line in lines]


def test_progress_in_a_pipe_is_occasional_lines() -> None:
    now, said = [0.0], []
    with ProgressLines(said.append, lambda: now[0]) as progress:
        task = progress.add_task("reading", total=200.0)
        for k in range(201):
            now[0] = 0.5 * k
            progress.update(task, completed=float(k), description="reading" if k < 50 else "fitting")
        progress.advance(task, 5.0)
    assert said[0] == "reading: 5 %, 10 of 200"
    assert said[-1] == "fitting: 95 %, 190 of 200"
    assert len(said) == 7
    assert not any("\r" in line or "\x1b" in line for line in said)


def test_short_work_in_a_pipe_prints_nothing() -> None:
    now, said = [0.0], []
    with ProgressLines(said.append, lambda: now[0]) as progress:
        task = progress.add_task("reading", total=None)
        now[0] = FIRST_LINE_AFTER - 0.1
        progress.update(task, completed=1)
    assert said == []


def test_stages_are_printed_without_terminal(capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    monkeypatch.setattr(progress_lines, "FIRST_LINE_AFTER", 0.0)
    stderr.cache_clear()
    with progress_stages() as report:
        report("tuning", 0.25)
        report("fitting", 0.5)
    stderr.cache_clear()
    assert capsys.readouterr().err == "tuning: 25 %\n"
