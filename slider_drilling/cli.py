"""The command line: a table of sub-commands, each imported only when it is called."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NoReturn

import click

from slider_drilling import __version__
from slider_drilling.console.printable import printable
from slider_drilling.console.results import reserve_until_exit, results_stream
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import remove_empty_folders
from slider_drilling.process.environment_variables import check_variables
from slider_drilling.process.shutdown import (
    caused_by_signal,
    raise_on_signals,
    restore_default_handlers,
    signal_exit_code,
)

EXAMPLES = """\
Examples:

\b
  slider-drilling run --duration 300 --record out
  slider-drilling import export.csv --mapping mapping.yaml -o log.mcap
  slider-drilling COMMAND --help
"""


MAX_ERROR_LENGTH = 2000
"""Characters of an error message, which may quote a whole file."""


@dataclass(frozen=True)
class CommandEntry:
    """One sub-command.

    Attributes:
        module: Holds its click command `command`.
        help: The line that `--help` of the group shows.
    """

    module: str
    help: str


COMMANDS: dict[str, CommandEntry] = {
    "run": CommandEntry(
        "slider_drilling.commands.run", "Simulate a slide: simulator, controller and recorder over ROS 2 topics."
    ),
    "plot": CommandEntry("slider_drilling.commands.plot", "Plot a log and print what happened in it."),
    "closed-loop": CommandEntry(
        "slider_drilling.commands.closed_loop", "Score a controller in fixed scenarios, without ROS."
    ),
    "replay": CommandEntry(
        "slider_drilling.commands.replay", "Simulate a log's commands and compare each channel."
    ),
    "diagnose": CommandEntry(
        "slider_drilling.commands.diagnose", "Why a run and the simulator differ, and by which effect."
    ),
    "watch": CommandEntry(
        "slider_drilling.commands.watch", "Follow a rig or a log live: the gap, what changed, since when, and why."
    ),
    "blind-check": CommandEntry(
        "slider_drilling.commands.blind_check", "Measure how often the diagnosis is right."
    ),
    "rig": CommandEntry("slider_drilling.commands.rig", "Make a rig file from a rig's papers; list its tables."),
    "torque-drag": CommandEntry(
        "slider_drilling.commands.torque_drag", "Draw hook load and torque against depth."
    ),
    "rocking-plan": CommandEntry(
        "slider_drilling.commands.rocking_plan", "Plan how to rock at each depth: turns, torque, period, offset."
    ),
    "plan-test": CommandEntry(
        "slider_drilling.commands.plan_test", "Plan the test programme that distinguishes causes."
    ),
    "investigate": CommandEntry(
        "slider_drilling.commands.investigate", "Record, diagnose, plan a test, run it, until the answer stands."
    ),
    "study": CommandEntry(
        "slider_drilling.commands.study", "Study the paper's vibration tools, with a verdict on each claim."
    ),
    "activities": CommandEntry(
        "slider_drilling.commands.activities", "Split a day into rotating, sliding, connections and the rest."
    ),
    "analyse": CommandEntry("slider_drilling.commands.analyse", "Find the friction in a log, and where it acts."),
    "identify": CommandEntry("slider_drilling.commands.identify", "Fit contact parameters to measured friction."),
    "import": CommandEntry(
        "slider_drilling.commands.import_table",
        "Turn a recorder's table (CSV, LAS, XLSX, Parquet, WITSML, WITS) into a log.",
    ),
    "info": CommandEntry(
        "slider_drilling.commands.info", "List what a log holds, what it has lost, and what it is good for."
    ),
    "recover": CommandEntry("slider_drilling.commands.recover", "Write what a damaged log still holds to whole logs."),
    "bench": CommandEntry("slider_drilling.commands.bench", "Measure speed, each figure beside a reference."),
    "completion": CommandEntry(
        "slider_drilling.commands.completion", "Print the script for shell completion."
    ),
}


class LazyGroup(click.Group):
    """A click group that shows its `--help` without importing its sub-commands."""

    def __init__(self, *args: object, table: Mapping[str, CommandEntry], **kwargs: object) -> None:
        super().__init__(*args, **kwargs)  # type: ignore[arg-type]
        self.table = table

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.table)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        row = self.table.get(cmd_name)
        if row is None:
            return None
        command: click.Command = importlib.import_module(row.module).command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, row.help) for name, row in self.table.items()])


@click.group(cls=LazyGroup, table=COMMANDS, epilog=EXAMPLES)
@click.version_option(__version__, prog_name="slider-drilling")
def group() -> None:
    """Simulate, control and diagnose slide drilling.

    SI units and radians, unless an option's name says otherwise.
    """
    check_variables(os.environ)


def fail(message: str, code: int) -> NoReturn:
    """Print a message as one line on stderr and exit with a code; folders that were made and are empty are removed."""
    restore_default_handlers()
    remove_empty_folders()
    line = printable(" ".join(message.split()))
    if len(line) > MAX_ERROR_LENGTH:
        line = f"{line[: MAX_ERROR_LENGTH // 2]} ... {line[-MAX_ERROR_LENGTH // 2 :]}"
    with contextlib.suppress(OSError):
        print(line, file=sys.stderr, flush=True)
    raise SystemExit(code)


def run_group(command: click.Group, arguments: list[str] | None = None) -> None:
    """Run a command group and end the process.

    The exit code is 0; 2 for a mistake of the user; 1 if the output was closed; 128 plus the number for a signal.
    """
    try:
        outcome = command.main(args=arguments, prog_name="slider-drilling", standalone_mode=False)
        sys.stdout.flush()
        restore_default_handlers()
    except InputError as error:
        fail(str(error), 2)
    except click.UsageError as error:
        where = error.ctx.command_path if error.ctx is not None else "slider-drilling"
        fail(f"{where}: {error.format_message()} See `{where} --help`.", 2)
    except click.ClickException as error:
        fail(error.format_message(), 2)
    except click.Abort as error:
        # Click turns these two into one: a file that ends too early is no interrupt.
        if isinstance(error.__cause__, EOFError):
            _fail_for_short_file(error.__cause__)
        fail("interrupted", signal_exit_code() or 130)
    except KeyboardInterrupt:
        fail("interrupted", signal_exit_code() or 130)
    except BrokenPipeError:
        _silence_stdout()
        raise SystemExit(1) from None
    except MemoryError:
        fail("slider-drilling: not enough memory; shorten the log or use fewer elements", 2)
    except OSError as error:
        _silence_stdout()
        where = error.filename if error.filename is not None else "slider-drilling"
        fail(f"{where}: {error.strerror or error}", 2)
    except Exception as error:
        # Python 3.11 and older turn an exception raised while a class is created into a RuntimeError.
        if not caused_by_signal(error):
            raise
        fail("interrupted", signal_exit_code())
    # A command that a signal cut short has written partial results, which say so; the exit code does too.
    raise SystemExit(signal_exit_code() or (outcome if isinstance(outcome, int) else 0))


def _fail_for_short_file(error: EOFError) -> NoReturn:
    """Say what to do about a module whose compiled form ends too early; raise any other error.

    Python does not check how much of a compiled module it wrote: on a full disk it keeps the beginning, and every later
    start fails.
    """
    if "marshal data" not in str(error) and "EOF read where" not in str(error):
        raise error
    fail(f"{os.path.dirname(__file__)}: compiled Python modules are cut off, as by a full disk; make room and delete "
         "all folders __pycache__ below it", 2)  # fmt: skip


def _silence_stdout() -> None:
    """Keep the interpreter's flush at exit from reporting a closed output again."""
    with contextlib.suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), results_stream().fileno())


def _open_streams() -> None:
    """Open missing standard streams, and let them print any file name.

    Without a standard output, the next file opened would get its descriptor, to which libraries print.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", closefd=False)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def main() -> None:
    """Entry point of `slider-drilling` and of `python -m slider_drilling`."""
    # Before numpy is imported: the matrices are small, and OpenBLAS's waiting threads would take a third of the
    # processor from the simulations.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _open_streams()
    raise_on_signals()
    reserve_until_exit()
    run_group(group)
