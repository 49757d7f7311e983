"""`slider-drilling closed-loop`: a controller on fixed scenarios or random rigs, scored by the true state."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.campaign_options import scheduler_option
from slider_drilling.commands.options import (
    json_option_with,
    print_json,
    print_listing,
    refuse_ignored,
    units_option,
    write_and_print,
)

if TYPE_CHECKING:
    from slider_drilling.slide_scenarios import Scenario, ScenarioResult
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling closed-loop -o out
  slider-drilling closed-loop --only "hold, 4.0 km" --json
  slider-drilling closed-loop --controller mine:Steering --set gain=1.5 -o out
  slider-drilling closed-loop --all --elements 60 -o out
  slider-drilling closed-loop --campaign 200 --controller mine:Steering --against fixed_rocking -o out
  slider-drilling closed-loop --slide 17 -o out
  slider-drilling closed-loop --faults --elements 40 -o out
  slider-drilling closed-loop --stands --elements 60 -o out
"""


@click.command(epilog=EXAMPLES)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write closed_loop.html and .json there.")
@json_option_with("Print JSON on stdout; the units are in the names.")
@click.option("--controller", "name", default="", help="Controller under test, module:Class.")
@click.option("--only", multiple=True, help="Scenario by name, or by the beginning of its name; repeatable.")
@click.option("--all", "every", is_flag=True,
              help="Add each effect of the catalogue at two sizes on three wells, and pairs of effects.")
@click.option("--faults", is_flag=True,
              help="Run lying sensors, washout, plugged nozzle and lost strokes instead, 40 minutes each: do weight, "
              "torque and pressure stay within their limits?")
@click.option("--stands", is_flag=True,
              help="Run programmes that drill a stand instead: rotate, orient, slide, leave, rotate on.")
@click.option("--set", "sets", multiple=True, metavar="NAME=VALUE",
              help="Change a setting of the controller under test (gain=1.5); repeatable.")
@click.option("--list", "listing", is_flag=True, help="List the scenarios and exit.")
@click.option("--elements", default=200, show_default=True, help="Elements of the string, 10 to 5000.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(min=0),
              help="Seed of sensor noise and faults.")
@click.option("--jobs", default=2, show_default=True, type=click.IntRange(1, 64), help="Number of processes.")
@click.option("--campaign", "slides", type=click.IntRange(1, 100000), metavar="N",
              help="Run N random rigs instead of the scenarios: statistics, the ten worst slides, paired comparison.")
@click.option("--against", multiple=True, default=("fixed_rocking",), show_default=True, metavar="NAME",
              help="With --campaign: compare with fixed_rocking, shifted_rocking, no_rocking or module:Class.")
@click.option("--slide", type=click.IntRange(0, 100000), metavar="K",
              help="Run slide K of the campaign with this --seed, with its time series.")
@click.option("--rig", "rig_path", type=click.Path(path_type=Path),
              help="With --campaign and --slide: rig file that strings, fluids and noise are drawn around.")
@click.option("--duration", type=click.FloatRange(300.0, 36000.0), metavar="S",
              help="With --campaign and --slide: of each slide, s.  [default: 900]")
@click.option("--foreign", is_flag=True,
              help="With --campaign and --slide: plants and instruments of foreign structure, not of the model's kind.")
@scheduler_option
@units_option
def command(
    output: Path | None, as_json: bool, name: str, only: tuple[str, ...], every: bool, faults: bool,
    stands: bool, sets: tuple[str, ...], listing: bool, elements: int, seed: int, jobs: int, slides: int | None,
    against: tuple[str, ...], slide: int | None, rig_path: Path | None, duration: float | None, foreign: bool,
    scheduler: str, units: Units,
) -> int:
    """Hold the toolface through every scenario; compare with no rocking and with fixed rocking.

    Ctrl-C (or SIGTERM) keeps the scenarios that have ended and exits with 130 (143).
    """
    from slider_drilling.campaign.run import WorkerSettings
    from slider_drilling.commands.closed_loop_campaign import drawn_scenario, run_campaign
    from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER
    from slider_drilling.errors import InputError
    from slider_drilling.files.installed_files import installed_file
    from slider_drilling.slide_scenarios.campaign import CampaignOptions

    if not 10 <= elements <= 5000:
        raise InputError(f"--elements = {elements}: must be within 10 to 5000")
    if stands:
        if every or faults or name or sets or rig_path or foreign or slides is not None or slide is not None:
            raise InputError("--stands: cannot be used with --all, --faults, --controller, --set, --rig, --foreign, "
                             "--campaign or --slide; give it alone or with --only")
        _refuse_ignored(None, None)
        from slider_drilling.commands.closed_loop_stands import list_stands, run_stands

        if listing:
            _list(list_stands(), as_json)
        else:
            run_stands(only, seed, elements, jobs, output, as_json, units)
        return 0
    if listing:
        _list([(scenario.name, scenario.about) for scenario in _known(every, faults)], as_json)
        return 0
    if faults and (every or slides is not None or slide is not None):
        raise InputError("--faults: cannot be used with --all, --campaign or --slide; give it alone or with --only")
    _refuse_ignored(slides, slide)
    name = name or DEFAULT_CONTROLLER
    options = CampaignOptions(rig_path or installed_file("config/rig.example.yaml"), seed, elements, foreign=foreign,
                              **({} if duration is None else {"duration": duration}))
    if slides is not None:
        if output is None:
            raise InputError("--campaign: give the folder for its results with -o; a repeated command resumes from it")
        if sets:
            raise InputError("--set cannot be used with --campaign; give a controller class with these settings")
        controllers = list(dict.fromkeys((name, *against)))
        workers = WorkerSettings(jobs, scheduler)
        return run_campaign(controllers, slides, options, workers, output, rig_path is not None, as_json, units)
    scenarios = _chosen(only, every, faults)
    if faults:
        from slider_drilling.commands.closed_loop_faults import run_faults

        run_faults(scenarios, name, sets, seed, elements, jobs, output, as_json, units)
        return 0
    if slide is not None:
        random_scenario, seed = drawn_scenario(slide, options)
        scenarios = [random_scenario]
    _run_and_write(scenarios, name, sets, seed, elements, jobs, output, as_json, units)
    return 0


