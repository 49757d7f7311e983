"""`slider-drilling investigate`: record, diagnose, plan, run, and again, until the answer stands."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import (
    SEED,
    SEEDS,
    given_options,
    json_option,
    units_option_with,
    write_and_print,
)
from slider_drilling.process.parent_death import PARENT_PID_VARIABLE

if TYPE_CHECKING:
    from slider_drilling.investigation.loop import Investigation, Recorder
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling investigate --rig rig.yaml --on sealed --rounds 2 -o investigation
  slider-drilling investigate --rig rig.yaml --on well_17 --rounds 3
  slider-drilling investigate --rig rig.yaml --on ros --effect static_aging -o investigation
"""
_POLL_S = 2.0


@click.command(epilog=EXAMPLES)
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), required=True, help="Rig file.")
@click.option("--on", "where", required=True, metavar="sealed|ros|FOLDER",
              help="sealed: a rig of foreign structure with a hidden effect. ros: the simulator's nodes, or with "
                   "--drive-rig a rig. FOLDER: somebody runs each programme and puts its log there.")  # fmt: skip
@click.option("--rounds", default=3, show_default=True, type=click.IntRange(1, 20), help="Largest number of tests.")
@click.option("--minutes", default=4.0, show_default=True, help="Longest time of a test.")
@click.option("--programmes", default=300, show_default=True, type=click.IntRange(2, 10000),
              help="Number of programmes that a plan compares.")  # fmt: skip
@click.option("--plan-first", is_flag=True,
              help="Plan the first test, too. By default it is the commissioning programme, where time and limits "
                   "allow it.")  # fmt: skip
@click.option("--wait", default=0.0, show_default=True, metavar="MINUTES",
              help="With a folder: wait so long for the next log.")  # fmt: skip
@click.option("--sealed-effect", "sealed_effects", multiple=True, metavar="NAME",
              help="With sealed: the hidden effect; repeatable once. [default: one drawn by the seed]")  # fmt: skip
@click.option("--size", default=1.5, show_default=True, help="With sealed: its size, in noise floors.")
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="NAME[:KEY=VALUE,...]",
    help="With ros: give the simulated rig an effect; repeatable.",
)
@click.option("--drive-rig", is_flag=True,
              help="With ros: drive the rig on the topics instead of a simulator. Top drive, block and pump will "
                   "move.")  # fmt: skip
@click.option("--namespace", default="/", show_default=True, metavar="/NAME",
              help="With --drive-rig: namespace of the rig's topics.")  # fmt: skip
@click.option("--seed", default=0, show_default=True, type=SEED,
              help="Of sealed and simulated rigs, plans and diagnoses.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("investigation"), show_default=True,
              help="Folder of all files; with --on FOLDER it is that folder, so leave it out.")  # fmt: skip
@units_option_with("field")
@json_option
def command(
    rig_path: Path, where: str, rounds: int, minutes: float, programmes: int, plan_first: bool, wait: float,
    sealed_effects: tuple[str, ...], size: float, effects: tuple[str, ...], drive_rig: bool, namespace: str, seed: int,
    output: Path,
    units: Units, as_json: bool,
) -> None:  # fmt: skip
    """Record, diagnose, plan a test, run it, and again, until the answer stands or nothing more can be learnt.

    The folder holds every log, diagnosis and programme; the same command goes on where its files end.
    """
    from slider_drilling.api.rigs import load_rig
    from slider_drilling.api.with_effect import with_effect
    from slider_drilling.console.streams import progress_stages
    from slider_drilling.investigation.belief_page import belief_page, investigation_json
    from slider_drilling.investigation.loop import InvestigationOptions, investigate
    from slider_drilling.investigation.sealed_source import opened, sealed_recorder, sealed_rig
    from slider_drilling.investigation.setup import (
        FOLDER,
        ROS,
        SEALED,
        InvestigationSetup,
        check_setup,
        keep_setup,
    )
    from slider_drilling.test_planning.drilling_plan import PlanTestOptions

    _refuse_ignored(where)
    _check_values(namespace, drive_rig, effects, size, sealed_effects, wait)
    plan = PlanTestOptions(minutes, evaluations=programmes, seed=seed)
    options = InvestigationOptions(rounds, not plan_first, plan, seed)
    rig = load_rig(rig_path)
    for effect in effects:
        with_effect(rig, effect)  # refused before anything is written
    source = where if where in (SEALED, ROS) else FOLDER
    folder = Path(where) if source == FOLDER else output
    driven = namespace if drive_rig else None
    setup = InvestigationSetup(source, rig, seed, sealed_effects or effects, size if source == SEALED else None, driven)
    check_setup(folder, setup)
    sealed = sealed_rig(rig, sealed_effects, size, seed) if source == SEALED else None
    keep_setup(folder, setup)
    record = sealed_recorder(sealed) if sealed is not None else _recorder(where, rig_path, effects, driven, wait, seed)
    with progress_stages() as report:
        found = investigate(folder, rig, record, options, units, report)
    if sealed is not None:
        found = replace(found, sealed=opened(sealed))
    page, tree = folder / "investigation.html", folder / "investigation.json"

    def write() -> tuple[Path, ...]:
        from slider_drilling.files.output_files import write_atomically
        from slider_drilling.pages import write_page

        write_page(page, belief_page(found, rig), units)
        text = json.dumps(investigation_json(found), indent=1, allow_nan=False)
        write_atomically(tree, f"{text}\n".encode())
        return page, tree

    write_and_print(investigation_json(found) if as_json else None, lambda: _print(found), write)


