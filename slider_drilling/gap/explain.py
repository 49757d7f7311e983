"""From a model to an answer: noise floors, attribution, location, ranking, one sentence."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.attribute import attribute, tune_nuisance
from slider_drilling.gap.contender import Contender
from slider_drilling.gap.findings import Findings, gaps_before, start_findings, total_closed, verdict
from slider_drilling.gap.locate import Where, likely_site, locate
from slider_drilling.gap.manoeuvre import NextManoeuvre, next_manoeuvre
from slider_drilling.gap.model import Effect, Model, Values
from slider_drilling.gap.noise import NoiseFloor, lowered, noise_floor
from slider_drilling.gap.progress import Progress
from slider_drilling.gap.residuals import build_problem


@dataclass(frozen=True)
class Ranked:
    """One line of the ranking.

    closed: share of the tuned model's held-out gap that the effect closes alone (from the score test, without
    interval, when fitted is False); round: 1 for alone, 2 for beside one accepted before; group: who it
    cannot be told from; reasons: the tests it failed.
    """

    effect: str
    site: str
    closed: float
    interval: tuple[float, float]
    parameters: dict[str, float]
    fitted: bool
    accepted: bool
    physical: bool
    starts_agree: bool
    round: int
    group: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()

    def shown(self) -> tuple[str, str]:
        """The share closed and its interval as text; a dash where there is nothing to close."""
        low, high = self.interval
        interval = "screened only" if not self.fitted else "-" if np.isnan(low) else f"{low:.2f} to {high:.2f}"
        return "-" if np.isnan(self.closed) else f"{self.closed:.2f}", interval


@dataclass(frozen=True)
class Answer:
    """What the engine concludes; gaps are E, not E^2, held out where parameters were fitted."""

    verdict: str
    sentence: str
    site: str | None
    site_shares: dict[str, float]
    effects: tuple[str, ...]
    nominal: float
    tuned: float
    with_effect: float
    closed: float
    closed_interval: tuple[float, float]
    threshold: float
    floors: tuple[dict[str, NoiseFloor], ...]
    where: Where | None
    ranking: tuple[Ranked, ...]
    manoeuvre: NextManoeuvre | None
    parameters: dict[str, float]
    runtime: float
    partial: bool
    remarks: tuple[str, ...]
    findings: Findings = field(repr=False)


def explain(
    model: Model,
    *,
    seed: int = 0,
    starts: Sequence[Values] = ({},),
    effects: Sequence[Effect] | None = None,
    floors: Sequence[dict[str, NoiseFloor]] | None = None,
    scatter: int = 0,
    progress: Progress = lambda stage, share: None,
) -> Answer:
    """Diagnose a model against the runs it carries.

    starts: nuisance values to begin tuning from; effects: candidates, the model's catalogue by default; floors:
    noise per run and channel where the caller knows it better than the log; scatter: see `attribute`;
    progress(stage, share done).
    Raises ValueError when no channel can be used.
    """
    began = time.perf_counter()
    if floors is None:
        floors = [{channel.name: noise_floor(channel, run) for channel in run.channels} for run in model.runs]
        floors, starts = _lower_floors(model, floors, starts, seed, progress)
    findings = start_findings(build_problem(model, floors), seed)
    attribute(findings, seed=seed, starts=starts, effects=effects, scatter=scatter, progress=progress)
    return conclude(findings, time.perf_counter() - began)


def _lower_floors(
    model: Model, floors: list[dict[str, NoiseFloor]], starts: Sequence[Values], seed: int, progress: Progress
) -> tuple[list[dict[str, NoiseFloor]], Sequence[Values]]:
    """Tune once where a floor rests on cycles that may have drifted, and take it down to what the tuning reaches."""
    if not any(floor.method == "cycles" and floor.lag_correlation > 0.3 for run in floors for floor in run.values()):
        return floors, starts
    findings = start_findings(build_problem(model, floors), seed)
    tune_nuisance(findings, starts, progress, thorough=False)
    assert findings.tuned is not None
    problem, residual = findings.problem, findings.tuned.fit.residual
    better = []
    for index, run in enumerate(floors):
        reached = {
            n: f.sigma * float(np.sqrt(np.mean(residual[problem.slices[index, n]] ** 2))) for n, f in run.items()
        }
        better.append({name: lowered(floor, reached[name]) for name, floor in run.items()})
    return better, [findings.tuned.fit.values]


def conclude(findings: Findings, runtime: float) -> Answer:
    """The answer that the findings so far support."""
    conclusion = verdict(findings)
    closed, interval = total_closed(findings)
    site, shares = likely_site(findings)
    tuned, current = findings.tuned, findings.current
    nominal, retuned = gaps_before(findings)
    accepted = tuple(contender.effect.name for contender in findings.accepted)
    ranking = rank(findings)
    return Answer(
        verdict=conclusion,
        sentence=sentence(findings, conclusion, site, closed, interval),
        site=site if conclusion not in ("none", "parameters") else None,
        site_shares=shares,
        effects=accepted,
        nominal=nominal,
        tuned=retuned,
        with_effect=float(np.sqrt(current.score.gap_squared)) if current else float("nan"),
        closed=closed,
        closed_interval=interval,
        threshold=float(np.sqrt(findings.threshold.gap_squared)) if findings.threshold else float("nan"),
        floors=findings.problem.floors,
        where=locate(tuned) if tuned else None,
        ranking=ranking,
        manoeuvre=None if findings.partial else next_manoeuvre(findings),
        parameters=dict(current.fit.values) if current else {},
        runtime=runtime,
        partial=findings.partial,
        remarks=tuple(findings.remarks),
        findings=findings,
    )


def rank(findings: Findings) -> tuple[Ranked, ...]:
    """Accepted effects first, in the order of acceptance, then what was fitted, then what was only screened.

    Without shares where re-tuning leaves nothing to close.
    """
    entries: list[Ranked] = []
    for contender in findings.accepted:
        turn = next(i for i, contenders in enumerate(findings.rounds) if contender in contenders)
        entries.append(_ranked(contender, turn + 1, tuple(findings.groups.get(contender.effect.name, {}))))
    named = {entry.effect for entry in entries}
    first = findings.rounds[0] if findings.rounds else []
    for contender in sorted(first, key=lambda c: (not c.physical, c.score.surprise)):
        if contender.effect.name not in named:
            mates = tuple(name for name, group in findings.groups.items() if contender.effect.name in group)
            entries.append(_ranked(contender, 1, mates))
            named.add(contender.effect.name)
    if findings.tuned is not None and findings.screened:
        now = findings.tuned.fit.cost
        for candidate in findings.screened[0]:
            if candidate.effect.name not in named and now > 1.0:
                nothing = (float("nan"), float("nan"))
                share = candidate.promise / (now - 1.0)
                entries.append(
                    Ranked(
                        candidate.effect.name, candidate.effect.site, share, nothing, {}, False, False, True, False, 1
                    )
                )
    if findings.nothing_left and not findings.accepted:
        nowhere = float("nan"), float("nan")
        entries = [replace(entry, closed=float("nan"), interval=nowhere) for entry in entries]
    return tuple(entries)


def _ranked(contender: Contender, turn: int, group: tuple[str, ...]) -> Ranked:
    return Ranked(
        contender.effect.name, contender.effect.site, contender.closed, contender.interval, contender.parameters(),
        True, contender.accepted, contender.physical, contender.starts_agree, turn, group, contender.reasons,
    )  # fmt: skip


def sentence(
    findings: Findings, conclusion: str, site: str | None, closed: float, interval: tuple[float, float]
) -> str:
    """The verdict as one sentence."""
    tuned, current = findings.tuned, findings.current
    if conclusion == "inconclusive" or tuned is None or current is None:
        return "No conclusion: " + ("; ".join(findings.remarks) or "the fits did not converge") + "."
    gaps = "E = {:.2f} as given, {:.2f} re-tuned".format(*gaps_before(findings))
    if conclusion == "none":
        return f"The model as given explains the log down to its noise ({gaps})."
    if conclusion == "parameters":
        return f"The model is only mis-tuned: re-fitting its parameters reaches the noise ({gaps})."
    if conclusion == "unknown":
        return f"None of the known effects explains what re-tuning leaves ({gaps}); most of it points at the {site}."
    names = []
    for contender in findings.accepted:
        rivals = findings.groups.get(contender.effect.name, {})
        names.append(contender.effect.name + (f" (or {', '.join(rivals)}: not told apart)" if rivals else ""))
    share = "" if np.isnan(closed) else f" and closes {closed:.2f} [{interval[0]:.2f}, {interval[1]:.2f}] of the gap"
    if closed <= 0.0:
        share = " by the loss that decides, in which a missed spin of the bit counts once; E itself does not fall"
    end = "" if conclusion == "effect" else "; something structured remains"
    gaps += f", {np.sqrt(current.score.gap_squared):.2f} with it"
    return f"{' and '.join(names)} explains the gap{share} ({gaps}){end}."
