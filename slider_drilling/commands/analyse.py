"""`slider-drilling analyse`: the friction in a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from slider_drilling.commands.options import (
    json_option,
    namespace_option,
    topics_option,
    units_option,
    write_and_print,
)
from slider_drilling.commands.weight_options import read_weights, weight_options

if TYPE_CHECKING:
    from slider_drilling.api.analyse import AnalysisResult
    from slider_drilling.units import Units


@click.command(epilog="Example:\n\n  slider-drilling analyse run.mcap -o analysis")
@click.argument("log", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("analysis"), show_default=True,
              help="Folder for analysis.json, .html, .png and .csv.")  # fmt: skip
@click.option("--rig", "rig_path", type=click.Path(path_type=Path), help="Rig file instead of the log's own.")
@click.option(
    "--elements", default=100, show_default=True, type=click.IntRange(10, 5000), help="Elements of the string."
)
@weight_options
@namespace_option
@topics_option
@units_option
@json_option
def command(
    log: Path, output: Path, rig_path: Path | None, elements: int, namespace: str | None, topics_path: Path | None,
    units: Units, as_json: bool, **weights: Any,
) -> None:  # fmt: skip
    """Find the friction in LOG: by hole interval, at breakover, along the hole, and what it does to the weight.

    Pick-up, slack-off and rotating weights and the free torque, typed in, from a table or found in the log, give the
    friction of cased and open hole a second time.
    """
    from slider_drilling.api.analyse import analyse
    from slider_drilling.console.streams import progress_stages, stderr
    from slider_drilling.files.output_files import check_outputs
    from slider_drilling.log import read_log
    from slider_drilling.paper_studies.render import study_files

    check_outputs(study_files("analysis", output), (log, rig_path, topics_path, weights["weights_path"]))
    record = read_log(log, rig_path, namespace, topics_path)
    rig = None if record.rig_text is None else record.rig()
    readings = read_weights(None if rig is None else rig.string.length, weights)
    with progress_stages() as report:
        result = analyse(record, rig, weights=readings, block_weight=weights["block_weight"], elements=elements,
                         progress=report)  # fmt: skip
    for text in result.analysis.undetermined:
        stderr().print(f"not found: {units.convert_text(text)}")
    write_and_print(result.tree if as_json else None, lambda: _print(result, units),
                    lambda: result.save(output, units))  # fmt: skip


def _print(result: AnalysisResult, units: Units) -> None:
    from slider_drilling.analysis.report import analysis_study
    from slider_drilling.commands.options import print_tables

    print_tables(analysis_study(result.analysis, units).tables, units)
