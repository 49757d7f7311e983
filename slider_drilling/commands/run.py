"""`slider-drilling run`: simulator, controller and recorder over ROS 2 topics, in one process."""

from __future__ import annotations

import os
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import complete_effect, json_option, units_option, write_and_print
from slider_drilling.errors import InputError

if TYPE_CHECKING:
    from slider_drilling.nodes.session import SessionOptions, SessionResult
    from slider_drilling.units import Units

_FIRST_DOMAIN, _DOMAINS = 0, 50  # where a run looks for a ROS domain of its own
EXAMPLES = """\
Examples:

\b
  slider-drilling run --duration 300 --record out
  slider-drilling run --rig rig.yaml --target 45 --speed 1
  slider-drilling run --controller my_control:Mine --record out
  slider-drilling run --effect stribeck --set mud.density=1300 --record out
  slider-drilling run --live --twin
  slider-drilling run --programme commissioning --record out
"""


class Speed(click.ParamType):
    """Simulated seconds per second, or `max`."""

    name = "1|max"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if value == "max":
            return 0.0
        try:
            speed = float(str(value))
        except ValueError:
            self.fail(f"{value!r} is neither a number nor max", param, ctx)
        if not 0.001 <= speed <= 1000.0:
            self.fail(f"{value}: must be within 0.001 to 1000, or max", param, ctx)
        return speed


@click.command(epilog=EXAMPLES)
@click.option("--rig", type=click.Path(path_type=Path), help="Rig file. [default: the 4 km example well]")
@click.option("--duration", type=float, help="Simulated time, s. [default: 300; with --live: until Ctrl-C]")
@click.option("--speed", type=Speed(),
              help="Simulated seconds per second; max: lockstep. [default: max; with --live: 1]")  # fmt: skip
@click.option("--record", type=click.Path(path_type=Path), help="Folder for the log, its page and its picture.")
@click.option("--target", type=float, help="Toolface to hold, deg. [default: 0]")
@click.option("--controller", help="module:Class of another controller, built as Class(rig).")
@click.option("--programme", metavar="FILE",
              help="Run a programme, or a slide sheet, in place of a controller; commissioning and stand are built in.")
@click.option("--seed", default=0, show_default=True, help="Seed of the sensor noise.")
@click.option("--elements", default=200, show_default=True, help="Elements of the string, 10 to 5000.")
@click.option("--effect", "effects", multiple=True, metavar="NAME[:KEY=VALUE,...]", shell_complete=complete_effect,
              help="Give the simulated rig an effect that the rig file does not have; repeatable.")
@click.option("--set", "sets", multiple=True, metavar="NAME=VALUE",
              help="Change a key of the rig file (mud.density) or a setting of the controller (gain); repeatable.")
@click.option("--twin", is_flag=True, help="Run a twin beside the rig: it says live what differs, since when and why.")
@click.option("--live", is_flag=True, help="Serve a live page with controls.")
@click.option("--live-host", default="127.0.0.1", show_default=True,
              help="Address of the live page; any other needs a token.")  # fmt: skip
@click.option("--live-port", default=8765, show_default=True, help="Port of the live page; 0: a free one.")
@click.option("--live-token-file", default="",
              help="File of the live page's token, made if it is missing. [default: a temporary one if needed]")
@json_option
@units_option
def command(
    rig: Path | None, duration: float | None, speed: float | None, record: Path | None, target: float | None,
    controller: str | None, programme: str | None, seed: int, elements: int, effects: tuple[str, ...],
    sets: tuple[str, ...], twin: bool, live: bool, live_host: str, live_port: int, live_token_file: str,
    as_json: bool, units: Units,
) -> int:  # fmt: skip
    """Simulate a slide: friction simulator, rocking controller and recorder over ROS 2 topics.

    Prints a summary at the end. Topics can be watched from another terminal of this machine.
    """
    if programme is not None and not (controller is None and target is None):
        raise InputError("--programme: cannot be used with --controller or --target; it gives both")
    from slider_drilling.commands.overrides import apply_changes, controller_settings

    if programme is not None and (settings := controller_settings(sets)):
        name, value = next(iter(settings.items()))
        raise InputError(f"--set {name}={value}: a programme has no settings; keys of the rig file have a dot")
    if duration is None:
        duration = 0.0 if live or programme is not None else 300.0
    elif not 0.0 < duration <= 1e7:
        raise InputError(f"--duration = {duration}: must be above 0 and at most 1e7 s")
    _check(target, seed, elements)
    from slider_drilling.nodes import environment

    environment.prepare()
    _take_free_domain()
    from slider_drilling.api.rigs import load_rig
    from slider_drilling.commands.programme_file import prepare_programme
    from slider_drilling.control.tool_face_target import target_in_rad
    from slider_drilling.live.server import Address
    from slider_drilling.nodes.session import SessionOptions
    from slider_drilling.rig import check_duration

    with tempfile.TemporaryDirectory(prefix="slider_drilling_") as scratch:
        changed = apply_changes(rig, sets, effects, controller, Path(scratch))
        run_file = None
        if programme is not None:
            run_file = prepare_programme(programme, load_rig(changed.rig or None), Path(scratch))
        if duration > 0.0:
            check_duration(load_rig(changed.rig or None), duration, changed.rig or "the example well")
        plan = SessionOptions(
            rig=changed.rig, plant=changed.plant, duration=duration,
            speed=(1.0 if live else 0.0) if speed is None else speed,
            record=Path(scratch) if record is None else record,
            target=None if target is None else target_in_rad(target, "--target"),
            controller=controller, programme="" if run_file is None else str(run_file.path), seed=seed,
            elements=elements, settings=changed.settings, notes=changed.notes,
            live=Address(live_host, live_port, live_token_file).checked() if live else None, units=units.name,
            twin=twin,
        )
        outcome = _run(plan, 0.0 if run_file is None else run_file.nominal_time)
        _report(outcome, record is not None, as_json, units)
    if outcome.signal:
        return 128 + outcome.signal
    return 1 if outcome.programme is not None and outcome.programme.reason else 0


