"""`slider-drilling identify`: contact parameters from measured friction."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from slider_drilling.commands.options import SEED, json_option, units_option, write_and_print
from slider_drilling.console.printable import printable
from slider_drilling.plain_names import plain_name

if TYPE_CHECKING:
    from slider_drilling.contact.identify import FrictionData, Identification
    from slider_drilling.pages import Table
    from slider_drilling.paper_studies.study import Study
    from slider_drilling.rig import Contact
    from slider_drilling.units import Text, Units

EPILOG = """\
DATA.csv is a table with a header line, in one of two forms.

\b
Against time, one row per sample; the contact starts undeformed:
  time_s, axial_m, normal_force_n, friction_n
  optional: tangential_m, tangential_friction_n
Against velocity, one row per steady experiment (mean friction):
  feed_m_per_s, vibration_m_per_s, frequency_hz, normal_force_n, friction_n
  optional: direction_deg (of the vibration, from the axis; 0 is longitudinal)
friction_n is positive where it resists motion down the axis.

\b
Example:
  slider-drilling identify DATA.csv --free dahl_exponent -o out
"""

UNITS = {"stiffness": "N/m", "minor_axis": "m", "major_axis": "m"}


@click.command(epilog=EPILOG)
@click.argument("data", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("identified"), show_default=True,
              help="Folder for identify.json, .html, .png and .csv.")  # fmt: skip
@click.option("--free", multiple=True, help="Also fit shear_factor, dahl_exponent or shape_factor; repeatable.")
@click.option("--height-um", type=click.FloatRange(0.0, min_open=True), default=5.09, show_default=True,
              help="Asperity height h, um; a and b refer to it.")  # fmt: skip
@click.option("--shear-factor", type=float, default=0.1, show_default=True, help="Shear factor f, if it is not fitted.")
@click.option("--shape-factor", type=float, default=3.141592653589793, show_default=True,
              help="Shape factor chi, if it is not fitted.")  # fmt: skip
@click.option("--particles", type=click.IntRange(4, 1000), default=24, show_default=True,
              help="Particles of the swarm.")  # fmt: skip
@click.option("--generations", type=click.IntRange(1, 10000), default=40, show_default=True,
              help="Generations of the swarm.")  # fmt: skip
@click.option("--seed", type=SEED, default=0, show_default=True, help="Seed of the swarm.")
@click.option("--jobs", type=click.IntRange(1, 64), default=2, show_default=True, help="Threads.")
@json_option
@units_option
def command(
    data: Path, output: Path, free: tuple[str, ...], height_um: float, shear_factor: float, shape_factor: float,
    particles: int, generations: int, seed: int, jobs: int, as_json: bool, units: Units,
) -> None:  # fmt: skip
    """Fit stiffness kt and the asperity's axes a and b (and others with --free) to friction measured in DATA.csv."""
    from rich.progress import Progress, TextColumn

    from slider_drilling.console.streams import progress_bar
    from slider_drilling.contact import PAPER, friction_table
    from slider_drilling.contact.identify import identify
    from slider_drilling.contact.measured_friction import read_measured
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.paper_studies.render import study_files, write_study
    from slider_drilling.rig import Contact
    from slider_drilling.schema.fields import build_dataclass, to_tree

    check_outputs(study_files("identify", output), (data,))
    held = replace(PAPER.asperity, height=1e-6 * height_um, shape_factor=shape_factor)
    base = build_dataclass(
        Contact, to_tree(replace(PAPER, asperity=held, shear_factor=shear_factor)), "identify: contact held"
    )
    friction_table(shear_factor, held)
    measured = read_measured(data)
    columns = (*Progress.get_default_columns(), TextColumn("misfit {task.fields[misfit]}"))
    with progress_bar(*columns) as progress:
        task = progress.add_task("particle swarm", total=generations, misfit="-")

        def report(generation: int, misfit: float) -> None:
            progress.update(task, completed=generation, misfit=f"{misfit:.4g} N")

        identification = identify(
            measured, free=free, base=base, particles=particles, generations=generations, seed=seed, workers=jobs,
            progress=report,
        )  # fmt: skip
    findings = _findings(data, identification, seed)
    page = _page(data, measured, identification)
    write_and_print(findings if as_json else None, lambda: _print(identification, units),
                    lambda: write_study(page, output, findings, units))  # fmt: skip


