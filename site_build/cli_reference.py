"""The command line's reference, from click."""

from __future__ import annotations

import click

from slider_drilling.cli import COMMANDS, group

INTRODUCTION = """\
# Command line

`slider-drilling COMMAND --help` says the same. Results go to stdout, progress and remarks to stderr. Exit codes: 0,
2 for a mistake in a file or an option (one line says which), 130 for Ctrl-C, 143 for SIGTERM. `--units field`, or
`SLIDER_DRILLING_UNITS=field` in the environment, shows tables, pages and pictures in ft, klbf, psi, ft lbf and turns;
JSON and CSV stay SI.

"""


def cli_page() -> str:
    """The page as Markdown: a section a command."""
    parent = click.Context(group, info_name="slider-drilling")
    parts = [INTRODUCTION, *(f"* [`{name}`](#{name}): {row.help}\n" for name, row in COMMANDS.items()), "\n"]
    for name in COMMANDS:
        command = group.get_command(parent, name)
        assert command is not None
        context = click.Context(command, info_name=name, parent=parent)
        parts.append(_section(name, command, context))
        if isinstance(command, click.Group):
            parts += [_section(f"{name} {below}", one, click.Context(one, info_name=below, parent=context))
                      for below, one in command.commands.items()]  # fmt: skip
    return "".join(parts)


def _section(name: str, command: click.Command, context: click.Context) -> str:
    usage = command.get_usage(context).removeprefix("Usage: ")
    about = (command.help or "").replace("\b\n", "").strip()
    rows = [record for one in command.get_params(context) if (record := one.get_help_record(context)) is not None]
    table = "".join(f"| {_code(flags)} | {_words(text)} |\n" for flags, text in rows)
    examples = f"```text\n{_plain(command.epilog)}\n```\n\n" if command.epilog else ""
    return f"## {name}\n\n```text\n{usage}\n```\n\n{about}\n\n| option | |\n|---|---|\n{table}\n{examples}"


def _code(text: str) -> str:
    return f"`{text.replace('|', chr(92) + '|')}`"


def _words(text: str) -> str:
    return " ".join(text.replace("|", "\\|").replace("[", "\\[").replace("<", "&lt;").split())


def _plain(text: str) -> str:
    return text.replace("\b\n", "").strip("\n")