def _take_free_domain() -> None:
    """Use the first ROS domain without a simulated rig, unless ROS_DOMAIN_ID gives one."""
    from slider_drilling.console.streams import stderr
    from slider_drilling.nodes.simulator_lock import SimulatorLock

    if os.environ.get("ROS_DOMAIN_ID"):
        return
    for domain in range(_FIRST_DOMAIN, _FIRST_DOMAIN + _DOMAINS):
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        try:
            SimulatorLock("").release()
        except InputError:
            continue
        if domain > _FIRST_DOMAIN:
            stderr().print(f"another rig is simulated in ROS domain {_FIRST_DOMAIN}; this one runs in domain {domain}: "
                           f"`export ROS_DOMAIN_ID={domain}` to see its topics")  # fmt: skip
        return
    del os.environ["ROS_DOMAIN_ID"]  # the simulator says what to do


def _check(target: float | None, seed: int, elements: int) -> None:
    if target is not None:
        from slider_drilling.control.tool_face_target import target_in_rad

        target_in_rad(target, "--target")
    if not 0 <= seed < 2**31:
        raise InputError(f"--seed = {seed}: must be within 0 to {2**31 - 1}")
    if not 10 <= elements <= 5000:
        raise InputError(f"--elements = {elements}: must be within 10 to 5000")


def _run(plan: SessionOptions, nominal_time: float) -> SessionResult:
    """Run with a progress bar in simulated seconds; nominal_time: of the programme, s."""
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeRemainingColumn

    from slider_drilling.console.streams import progress_bar, stderr
    from slider_drilling.nodes.session import run_session

    def announce(address: str) -> None:
        stderr().print(f"live page: {address}  (Ctrl-C ends the run)")

    if plan.live is not None:
        # No progress bar: the live page shows the progress, and Ctrl-C ends the run.
        return run_session(plan, announce=announce)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(),
               TextColumn("{task.completed:.0f} of {task.total:.0f} s"), TimeRemainingColumn())
    with progress_bar(*columns) as progress:
        task = progress.add_task("compiling the plant, the first time only", total=plan.duration or nominal_time)
        return run_session(plan, lambda simulated: progress.update(task, completed=simulated, description="sliding"))


def _report(outcome: SessionResult, keep: bool, as_json: bool, units: Units) -> None:
    """Print the summary; write page and picture beside a log that is kept."""
    from slider_drilling.console.streams import stderr, stdout
    from slider_drilling.log import read_log
    from slider_drilling.log.run_page import write_run_page, write_run_picture
    from slider_drilling.log.run_summary import run_summary_table, summarise_run

    if outcome.log is None or outcome.messages == 0:
        stderr().print("interrupted before the first sample: nothing was recorded")
        return
    log = read_log(outcome.log)
    summary = summarise_run(log)
    more: tuple[tuple[str, str], ...] = ()
    if outcome.programme is not None:
        more = (("programme", str(outcome.programme)),)
    if outcome.wall > 0.0:
        more += (("took", f"{outcome.wall:.1f} s, {outcome.simulated / outcome.wall:.1f} times real time"),)
    for note in log.notes:
        stderr().print(f"{outcome.log.name}: {note}")
    page, picture = (outcome.log.with_suffix(suffix) for suffix in (".html", ".png"))

    def write() -> tuple[Path, ...]:
        if not keep:
            return ()
        write_run_page(page, log, summary, more, units)
        write_run_picture(picture, log, units)
        return log_file, page, picture

    log_file, interrupted = outcome.log, outcome.signal > 0
    figures: dict[str, object] = {"simulated_s": outcome.simulated, "wall_s": outcome.wall, "interrupted": interrupted}
    if outcome.programme is not None:
        figures["programme"] = {**asdict(outcome.programme), "state": outcome.programme.state.value}
    write_and_print({**figures, "summary": asdict(summary)} if as_json else None,
            lambda: stdout().print(run_summary_table(summary, more, units)), write)  # fmt: skip
