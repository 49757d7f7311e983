"""Plan the next run: the programme within the limits that leaves least to find out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.experiment_design.criterion import Prospect, planned_information, prospect
from slider_drilling.gap.experiment_design.detectable_size import ProbedShape
from slider_drilling.gap.experiment_design.information import Information
from slider_drilling.gap.experiment_design.knowledge import Knowledge
from slider_drilling.gap.experiment_design.search import minimise
from slider_drilling.gap.model import Manoeuvre, Programmes, Values

# Share of a limit that a planned run may use, in the model and with everything that may be off.
LIMIT_SHARE = 0.9
# Loss of a programme that uses a whole limit: more than any other, so that a search finds its way back.
_FORBIDDEN = 1e6
# Share of a limit from which it is written as a multiple.
_MANY_TIMES = 10.0
# Use of the limits by a run that cannot be simulated.
_UNSTABLE = 100.0
# Shapes of an effect, and amplitudes of each, that the search looks at: more programmes gain more than more of these.
# The result is computed with all of them.
_SHAPES, _POINTS = 1, 1


@dataclass(frozen=True)
class PlannedRun:
    """The run to make next.

    Attributes:
        manoeuvre: What to do, and the model that simulates it.
        prospect: What is known after it.
        limit_use: Largest share of a limit that it uses, over everything that may be off.
    """

    manoeuvre: Manoeuvre = field(repr=False)
    prospect: Prospect
    limit_use: float

    @property
    def duration(self) -> float:
        """s."""
        return float(self.manoeuvre.model.runs[0].time[-1])


@dataclass(frozen=True)
class TestPlan:
    """A plan beside its alternatives.

    Attributes:
        knowledge: What was known before.
        without: What is known without any run; None before any log.
        planned: The run with the smallest loss (`Prospect.loss`).
        fixed: Runs to compare with, by name, routine operation first; empty where none was asked for.
        evaluations: Number of programmes that were compared.
    """

    __test__ = False  # the name is no test of pytest's

    knowledge: Knowledge = field(repr=False)
    without: Prospect | None
    planned: PlannedRun
    fixed: dict[str, PlannedRun]
    evaluations: int

    @property
    def baseline(self) -> Prospect:
        """What is known without the plan: after the logs so far, or after routine operation of equal length."""
        return self.without if self.without is not None else next(iter(self.fixed.values())).prospect

    @property
    def baseline_beyond_limits(self) -> bool:
        """Whether the baseline is a run that the limits do not allow."""
        return self.without is None and next(iter(self.fixed.values())).limit_use > LIMIT_SHARE


class NoProgrammeError(ValueError):
    """No programme stays within the limits.

    Args:
        gentlest: The run that uses the smallest share of a limit.
        evaluations: Number of programmes that were compared.
        used: The share that it uses.

    Attributes:
        gentlest: The run that uses the smallest share of a limit.
        figures: How much it uses, in words.
    """

    def __init__(self, gentlest: Manoeuvre, evaluations: int, used: float) -> None:
        self.gentlest = gentlest
        most = f"{100.0 * LIMIT_SHARE:.0f} % is the most"
        share = f"{100.0 * used:.0f} % of" if used < _MANY_TIMES else f"{used:.0f} times"
        gentlest_uses = f"of {evaluations}, the gentlest uses {share}"
        self.figures = f"{gentlest_uses} it, and {most}"
        super().__init__(f"no programme stays within the limits: {gentlest_uses} one, and {most}")


def plan_run(
    knowledge: Knowledge,
    programmes: Programmes,
    *,
    evaluations: int = 150,
    seed: int = 0,
    compare: bool = True,
    progress: Callable[[float], None] = lambda share: None,
) -> TestPlan:
    """The programme within the limits with the smallest loss (`Prospect.loss`).

    Args:
        knowledge: What is known so far.
        programmes: What may be done.
        evaluations: Number of programmes to compare.
        seed: Of the search.
        compare: Whether the fixed programmes are assessed, too; before any log the first one is in any case.
        progress: Called with the share done.

    Raises:
        NoProgrammeError: No programme stays within the limits.
        ValueError: The answer so far cannot be simulated beyond its logs.
    """
    knowledge = _that_can_be_simulated(knowledge, programmes)
    some = [shape for shape in knowledge.shapes(_SHAPES, _POINTS) if shape.effect.fidelity == 0]

    def loss(values: Values) -> float:
        manoeuvre = programmes.programme(values)
        used = limit_use(knowledge, programmes, manoeuvre)
        if used > LIMIT_SHARE:
            return _FORBIDDEN * used
        return prospect(knowledge, planned_information(knowledge, manoeuvre, some), some).loss

    found = minimise(loss, programmes.variables, programmes.starts, evaluations, seed, progress)
    if found.loss > _FORBIDDEN * LIMIT_SHARE:
        raise NoProgrammeError(programmes.programme(found.values), found.evaluations, found.loss / _FORBIDDEN)
    every = knowledge.shapes()
    planned = assess(knowledge, programmes, programmes.programme(found.values), every)
    runs = list(programmes.fixed.items())
    if not compare:
        runs = runs[:1] if knowledge.information is None else []
    fixed = {name: assess(knowledge, programmes, run, every) for name, run in runs}
    planned = min((planned, *_as_long(fixed)), key=lambda run: run.prospect.loss)
    without = None
    if knowledge.information is not None:
        without = prospect(knowledge, _with_explanations(knowledge), every)
    return TestPlan(knowledge, without, planned, fixed, found.evaluations)


def _as_long(fixed: Mapping[str, PlannedRun]) -> list[PlannedRun]:
    """The fixed runs within the limits that take no longer than routine operation, the first of them, does."""
    if not fixed:
        return []
    longest = next(iter(fixed.values())).duration
    return [run for run in fixed.values() if run.limit_use <= LIMIT_SHARE and run.duration <= longest]


def assess(
    knowledge: Knowledge, programmes: Programmes, manoeuvre: Manoeuvre, shapes: Sequence[ProbedShape] = ()
) -> PlannedRun:
    """A run with the information that it is expected to give.

    Args:
        knowledge: What is known so far.
        programmes: For the limits.
        manoeuvre: The run.
        shapes: Shapes of the effects to look at; all by default.
    """
    chosen = shapes or knowledge.shapes()
    known = prospect(knowledge, planned_information(knowledge, manoeuvre, chosen), chosen)
    return PlannedRun(manoeuvre, known, limit_use(knowledge, programmes, manoeuvre))


def limit_use(knowledge: Knowledge, programmes: Programmes, manoeuvre: Manoeuvre) -> float:
    """Largest share of a limit that a run uses, over `uncertain_values`."""
    used = programmes.limit_use(manoeuvre, uncertain_values(knowledge))
    return float(np.max(used)) if np.isfinite(used).all() else _UNSTABLE


def uncertain_values(knowledge: Knowledge) -> list[Values]:
    """Parameter values that limits hold for: of the explanations, and with every free parameter off by its spread.

    Parameters without a prior, and those of single runs, stay as they are.
    """
    sets: list[Values] = [knowledge.values, *(explanation.values for explanation in knowledge.explanations)]
    for sign in (-1.0, 1.0):
        moved = dict(knowledge.values)
        for each in knowledge.parameters:
            if np.isfinite(each.spread) and not each.per_run:
                value = moved.get(each.name, each.nominal) + sign * each.spread
                moved[each.name] = float(np.clip(value, each.lower, each.upper))
        sets.append(moved)
    return sets


def _that_can_be_simulated(knowledge: Knowledge, programmes: Programmes) -> Knowledge:
    """The knowledge without explanations whose simulation of routine operation does not end.

    Raises:
        ValueError: The answer itself is one of these.
    """
    routine = next(iter(programmes.fixed.values()))
    explanations = knowledge.explanations
    use = programmes.limit_use(routine, [knowledge.values, *(each.values for each in explanations)])
    if not np.isfinite(use[0]):
        raise ValueError("the answer so far cannot be simulated beyond its logs")
    kept = tuple(each for each, share in zip(explanations, use[1:], strict=True) if np.isfinite(share))
    return replace(knowledge, explanations=kept)


def _with_explanations(knowledge: Knowledge) -> Information:
    """The information of the logs, in which the explanations make no difference that they have not made already."""
    assert knowledge.information is not None
    known = knowledge.information
    nothing = tuple(explanation.change for explanation in knowledge.explanations)
    count = len(nothing)
    empty = Information(nothing, 0, np.zeros((count, count)), {}, np.zeros(0))
    return known + empty
