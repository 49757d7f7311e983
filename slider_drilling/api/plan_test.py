"""`plan_test`: the test programme that shows most of a rig."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slider_drilling.api.diagnose import DiagnosisResult, LogLike, as_earlier_answer
from slider_drilling.api.replay import as_log
from slider_drilling.columns import Columns, TableExport
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import make_folder, write_atomically
from slider_drilling.log import RigLog
from slider_drilling.pages import write_page
from slider_drilling.programmes import Programme, dump_programme
from slider_drilling.rig import Rig
from slider_drilling.schema.option_types import check_argument
from slider_drilling.test_planning.drilling_plan import DrillingPlan, PlanTestOptions, plan_after, plan_before_logs
from slider_drilling.test_planning.plan_json import plan_json
from slider_drilling.test_planning.plan_page import plan_page
from slider_drilling.units import FIELD, Units

FILES = ("test_programme.yaml", "test_plan.html", "test_plan.json")


@dataclass(frozen=True, repr=False)
class TestPlanResult(TableExport):
    """A planned test.

    Attributes:
        plan: All of it.
        tree: The content of test_plan.json.
    """

    __test__ = False  # the name is no test of pytest's

    plan: DrillingPlan
    tree: dict[str, Any]

    def __repr__(self) -> str:
        return f"TestPlanResult({len(self.tree['steps'])} steps, {self.tree['duration_s']:.0f} s)"

    @property
    def programme(self) -> Programme:
        """What the crew does."""
        return self.plan.programme

    def columns(self) -> Columns:
        """A row for each effect, the least visible first."""
        rows = self.tree["effects"]
        words = ("name", "parameter", "unit", "limited_by")
        numbers = ("without", "with_plan", "usual", "power_without", "power_with", "ratio")
        return Columns({
            **{name: np.array([row[name] for row in rows], dtype=object) for name in words},
            **{name: np.array([np.nan if row[name] is None else row[name] for row in rows]) for name in numbers},
        })  # fmt: skip

    def save(self, folder: str | os.PathLike[str], units: Units = FIELD) -> list[Path]:
        """Write the programme, the page and the JSON; returns their paths.

        Args:
            folder: Created if it does not exist.
            units: Of the page.

        Raises:
            InputError: A file cannot be written.
        """
        make_folder(Path(folder))
        programme, page, tree = paths = [Path(folder) / name for name in FILES]
        write_atomically(programme, dump_programme(self.programme).encode())
        write_page(page, plan_page(self.plan), units)
        write_atomically(tree, f"{json.dumps(self.tree, indent=1, allow_nan=False)}\n".encode())
        return paths


def plan_test(
    rig: Rig | None = None,
    after: DiagnosisResult | str | os.PathLike[str] | None = None,
    *,
    logs: Sequence[LogLike] = (),
    options: PlanTestOptions | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> TestPlanResult:
    """Plan the test programme that shows most.

    Args:
        rig: The rig file; that of the diagnosis if None.
        after: A diagnosis, or the path of a diagnosis.json or its folder; None before any log.
        logs: The logs of the diagnosis, where they are neither at the paths that it names nor beside it.
        options: What the test may be.
        progress: Called with the share done.

    Raises:
        InputError: Something cannot be used.
    """
    check_argument(options, PlanTestOptions | None, "plan_test: options")
    chosen = options or PlanTestOptions()
    if after is None:
        if rig is None:
            raise InputError("plan-test: give a rig file, or a diagnosis or log to plan after")
        return _result(plan_before_logs(rig, chosen, progress))
    answer = as_earlier_answer(after)
    records = logs_of(answer, logs)
    return _result(plan_after(answer, records, rig or answer.rig() or records[0].rig(), chosen, progress))


def logs_of(answer: EarlierAnswer, given: Sequence[LogLike] = ()) -> list[RigLog]:
    """The logs of a diagnosis: those given, else those that it names (`_path_of_log`). Raises InputError."""
    if given and len(given) != len(answer.logs):
        raise InputError(f"{answer.source}: was made of {len(answer.logs)} logs, {len(given)} are given")
    return [as_log(log) for log in (given or [_path_of_log(answer, name) for name in answer.logs])]


def _path_of_log(answer: EarlierAnswer, name: str) -> Path:
    """Where a log of a diagnosis is.

    The path may start from the working directory, from the folder of diagnosis.json, or from the one above, in which
    `diagnose` was run by default. A log beside diagnosis.json is found by its file name alone.

    Args:
        answer: The diagnosis.
        name: Path of the log as the diagnosis names it.

    Raises:
        InputError: The log is at none of these places.
    """
    file, own = Path(answer.source), Path(name)
    places = [own]
    if file.is_file():
        folder = file.absolute().parent
        places += [folder / own, folder.parent / own, folder / own.name]
    found = next((place for place in places if place.exists()), None)
    if found is None:
        tried = ", ".join(dict.fromkeys(str(place.absolute()) for place in places))
        todo = f"put it beside {file.name}" if file.is_file() else "give the logs (logs=)"
        raise InputError(f"{answer.source}: log = {name!r}: is not there (looked for {tried}); {todo}")
    return found


def _result(plan: DrillingPlan) -> TestPlanResult:
    return TestPlanResult(plan, plan_json(plan))
