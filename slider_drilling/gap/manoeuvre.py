"""Which run to make next: the manoeuvre under which two explanations differ most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slider_drilling.gap.contender import Contender
from slider_drilling.gap.findings import Findings
from slider_drilling.gap.model import Array, Manoeuvre, Manoeuvring
from slider_drilling.gap.residuals import Problem, build_problem


@dataclass(frozen=True)
class NextManoeuvre:
    """separates: the two explanations; distance: how far they differ under it, RMS in noise units, beyond what the
    nuisance could make up for; now: the same in the log at hand; others: distance of every manoeuvre looked at.
    """

    description: str
    settings: dict[str, float]
    separates: tuple[str, str]
    distance: float
    now: float
    others: dict[str, float]


def next_manoeuvre(findings: Findings) -> NextManoeuvre | None:
    """Compare the two leading explanations under each manoeuvre that the model offers; None without rivals."""
    model = findings.problem.model
    pair = _rivals(findings)
    if pair is None or not isinstance(model, Manoeuvring):
        return None
    first, second = pair
    distances = {}
    offered = {manoeuvre.description: manoeuvre for manoeuvre in model.manoeuvres()}
    for description, manoeuvre in offered.items():
        distances[description] = _distance(_problem(findings, manoeuvre), first, second)
    best = max(distances, key=lambda description: distances[description])
    return NextManoeuvre(
        best, dict(offered[best].settings), (first.effect.name, second.effect.name), distances[best],
        _now(first, second), distances,
    )  # fmt: skip


def _rivals(findings: Findings) -> tuple[Contender, Contender] | None:
    """The accepted effect and what it cannot be told from; the two leading candidates where none was accepted."""
    contenders = [contender for contender in (findings.rounds[0] if findings.rounds else []) if contender.physical]
    if len(contenders) < 2:
        return None
    if not findings.accepted:
        return contenders[0], contenders[1]
    first = findings.accepted[0]
    group = findings.groups.get(first.effect.name, {})
    rival = next((contender for contender in contenders if contender.effect.name in group), None)
    return None if rival is None else (first, rival)


def _now(first: Contender, second: Contender) -> float:
    """How far two fits differ in the log at hand, in the floors of the first."""
    other = second.problem.in_floors_of(first.problem, second.fit.residual)
    return _apart(first.problem, first.fit.residual - other, first.fit.jacobian)


def _problem(findings: Findings, manoeuvre: Manoeuvre) -> Problem:
    """The manoeuvre's runs with the noise floors of the log at hand."""
    floors = findings.problem.floors[0]
    return build_problem(manoeuvre.model, [floors for _ in manoeuvre.model.runs])


def _distance(problem: Problem, first: Contender, second: Contender) -> float:
    """RMS difference of two fits in noise units under another excitation."""
    own = {parameter.name for parameter in first.effect.parameters}
    nuisance = [p for p in first.fit.parameters if p.name not in own and not p.per_run]
    # A next run starts from its own rest: what belonged to the log at hand only is not carried over.
    shared = [{k: v for k, v in contender.fit.values.items() if "@" not in k} for contender in (first, second)]
    sets = list(shared)
    sets += [shared[0] | {p.name: shared[0][p.name] + 0.1 * p.scale} for p in nuisance]
    simulated = problem.simulate(sets)
    jacobian = ((simulated[0] - simulated[2:]) / 0.1).T
    return _apart(problem, simulated[1] - simulated[0], jacobian)


def _apart(problem: Problem, difference: Array, jacobian: Array) -> float:
    weight = np.sqrt(problem.score)
    basis, _ = np.linalg.qr(weight[:, None] * jacobian)
    rest = weight * difference
    rest = rest - basis @ (basis.T @ rest)
    return float(np.linalg.norm(rest))