def _refuse_ignored(where: str) -> None:
    """Raise InputError for an option that the source would ignore."""
    from slider_drilling.errors import InputError
    from slider_drilling.investigation.setup import FOLDER, ROS, SEALED

    source = where if where in (SEALED, ROS) else FOLDER
    if source == FOLDER and where.lower() in (SEALED, ROS):
        raise InputError(f"--on {where}: write {where.lower()}; give a folder of that name as ./{where}")
    taken = {"sealed_effects": SEALED, "size": SEALED, "effects": ROS, "drive_rig": ROS, "wait": FOLDER}
    for name, flag in given_options().items():
        if taken.get(name, source) != source:
            raise InputError(f"{flag}: only with --on {taken[name]}; leave it out")
        if name == "output" and source == FOLDER:
            raise InputError(f"{flag}: leave it out; with --on {where} all files are in that folder")


def _check_values(
    namespace: str, drive_rig: bool, effects: Sequence[str], size: float, sealed_effects: Sequence[str], wait: float
) -> None:
    from slider_drilling.errors import InputError

    if effects and drive_rig:
        raise InputError("--effect: only with --on ros, of the simulated rig; leave it out with --drive-rig")
    if not re.fullmatch(r"/|(/[A-Za-z_][A-Za-z0-9_]*)+", namespace) or (namespace != "/" and not drive_rig):
        raise InputError(f"--namespace {namespace}: give a name such as /rig_7, with --drive-rig")
    if not 0.05 <= size <= 50.0 or len(sealed_effects) > 2:
        raise InputError(f"--size {size:g}: must be 0.05 to 50 noise floors, of one or two --sealed-effect")
    if not wait >= 0.0:
        raise InputError(f"--wait {wait:g}: must be 0 min or more")


def _recorder(
    where: str, rig_path: Path, effects: tuple[str, ...], driven: str | None, wait: float, seed: int
) -> Recorder:
    """Runs a programme on a rig behind topics, or waits until somebody has run it."""
    from slider_drilling.investigation.sealed_source import folder_recorder

    if where == "ros":
        # The noise of each log is its own.
        return lambda number, programme, log: run_on_ros(
            rig_path, programme, log, effects, driven, (seed + number - 1) % SEEDS
        )
    if wait <= 0.0:
        return folder_recorder

    def waiting(number: int, programme: Path, log: Path) -> bool:
        until = time.monotonic() + 60.0 * wait
        while not folder_recorder(number, programme, log) and time.monotonic() < until:
            time.sleep(_POLL_S)
        return log.is_file()

    return waiting


def run_on_ros(
    rig: Path, programme: Path, log: Path, effects: Sequence[str], driven: str | None, seed: int = 0
) -> bool:
    """Run a programme in a process of its own, so that a node that fails ends only its run.

    Args:
        rig: Rig file.
        programme: The programme.
        log: Path of its log.
        effects: Of the simulated rig.
        driven: Namespace of the rig to drive; None for the simulator's nodes.
        seed: Of the simulator's noise.

    Raises:
        InputError: The programme did not come to its end.
    """
    from slider_drilling.errors import InputError
    from slider_drilling.files.output_files import write_atomically
    from slider_drilling.process.own_path import worker_command

    folder = log.with_suffix(".run")
    if driven is not None:
        files = (str(rig), str(programme), str(folder), driven)
        call = worker_command("slider_drilling.nodes.rig_session", "main", *files)
    else:
        call = [sys.executable, "-m", "slider_drilling", "run", "--rig", str(rig), "--programme", str(programme),
                "--record", str(folder), "--seed", str(seed), "--json"]  # fmt: skip
        call += [part for effect in effects for part in ("--effect", effect)]
    printed, last, code = _run_shown(call)
    logs = sorted(folder.glob("*.mcap")) if folder.is_dir() else []
    if code == 1 and printed:
        reason = json.loads(printed)["programme"]["reason"]
        raise InputError(f"{programme}: aborted: {reason}; its log so far: {folder}")
    if code or not logs:
        raise InputError(f"{programme}: the run ended with code {code}: {last}")
    write_atomically(log, logs[-1].read_bytes())
    return True


def _run_shown(call: Sequence[str]) -> tuple[str, str, int]:
    """Run a process that moves a rig, and show at once what it says, such as that it waits for the rig.

    It is interrupted, and ends in order, where this process is interrupted by whatever signal, or dies.

    Args:
        call: The command.

    Returns:
        What it printed on stdout, its last line on stderr, and its exit code.
    """
    with subprocess.Popen(
        call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        env={**os.environ, PARENT_PID_VARIABLE: str(os.getpid())},
    ) as running:  # fmt: skip
        assert running.stderr is not None and running.stdout is not None
        last = "no log"
        try:
            for line in running.stderr:
                click.echo(line, err=True, nl=False)
                last = line.strip() or last
            printed = running.stdout.read()
        except BaseException:
            running.send_signal(signal.SIGINT)
            running.communicate()  # it stops the rig before nobody reads what it says
            raise
    return printed, last, running.returncode


def _print(found: Investigation) -> None:
    from slider_drilling.console.streams import stdout
    from slider_drilling.investigation.belief_page import sealed_sentence

    for each in found.rounds:
        names = ", ".join(each.answer.effects) or "no name"
        stdout().print(f"after log {each.number}: {each.answer.verdict}: {names}")
    stdout().print(found.ending)
    if found.sealed is not None:
        stdout().print(sealed_sentence(found.sealed))
