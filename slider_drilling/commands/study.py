"""`slider-drilling study`: the paper's vibration tools, with figures, numbers and a verdict on each claim."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import json_option, print_json, print_listing, units_option, write_and_print

if TYPE_CHECKING:
    from slider_drilling.paper_studies.study import Study
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling study --list
  slider-drilling study rocking -o out
  slider-drilling study all -o out
"""


def _names(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    from slider_drilling.paper_studies.catalogue import STUDIES

    return [name for name in (*STUDIES, "all") if name.startswith(incomplete)]


@click.command(epilog=EXAMPLES)
@click.argument("name", required=False, shell_complete=_names)
@click.option("--list", "listing", is_flag=True, help="List the studies.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("studies"),
    show_default=True,
    help="Folder for the files.",
)
@click.option(
    "--jobs", default=2, show_default=True, type=click.IntRange(1, 64), help="Studies that `all` runs in parallel."
)
@units_option
@json_option
def command(name: str | None, listing: bool, output: Path, jobs: int, units: Units, as_json: bool) -> None:
    """Run study NAME, or `all`. Writes NAME.html, NAME.png, NAME.csv and NAME.json, and index.html for `all`.

    Ctrl-C (or SIGTERM) keeps finished studies; the exit code is then 130 (143).
    """
    from slider_drilling.errors import InputError
    from slider_drilling.paper_studies.catalogue import STUDIES
    from slider_drilling.paper_studies.render import as_json as claims_json
    from slider_drilling.paper_studies.render import study_files, write_index

    if listing and as_json:
        print_json({name: entry.about for name, entry in STUDIES.items()})
        return
    if listing:
        print_listing((name, entry.about) for name, entry in STUDIES.items())
        return
    if name is None:
        raise InputError("study: NAME is missing: name a study (see --list), or all")
    if name != "all" and name not in STUDIES:
        raise InputError(f"study: NAME = {name}: no such study; one of {', '.join(STUDIES)}, or all")
    names = list(STUDIES) if name == "all" else [name]
    finished = _run(names, output, jobs, units)
    ended = [finished[each] for each in names if each in finished]

    def show() -> None:
        for study, _ in ended:
            _print(study)

    def write() -> list[Path]:
        for _, why in ended:
            if why:
                raise InputError(why)
        index = [write_index([study for study, _ in ended], output, units)] if len(names) > 1 else []
        return [*(path for study, _ in ended for path in study_files(study.name, output)), *index]

    write_and_print({"studies": [claims_json(study) for study, _ in ended]} if as_json else None, show, write)


def _run(names: list[str], output: Path, jobs: int, units: Units) -> dict[str, tuple[Study, str]]:
    """Finished studies by name, each with the error of its files, if any."""
    from rich.progress import Progress, SpinnerColumn, TimeElapsedColumn

    from slider_drilling.console.streams import progress_bar, stderr
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.paper_studies.render import study_files
    from slider_drilling.process.worker_pool import map_in_processes

    check_outputs(path for name in names for path in study_files(name, output))
    columns = (SpinnerColumn(), *Progress.get_default_columns(), TimeElapsedColumn())
    finished: dict[str, tuple[Study, str]] = {}
    with progress_bar(*columns) as progress:
        task = progress.add_task("studies" if len(names) > 1 else names[0], total=len(names))
        calls = ((name, output, units) for name in names)
        try:
            for study, why in map_in_processes(_run_one, calls, min(jobs, len(names))):
                finished[study.name] = study, why
                progress.advance(task)
        except KeyboardInterrupt:
            if not finished:
                raise
            stderr().print(f"interrupted: {len(finished)} of {len(names)} studies")
    return finished


def _run_one(name: str, output: Path, units: Units) -> tuple[Study, str]:
    """Run a study and write its files in the worker, so that an interrupt keeps them."""
    from slider_drilling.errors import InputError
    from slider_drilling.paper_studies.catalogue import run_study
    from slider_drilling.paper_studies.render import write_study

    study = run_study(name)
    try:
        write_study(study, output, units=units)
    except InputError as error:
        return study, str(error)
    return study, ""


def _print(study: Study) -> None:
    from slider_drilling.console.streams import stdout

    stdout().print(f"{study.name}: {study.title}")
    for claim in study.claims:
        stdout().print(f"  {'holds        ' if claim.holds else 'does not hold'}  {claim.claim}")
