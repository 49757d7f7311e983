"""`slider-drilling plan-test`: the test programme that shows most of a rig."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from slider_drilling.commands.options import SEED, json_option, print_tables, units_option_with, write_and_print
from slider_drilling.commands.quantity import QuantityType

if TYPE_CHECKING:
    from slider_drilling.api.diagnose import DiagnosisResult
    from slider_drilling.api.plan_test import TestPlanResult
    from slider_drilling.gap.progress import Progress
    from slider_drilling.programmes import StepLimits
    from slider_drilling.units import Units

EXAMPLES = """\
Examples:

\b
  slider-drilling plan-test --rig rig.yaml
  slider-drilling plan-test --rig rig.yaml --minutes 4 --right-torque 20kN.m -o test
  slider-drilling plan-test --after diagnosis/diagnosis.json
  slider-drilling plan-test --after monday.mcap
  slider-drilling run --programme test_plan/test_programme.yaml --record out
"""


@click.command(epilog=EXAMPLES)
@click.option("--rig", "rig_path", type=click.Path(path_type=Path),
              help="Rig file. [default: that of the diagnosis or log]")  # fmt: skip
@click.option("--after", type=click.Path(path_type=Path), metavar="DIAGNOSIS|LOG",
              help="Plan after a diagnosis (diagnosis.json or its folder), or after a log, which is diagnosed "
                   "first.")  # fmt: skip
@click.option("--minutes", default=6.0, show_default=True, help="Longest time that the test may take.")
@click.option("--right-torque", type=QuantityType("N m", "20kN.m"), help="Limit. [default: the rig file's]")
@click.option("--left-torque", type=QuantityType("N m", "12kN.m"), help="Limit. [default: the rig file's]")
@click.option("--weight-on-bit", type=QuantityType("N", "150kN"), help="Limit. [default: the rig file's]")
@click.option("--pressure", type=QuantityType("Pa", "240bar"), help="Limit at the standpipe. [default: the rig file's]")
@click.option("--toolface-swing", type=QuantityType("rad", "30deg"),
              help="Largest swing of the toolface to either side. [default: it may be lost]")  # fmt: skip
@click.option("--programmes", default=300, show_default=True, type=click.IntRange(2, 10000),
              help="Number of programmes to compare.")  # fmt: skip
@click.option("--seed", default=0, show_default=True, type=SEED, help="Of the search; the same seed, the same plan.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("test_plan"), show_default=True,
              help="Folder for test_programme.yaml, test_plan.html and test_plan.json.")  # fmt: skip
@units_option_with("field")
@json_option
def command(
    rig_path: Path | None, after: Path | None, minutes: float, right_torque: float | None, left_torque: float | None,
    weight_on_bit: float | None, pressure: float | None, toolface_swing: float | None, programmes: int, seed: int,
    output: Path, units: Units, as_json: bool,
) -> None:  # fmt: skip
    """Plan the test programme that distinguishes causes.

    Before any log: the programme within the limits with which the least visible effect shows best, while everything
    that is calibrated stays free. After a log or a diagnosis: the programme that distinguishes what may explain it, and
    shows what it could not.
    """
    from slider_drilling.api.plan_test import FILES, plan_test
    from slider_drilling.api.rigs import load_rig
    from slider_drilling.console.streams import progress_stages
    from slider_drilling.errors import InputError
    from slider_drilling.files.output_files import check_outputs, make_folder
    from slider_drilling.programmes import StepLimits
    from slider_drilling.programmes.limits import LimitError, check_on_rig
    from slider_drilling.test_planning.drilling_plan import PlanTestOptions

    if rig_path is None and after is None:
        raise InputError("plan-test: give --rig RIG, or --after DIAGNOSIS or LOG")
    limits = StepLimits(right_torque, left_torque, weight_on_bit, pressure)
    swing = math.inf if toolface_swing is None else toolface_swing
    try:
        options = PlanTestOptions(minutes, limits, swing, programmes, seed)
        rig = None if rig_path is None else load_rig(rig_path)
        if rig is not None:
            check_on_rig(limits, rig)
        make_folder(output)
        check_outputs([output / name for name in FILES], (rig_path, after))
        with progress_stages() as report:
            known = None if after is None else _diagnosed(after, rig_path, limits, report)
            result = plan_test(rig, known, options=options,
                               progress=lambda share: report("comparing programmes", share))  # fmt: skip
    except LimitError as error:
        option = error.name.replace("tool_face", "toolface").replace("_", "-")
        raise InputError(f"--{option} {error.reason}") from None
    write_and_print(result.tree if as_json else None, lambda: _print(result, units),
                    lambda: result.save(output, units))  # fmt: skip


def _diagnosed(
    after: Path, rig_path: Path | None, limits: StepLimits, report: Progress
) -> Path | DiagnosisResult:
    """The diagnosis at a path, or that of the log there, whose rig must allow the limits."""
    from slider_drilling.api.diagnose import diagnose
    from slider_drilling.api.rigs import load_rig
    from slider_drilling.log import read_log
    from slider_drilling.programmes.limits import check_on_rig

    is_answer = after.suffix == ".json" or (after.is_dir() and (after / "diagnosis.json").is_file())
    if is_answer:
        return after
    log = read_log(after, rig_path)
    rig = log.rig() if rig_path is None else load_rig(rig_path)
    check_on_rig(limits, rig)
    answer = diagnose([log], None if rig_path is None else rig, progress=report)
    if answer.diagnosis.interrupted:
        raise KeyboardInterrupt  # no test follows from half an answer
    return answer


def _print(result: TestPlanResult, units: Units) -> None:
    from slider_drilling.console.streams import stdout
    from slider_drilling.pages import Table
    from slider_drilling.test_planning.effect_sizes import cannot_tell
    from slider_drilling.test_planning.plan_page import plan_page

    page = plan_page(result.plan)
    if page.headline is not None:
        stdout().print(units.convert_text(page.headline.text))
    for section in page.sections:
        print_tables([item for item in section.items if isinstance(item, Table)], units)
    for line in cannot_tell(result.plan):
        stdout().print(units.convert_text(line))