def _findings(path: Path, identification: Identification, seed: int) -> dict[str, Any]:
    estimates = {
        name: {"value": float(estimate.value), "determined": estimate.determined, "unit": UNITS.get(name, "-"),
               "interval": None if estimate.interval is None else [float(v) for v in estimate.interval]}
        for name, estimate in identification.estimates.items()
    }  # fmt: skip
    return {
        "schema": "slider_drilling/identification/1",
        "data": printable(path.name),
        "seed": seed,
        "estimates": estimates,
        "contact": _plain(identification.contact),
        "residual_rms_n": identification.residual_rms,
        "largest_error_over_peak": identification.largest_error,
        "degeneracies": list(identification.degeneracies),
        "evaluations": identification.evaluations,
    }


def _plain(contact: Contact) -> dict[str, Any]:
    tree = asdict(contact)
    tree["asperity"] = {name: float(value) for name, value in tree["asperity"].items()}
    return {name: value if isinstance(value, dict) else float(value) for name, value in tree.items()}


def _page(path: Path, data: FrictionData, identification: Identification) -> Study:
    import numpy as np

    from slider_drilling.contact.measured_friction import FrictionOverTime
    from slider_drilling.paper_studies.study import Study, curve, curve_chart

    if isinstance(data, FrictionOverTime):
        axis, label, against = data.time, "time, s", "samples of friction against time"
        measured, predicted = identification.measured[: axis.size], identification.predicted[: axis.size]
    else:
        against = "experiments of friction against velocity"
        axis, label = np.arange(1.0, data.feed.size + 1.0, dtype=np.float64), "experiment (row)"
        measured, predicted = identification.measured, identification.predicted
    peak = np.abs(measured).max()
    return Study(
        name="identify",
        about="Contact parameters",
        title=f"{axis.size} {against}",
        settings={
            "data": printable(path.name),
            "residual_rms_n": identification.residual_rms,
            "largest_error_over_peak": identification.largest_error,
        },
        figures=(
            curve_chart("Axial friction (Fig. 13)", label, "friction, N",
                  (curve("measured", axis, measured, colour=6), curve("model", axis, predicted, colour=0))),
            curve_chart("Error (Fig. 14)", label, "error, % of the largest friction",
                  (curve("model - measured", axis, 100.0 * (predicted - measured) / peak),)),
        ),
        claims=(),
        notes=identification.degeneracies,
        tables=(_table(identification),),
    )  # fmt: skip


def _table(identification: Identification) -> Table:
    """Each parameter with its 95 % interval."""
    from slider_drilling.pages import Quantity, Table
    from slider_drilling.units import sentence

    rows = []
    for name, estimate in identification.estimates.items():
        unit = UNITS.get(name, "-").removeprefix("-")
        interval: Text = "not determined"
        if estimate.interval is not None:
            low, high = (Quantity(end, unit, 5) for end in estimate.interval)
            interval = sentence(low, " to ", high)
        rows.append((plain_name(name), Quantity(estimate.value, unit, 5), interval))
    return Table(("parameter", "value", "95 % interval"), tuple(rows), "Parameters")


def _print(identification: Identification, units: Units) -> None:
    from slider_drilling.commands.options import print_tables
    from slider_drilling.console.streams import stderr, stdout

    print_tables((_table(identification),), units)
    error = f"largest error {100 * identification.largest_error:.1f} % of the peak"
    stdout().print(f"residual {units.format(identification.residual_rms, 'N', 4)} RMS; {error}")
    for sentence in identification.degeneracies:
        stderr().print(f"note: {sentence}")