def _list(scenarios: Iterable[tuple[str, str]], as_json: bool) -> None:
    """Print names and descriptions."""
    if as_json:
        print_json({"scenarios": [{"name": name, "about": about} for name, about in scenarios]})
    else:
        print_listing(scenarios)


def _run_and_write(
    scenarios: list[Scenario], name: str, sets: tuple[str, ...], seed: int, elements: int, jobs: int,
    output: Path | None, as_json: bool, units: Units,
) -> None:  # fmt: skip
    """Run the scenarios, then write the files and print the results."""
    from slider_drilling.commands.overrides import parse_settings
    from slider_drilling.console.streams import stderr
    from slider_drilling.files.output_files import check_outputs, make_folder, write_atomically
    from slider_drilling.pages import write_page
    from slider_drilling.slide_scenarios import report
    from slider_drilling.slide_scenarios.page import closed_loop_page

    if output is not None:
        make_folder(output)
        check_outputs((output / "closed_loop.json", output / "closed_loop.html"))
    settings = parse_settings(sets, name, scenarios[0].assumed_rig())
    results = _run(scenarios, seed, elements, name, jobs, settings)
    rows = report.by_scenario(results, scenarios)
    tree = report.as_json(rows, name, seed, elements)
    tree["partial"] = len(rows) < len(scenarios)
    if tree["partial"]:
        stderr().print(f"interrupted: {len(rows)} of {len(scenarios)} scenarios")

    def write() -> tuple[Path, ...]:
        if output is None:
            return ()
        write_atomically(output / "closed_loop.json", json.dumps(tree, indent=1).encode("utf-8"))
        write_page(output / "closed_loop.html", closed_loop_page(rows, name, seed, elements), units)
        return output / "closed_loop.json", output / "closed_loop.html"

    write_and_print(tree if as_json else None, lambda: print_results(rows, units), write)


def _known(every: bool, faults: bool) -> tuple[Scenario, ...]:
    from slider_drilling.slide_scenarios import SCENARIOS, every_effect

    if faults:
        from slider_drilling.slide_scenarios.fault_scenarios import FAULTS

        return FAULTS
    return (*SCENARIOS, *every_effect()) if every else SCENARIOS


def _refuse_ignored(slides: int | None, slide: int | None) -> None:
    """Raise InputError for an option that the kind of run would ignore."""
    if slides is not None:
        kind, ignored = "with --campaign", {"only", "every", "slide"}
    elif slide is not None:
        kind, ignored = "with --slide", {"only", "every", "against", "scheduler"}
    else:
        kind, ignored = "without --campaign or --slide", {"against", "rig_path", "duration", "foreign", "scheduler"}
    refuse_ignored(kind, ignored)


def _chosen(only: tuple[str, ...], every: bool, faults: bool) -> list[Scenario]:
    from slider_drilling.errors import InputError

    known = _known(every, faults)
    for start in only:
        if not any(scenario.name.startswith(start) for scenario in known):
            raise InputError(f"--only = {start!r}: no scenario starts with this; see --list, or --all --list")
    return [scenario for scenario in known if not only or scenario.name.startswith(only)]


def _run(
    scenarios: list[Scenario], seed: int, elements: int, name: str, jobs: int, settings: dict[str, float]
) -> list[ScenarioResult]:
    from slider_drilling.console.streams import progress_bar
    from slider_drilling.slide_scenarios import contender_pairs, run_all

    results: list[ScenarioResult] = []
    with progress_bar("{task.description}", "{task.completed}/{task.total}") as progress:
        pairs = contender_pairs(scenarios)
        task = progress.add_task("slides", total=len(pairs))
        try:
            for result in run_all(pairs, seed, elements, name, jobs, settings):
                results.append(result)
                progress.advance(task)
        except KeyboardInterrupt:
            if not results:
                raise
    return results


def print_results(rows: list[dict[str, ScenarioResult]], units: Units) -> None:
    """Print the table, the interlocks that stopped a slide, and what rig file and MWD cost."""
    from rich.table import Table

    from slider_drilling.console.streams import stdout
    from slider_drilling.slide_scenarios.contenders import UNDER_TEST
    from slider_drilling.slide_scenarios.report import information_costs, interlock_stops, terminal_header, terminal_row
    from slider_drilling.units import quantities_in

    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False)
    for index, label in enumerate(terminal_header(units)):
        table.add_column(label, justify="right" if index else "left", no_wrap=bool(index), overflow="fold")
    for row in rows:
        table.add_row(*terminal_row(row, units))
    stdout().print(table)
    for row in rows:
        for time, name, message in interlock_stops(row):
            said = units.convert_text(quantities_in(message))
            stdout().print(f"{row[UNDER_TEST].scenario.name}, {time:.0f} s: {name}: {said}", markup=False)
    if sentence := information_costs(rows):
        stdout().print(sentence)
