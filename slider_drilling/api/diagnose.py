"""`diagnose`: why logs and the simulator differ."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from slider_drilling.api.replay import as_log
from slider_drilling.api.simulate import Run
from slider_drilling.api.what_changed import ChangeRequest, diagnose_what_changed
from slider_drilling.columns import Columns, TableExport
from slider_drilling.diagnosis import diagnose as engine
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer, earlier_answer, read_earlier_answer
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.diagnosis.save import write_diagnosis
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.errors import InputError
from slider_drilling.files.paths import as_path
from slider_drilling.gap.progress import Progress
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.schema.option_types import check_argument
from slider_drilling.units import SI, Units

if TYPE_CHECKING:
    import plotly

    from slider_drilling.diagnosis.user_effects import UserEffect

LogLike = str | os.PathLike[str] | RigLog | Run


@dataclass(frozen=True, repr=False)
class DiagnosisResult(TableExport):
    """The answer of a diagnosis.

    Attributes:
        diagnosis: All of it.
        tree: The content of diagnosis.json.
    """

    diagnosis: Diagnosis
    tree: dict[str, Any]

    @property
    def verdict(self) -> str:
        """``none``, ``parameters``, ``effect``, ``effect_and_unknown``, ``unknown`` or ``inconclusive``."""
        return self.diagnosis.verdict

    @property
    def summary(self) -> str:
        """The answer in a driller's words."""
        return str(self.tree["summary"])

    @property
    def technical_summary(self) -> str:
        """The answer with code names and E."""
        return str(self.tree["technical_summary"])

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that the verdict rests on; empty if there are none."""
        return tuple(self.tree["effects"])

    @property
    def tuned_rig(self) -> Rig:
        """The rig with calibrated parameters and the named effects."""
        return engine.tuned_rig(self.diagnosis)

    def __repr__(self) -> str:
        return f"DiagnosisResult({self.verdict}: {self.summary})"

    def columns(self) -> Columns:
        """The ranking: effect, site, share of the gap that it closes with its 95 % interval, passed, in_answer."""
        ranking = self.tree["ranking"]
        low, high = ([row["interval"][side] if row["interval"] else None for row in ranking] for side in (0, 1))
        numbers = {"closed": [row["closed"] for row in ranking], "closed_low": low, "closed_high": high}
        return Columns({
            "effect": np.array([row["effect"] for row in ranking], dtype=object),
            "site": np.array([row["site"] for row in ranking], dtype=object),
            **{name: np.array(values, dtype=float) for name, values in numbers.items()},
            **{name: np.array([row[name] for row in ranking], dtype=bool) for name in ("passed", "in_answer")},
        })  # fmt: skip

    def save(self, folder: str | os.PathLike[str], units: Units = SI) -> list[Path]:
        """Write diagnosis.json, rig.tuned.yaml, report.html and the programme to run next; returns their paths.

        Without a programme to run, an old next_programme.yaml in the folder is deleted.

        Args:
            folder: Created if it does not exist.
            units: Units of the page, `slider_drilling.units.SI` or `FIELD`.

        Raises:
            InputError: A file cannot be written.
        """
        return write_diagnosis(self.diagnosis, Path(folder), units)

    def plot(self) -> plotly.graph_objects.Figure:
        """The share of the gap that each effect of the ranking closes, with its 95 % interval."""
        from slider_drilling.api.plots import bars

        columns = self.columns().values
        intervals = list(zip(columns["closed_low"], columns["closed_high"], strict=True))
        return bars(columns["effect"].tolist(), columns["closed"].tolist(), intervals, "share of the gap closed")


def diagnose(
    logs: LogLike | Sequence[LogLike],
    rig: Rig | None = None,
    *,
    only: Sequence[str] = (),
    effects: Sequence[UserEffect] = (),
    until: float = 1.0,
    seed: int = 0,
    after: DiagnosisResult | str | os.PathLike[str] | None = None,
    progress: Progress = lambda stage, share: None,
    baseline: LogLike | Sequence[LogLike] | None = None,
    since: float | Literal["auto"] | None = None,
) -> DiagnosisResult:
    """Find out where logs of one rig and the simulator differ, which effect explains it, and how much it closes.

    With a baseline, or a time since when something may be different, it finds out what has changed. The rig's
    calibrated numbers and the effects that it always had are then shared by what was before and what came after.

    Args:
        logs: One or several paths, logs or runs. Several are fitted together.
        rig: The rig file to compare with; the logs' own if None.
        only: Names of the catalogue's effects to consider; all if empty.
        effects: Effects of your own, in addition.
        until: Fraction of every log that is fitted, from its start.
        seed: Seed of the bootstrap.
        after: The diagnosis of some of these logs, or of others of the rig, to start from; or its path.
        progress: Called with the stage and the fraction done.
        baseline: Logs from before a change.
        since: Time in s from the log's start, from when on something may be different; ``"auto"`` to find it.

    Raises:
        InputError: A log cannot be diagnosed, or the logs' rig files differ.
    """
    check_argument(until, float, "diagnose: until")
    check_argument(seed, int, "diagnose: seed")
    if since != "auto":
        check_argument(since, float | None, "diagnose: since")
    records, earlier = _records(logs, "no logs"), () if baseline is None else _records(baseline, "no baseline")
    nominal = _common_rig([*records, *earlier], rig)
    if earlier or since is not None:
        request = ChangeRequest(tuple(records), tuple(earlier), since, tuple(only), seed)
        request.check(until, bool(effects), after is not None)
        diagnosis = diagnose_what_changed(request, nominal, progress)
        return DiagnosisResult(diagnosis, to_json(diagnosis))
    diagnosis = engine.diagnose(
        records, nominal, seed=seed, user_effects=effects, only=only, until=until,
        after=None if after is None else as_earlier_answer(after), progress=progress,
    )  # fmt: skip
    return DiagnosisResult(diagnosis, to_json(diagnosis))


def _records(logs: LogLike | Sequence[LogLike], missing: str) -> list[RigLog]:
    given = list(logs) if isinstance(logs, Iterable) and not isinstance(logs, (str, bytes)) else [logs]
    if not given:
        raise InputError(f"diagnose: {missing}: give at least one")
    return [as_log(log) for log in given]


def _common_rig(records: Sequence[RigLog], rig: Rig | None) -> Rig:
    """The rig file given, or the one that all logs share."""
    nominal = records[0].rig() if rig is None else rig
    if rig is None:
        for record in records[1:]:
            if record.rig() != nominal:
                raise InputError(
                    f"{record.source}: its rig file differs from that of {records[0].source}; "
                    "give the one to use (rig)"
                )
    return nominal


def as_earlier_answer(given: DiagnosisResult | str | os.PathLike[str]) -> EarlierAnswer:
    """A diagnosis as the start of the next. Raises InputError."""
    if isinstance(given, DiagnosisResult):
        return earlier_answer(given.tree, "the diagnosis")
    return read_earlier_answer(as_path(given, "diagnosis"))
