"""Options that several commands share, and their output."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

if TYPE_CHECKING:
    import rich.table

    from slider_drilling.log_checks import CheckRow
    from slider_drilling.pages import Table
    from slider_drilling.units import Units

namespace_option = click.option(
    "--namespace", help="Namespace of the topics to read, if the log holds several rigs; / for none."
)
topics_option = click.option(
    "--topics", "topics_path", type=click.Path(path_type=Path),
    help="YAML file that says which topic and joint of the log is which channel, where they have other names.",
)  # fmt: skip


def _reserve_stdout(context: click.Context, option: click.Parameter, value: bool) -> bool:
    """Keep stdout for the JSON, whatever plug-ins print."""
    if value and not context.resilient_parsing:
        from slider_drilling.console.results import reserve_stdout

        context.call_on_close(reserve_stdout())
    return value


def json_option_with(help_text: str) -> Callable[[Any], Any]:
    """The option --json with this help."""
    return click.option("--json", "as_json", is_flag=True, is_eager=True, callback=_reserve_stdout, help=help_text)


json_option = json_option_with("Print JSON on stdout: SI units, rad.")
SEEDS = 2**31
SEED = click.IntRange(0, SEEDS - 1)


def _units(context: click.Context, option: click.Parameter, value: str) -> Units:
    from slider_drilling.units import UNITS

    return UNITS[value]


def units_option_with(default: str) -> Callable[[Any], Any]:
    """The option --units with this default."""
    return click.option(
        "--units", type=click.Choice(["si", "field"]), default=default, show_default=True,
        envvar="SLIDER_DRILLING_UNITS", show_envvar=True, callback=_units,
        help="Units of tables, pages and pictures: m, kN, bar, kN m, rad or ft, klbf, psi, ft lbf, turns.",
    )  # fmt: skip


units_option = units_option_with("si")


def refuse_ignored(kind: str, ignored: Iterable[str]) -> None:
    """Raise InputError for an option of the command line that this kind of run would ignore.

    Args:
        kind: For the message, such as "with --campaign".
        ignored: Names of the options' parameters.
    """
    from slider_drilling.errors import InputError

    names = set(ignored)
    for name, flag in given_options().items():
        if name in names:
            raise InputError(f"{flag}: has no meaning {kind}; leave it out")


def given_options() -> dict[str, str]:
    """Flags of the options that the command line gives, by the names of their parameters."""
    context = click.get_current_context()
    return {
        option.name: option.opts[-1] for option in context.command.params
        if option.name and context.get_parameter_source(option.name) is ParameterSource.COMMANDLINE
    }  # fmt: skip


def print_json(tree: Mapping[str, Any]) -> None:
    """Print one JSON object; NaN and infinity become null, paths become text."""
    from slider_drilling.console.results import results_stream

    click.echo(json.dumps(_plain(tree), indent=1, allow_nan=False), file=results_stream())


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (Sequence, frozenset, set)) and not isinstance(value, str):
        return [_plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_and_print(
    tree: Mapping[str, Any] | None, show: Callable[[], None], write: Callable[[], Sequence[Path]]
) -> None:
    """Write an answer's files, print the answer, and list the files.

    An answer may have taken minutes: it is printed even if no file can be written, and written even if nobody reads
    the output.

    Args:
        tree: Printed as JSON; None to call ``show`` instead.
        show: Prints the answer as text.
        write: Writes the files and returns their paths.
    """
    written: Sequence[Path] = ()
    try:
        written = write()
    finally:
        if tree is None:
            show()
        else:
            print_json({**tree, "wrote": written})
    if tree is None:
        print_written(written)


def print_written(paths: Iterable[Path]) -> None:
    """Print a line for each file."""
    from slider_drilling.console.streams import stdout

    for path in paths:
        stdout().print(f"wrote {path}")


def print_tables(tables: Sequence[Table], units: Units) -> None:
    """Print tables of a page in these units."""
    from slider_drilling.console.streams import stdout
    from slider_drilling.pages.console_table import console_table

    for table in tables:
        stdout().print(console_table(table, units))


def print_checks(rows: Sequence[CheckRow], units: Units, source: str = "") -> None:
    """Print the table of log checks: what was found, and in one row what is in order.

    Args:
        rows: Of `LogChecks.rows`.
        units: Display units.
        source: Names the log where there are several.
    """
    from slider_drilling.console.streams import stdout

    stdout().print(checks_table(rows, units, source))


def checks_table(rows: Sequence[CheckRow], units: Units, source: str = "") -> rich.table.Table:
    """The table that `print_checks` prints."""
    from rich.box import SIMPLE
    from rich.table import Table
    from rich.text import Text

    title = f"log checks: {source}" if source else "log checks"
    table = Table("check", "result", "", title=title, title_justify="left", box=SIMPLE, padding=(0, 1, 0, 0))
    for row in rows:
        if row.result != "ok":
            table.add_row(row.check, row.result, Text(units.convert_message(row.text)))
    sound = ", ".join(row.check for row in rows if row.result == "ok")
    if sound:
        table.add_row("", "ok", sound)
    return table


def complete_effect(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Shell completion: effects that start with the typed text."""
    from slider_drilling.effects import EFFECTS

    return [name for name in EFFECTS if name.startswith(incomplete)]


def print_listing(entries: Iterable[tuple[str, str]]) -> None:
    """Print names and descriptions, for --list."""
    from rich.table import Table

    from slider_drilling.console.streams import stdout

    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for entry in entries:
        table.add_row(*entry)
    stdout().print(table)
