"""`closed_loop`: a controller scored in fixed scenarios."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling.api.checks import check_elements, check_seed
from slider_drilling.columns import Columns, TableExport
from slider_drilling.control.controller_loader import DEFAULT_CONTROLLER
from slider_drilling.drillstring import ELEMENTS
from slider_drilling.errors import InputError
from slider_drilling.schema.option_types import check_argument
from slider_drilling.slide_scenarios import SCENARIOS, ScenarioResult, contender_pairs, report, run_all
from slider_drilling.slide_scenarios.contenders import UNDER_TEST
from slider_drilling.slide_scenarios.page import closed_loop_page
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import plotly

_UNITS = {"peak_torque_n_m": "N m", "weight_spread_n": "N", "rop_m_h": "m/h"}


@dataclass(frozen=True, repr=False)
class ClosedLoopResult(TableExport):
    """A controller in scenarios, beside no rocking, constant rocking, and controllers that know more.

    Attributes:
        controller: Its name, module:Class.
        rows: Contender -> result for each scenario.
        seed: Of sensor noise and faults.
        elements: Of the string.
    """

    controller: str
    rows: tuple[dict[str, ScenarioResult], ...]
    seed: int
    elements: int

    @property
    def tree(self) -> dict[str, Any]:
        """The content of closed_loop.json."""
        return report.as_json(self.rows, self.controller, self.seed, self.elements)

    def __repr__(self) -> str:
        errors = [row[UNDER_TEST].score.mean_abs_error_deg for row in self.rows]
        return f"ClosedLoopResult({self.controller} in {len(errors)} scenarios: mean error {np.mean(errors):.1f} deg)"

    def columns(self) -> Columns:
        """One row for each scenario and contender: every score, in the unit that its name ends with."""
        results = [(name, result) for row in self.rows for name, result in row.items()]
        scores = [asdict(result.score) for _, result in results]
        values = {key: np.array([np.nan if score[key] is None else score[key] for score in scores], dtype=float)
                  for key in scores[0]}  # fmt: skip
        scenarios, contenders = [result.scenario.name for _, result in results], [name for name, _ in results]
        texts = {"scenario": np.array(scenarios, dtype=object), "contender": np.array(contenders, dtype=object)}
        return Columns({**texts, **values}, {key: unit for key, unit in _UNITS.items() if key in values})

    def plot(self, scenario: int = 0, units: Units = SI) -> plotly.graph_objects.Figure:
        """Toolface error, top drive, torque and weight on bit of one scenario. Raises InputError without plotly."""
        from slider_drilling.pages.notebook import plotly_figure
        from slider_drilling.slide_scenarios.page import scenario_chart

        return plotly_figure(scenario_chart(self.rows[scenario]), units)

    def save_page(self, path: str | os.PathLike[str], units: Units = SI) -> Path:
        """Write the page; returns its path.

        Args:
            path: The HTML file.
            units: `slider_drilling.units.SI` or `FIELD`.

        Raises:
            InputError: The file cannot be written.
        """
        from slider_drilling.pages import write_page

        write_page(Path(path), closed_loop_page(self.rows, self.controller, self.seed, self.elements), units)
        return Path(path)


def closed_loop(
    controller: str = DEFAULT_CONTROLLER,
    *,
    only: str | Sequence[str] = (),
    settings: Mapping[str, float] | None = None,
    seed: int = 0,
    elements: int = ELEMENTS,
    workers: int = 2,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> ClosedLoopResult:
    """Score a controller in fixed scenarios, without ROS.

    Args:
        controller: ``"module:Class"``; it is built in other processes.
        only: Scenarios by name, or by the beginning of their names; all if empty.
        settings: Settings of the controller that differ from its defaults.
        seed: Of sensor noise and faults.
        elements: Elements of the string.
        workers: Number of processes.
        progress: Called with the number of slides that have ended and of all.

    Raises:
        InputError: An argument cannot be used, or the controller cannot be built or fails.
    """
    check_argument(controller, str, "closed_loop: controller")
    check_seed(seed, "closed_loop")
    check_elements(elements, "closed_loop")
    check_argument(workers, int, "closed_loop: workers")
    check_argument(settings, Mapping | None, "closed_loop: settings")
    starts = (only,) if isinstance(only, str) else tuple(only)
    scenarios = [each for each in SCENARIOS if not starts or each.name.startswith(starts)]
    if not scenarios:
        raise InputError(f"closed_loop: only = {only!r}: no scenario starts with this; known are "
                         f"{', '.join(repr(each.name) for each in SCENARIOS)}")  # fmt: skip
    pairs = contender_pairs(scenarios)
    results = []
    for result in run_all(pairs, seed, elements, controller, workers, settings or {}):
        results.append(result)
        progress(len(results), len(pairs))
    return ClosedLoopResult(controller, tuple(report.by_scenario(results, scenarios)), seed, elements)
