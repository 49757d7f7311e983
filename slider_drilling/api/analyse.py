"""`analyse`: the friction in a log, and where it acts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slider_drilling.analysis.analyse import Analysis
from slider_drilling.analysis.analyse import analyse as engine
from slider_drilling.analysis.driller_weights import DrillerWeights
from slider_drilling.analysis.fit_friction import ELEMENTS
from slider_drilling.analysis.report import analysis_study, to_json
from slider_drilling.api.checks import check_elements
from slider_drilling.api.replay import as_log
from slider_drilling.columns import Columns, TableExport
from slider_drilling.paper_studies.render import write_study
from slider_drilling.rig import Rig
from slider_drilling.schema.option_types import check_argument
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    from slider_drilling.api.diagnose import LogLike
    from slider_drilling.gap.progress import Progress


@dataclass(frozen=True, repr=False)
class AnalysisResult(TableExport):
    """The friction in a log.

    Attributes:
        analysis: All of it.
        tree: The content of analysis.json.
    """

    analysis: Analysis
    tree: dict[str, Any]

    def __repr__(self) -> str:
        rows = self.analysis.fit.intervals if self.analysis.fit else ()
        friction = ", ".join(f"{row.kind} {row.factor:.3f}" for row in rows)
        return f"AnalysisResult({self.analysis.log.source}: {friction or 'no rig file, surface torque only'})"

    def columns(self) -> Columns:
        """Friction of every hole interval: from, to, factor with its 95 % interval, and the factor's source."""
        fit, calibration = self.analysis.fit, self.analysis.calibration
        sources = [("log", row) for row in (fit.intervals if fit else ())]
        sources += [("weights", row) for row in (calibration.intervals if calibration else ())]
        values = {
            "source": np.array([source for source, _ in sources], dtype=object),
            "hole": np.array([row.kind for _, row in sources], dtype=object),
            "from": np.array([row.top for _, row in sources]),
            "to": np.array([row.bottom for _, row in sources]),
            "factor": np.array([row.factor for _, row in sources]),
            "factor_low": np.array([row.factor_interval[0] for _, row in sources]),
            "factor_high": np.array([row.factor_interval[1] for _, row in sources]),
        }
        return Columns(values, {"from": "m", "to": "m"})

    def save(self, folder: str | os.PathLike[str], units: Units = SI) -> list[Path]:
        """Write analysis.html, .png, .csv and .json; returns their paths.

        Args:
            folder: Created if it does not exist.
            units: Of page and picture.

        Raises:
            InputError: A file cannot be written.
        """
        return write_study(analysis_study(self.analysis, units), Path(folder), self.tree, units)


def analyse(
    log: LogLike,
    rig: Rig | None = None,
    *,
    weights: Sequence[DrillerWeights] = (),
    block_weight: float | None = None,
    elements: int = ELEMENTS,
    progress: Progress | None = None,
) -> AnalysisResult:
    """Find the friction in a log: by hole interval, at breakover, along the hole, and from the driller's weights.

    Args:
        log: A log, or where it is.
        rig: Instead of the log's own.
        weights: The driller's readings off bottom; empty for those that the log holds.
        block_weight: Of block, top drive and hoses in the hook loads, N; 0 if tared; None: found out where clear.
        elements: Of the string.
        progress: Called with the step's name and the fraction that is done.

    Raises:
        InputError: The log holds no surface torque, or something else cannot be used.
    """
    check_elements(elements, "analyse")
    check_argument(block_weight, float | None, "analyse: block_weight")
    record = as_log(log)
    if rig is None and record.rig_text is not None:
        rig = record.rig()
    analysis = engine(record, rig, elements, progress, weights, block_weight)
    return AnalysisResult(analysis, to_json(analysis))
