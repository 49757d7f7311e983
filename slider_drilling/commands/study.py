"""`slider-drilling study`: the paper's systems, each with figures, numbers and a verdict on what the paper says."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import units_option

if TYPE_CHECKING:
    from slider_drilling.tools.study import Study
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling study --list
  slider-drilling study rocking -o out
  slider-drilling study all -o out
"""


@click.command(epilog=EXAMPLES)
@click.argument("name", required=False)
@click.option("--list", "listing", is_flag=True, help="List the studies and leave.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("studies"),
    show_default=True,
    help="Directory that the files are written to.",
)
@click.option(
    "--jobs", default=2, show_default=True, type=click.IntRange(1, 64), help="Studies run at a time by `all`."
)
@units_option
def command(name: str | None, listing: bool, output: Path, jobs: int, units: Units) -> None:
    """Run study NAME, or `all`: writes NAME.html, NAME.png, NAME.csv and NAME.json; for `all` index.html besides.

    Ctrl-C (or SIGTERM) keeps the studies that have ended; the exit code is then 130 (143).
    """
    from slider_drilling.errors import InputError
    from slider_drilling.tools.catalogue import STUDIES

    if listing:
        for entry_name, entry in STUDIES.items():
            click.echo(f"{entry_name:16} {entry.about}")
        return
    if name is None:
        raise InputError("study: NAME is missing: name a study (see --list), or all")
    if name != "all" and name not in STUDIES:
        raise InputError(f"study: NAME = {name}: no such study; one of {', '.join(STUDIES)}, or all")
    _run(list(STUDIES) if name == "all" else [name], output, jobs, units)


def _run(names: list[str], output: Path, jobs: int, units: Units) -> None:
    from joblib import Parallel, delayed
    from rich.progress import Progress, SpinnerColumn, TimeElapsedColumn

    from slider_drilling.console import progress_bar, stderr, stdout
    from slider_drilling.files import prepare_outputs
    from slider_drilling.tools.render import study_files

    prepare_outputs(path for name in names for path in study_files(name, output))
    columns = (SpinnerColumn(), *Progress.get_default_columns(), TimeElapsedColumn())
    finished: dict[str, Study] = {}
    with progress_bar(*columns) as progress:
        task = progress.add_task("studies" if len(names) > 1 else names[0], total=len(names))
        work = Parallel(n_jobs=min(jobs, len(names)), return_as="generator_unordered")
        try:
            for study in work(delayed(_run_one)(name, output, units) for name in names):
                finished[study.name] = study
                progress.advance(task)
        except KeyboardInterrupt:
            if not finished:
                raise
            stderr().print(f"interrupted: {len(finished)} of {len(names)} studies")
    for name in names:
        if name in finished:
            _print(finished[name], output)
    if len(names) > 1:
        from slider_drilling.tools.render import write_index

        index = write_index([finished[name] for name in names if name in finished], output, units)
        stdout().print(f"all of them: {index}")


def _run_one(name: str, output: Path, units: Units) -> Study:
    from slider_drilling.tools.catalogue import run_study
    from slider_drilling.tools.render import write_study

    study = run_study(name)
    write_study(study, output, units=units)
    return study


def _print(study: Study, output: Path) -> None:
    from slider_drilling.console import stdout

    stdout().print(f"{study.name}: {output / study.name}.html, .png, .csv, .json")
    for claim in study.claims:
        stdout().print(f"  {'holds        ' if claim.holds else 'does not hold'}  {claim.claim}")
