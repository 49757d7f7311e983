"""Plan a test programme for a rig, before any log or after a diagnosis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite

from slider_drilling.diagnosis.build_model import model_without_logs
from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.drilling_programmes import DrillingManoeuvre, DrillingProgrammes, programme_limits
from slider_drilling.diagnosis.earlier_answer import EarlierAnswer, knowledge_of
from slider_drilling.drillstring import Response
from slider_drilling.errors import InputError
from slider_drilling.gap.experiment_design.knowledge import Knowledge, before_any_log
from slider_drilling.gap.experiment_design.plan import (
    NoProgrammeError,
    PlannedRun,
    TestPlan,
    plan_run,
    uncertain_values,
)
from slider_drilling.log import RigLog
from slider_drilling.programmes import Programme
from slider_drilling.programmes.limits import LimitError, StepLimits, check_on_rig, check_ranges
from slider_drilling.rig import Rig
from slider_drilling.schema.option_types import check_option_types

MINUTES = 6.0
EVALUATIONS = 300
"""Programmes that a plan compares by default."""
_SHORTEST, _LONGEST = 1.0, 30.0  # min
# By name of a limit in a run (`ProgrammeLimits.use`), the argument that sets it, and its unit.
_ARGUMENTS = {
    "torque to the right": ("right_torque", "N m"), "torque to the left": ("left_torque", "N m"),
    "weight on bit": ("weight_on_bit", "N"), "standpipe pressure": ("pressure", "Pa"),
    "toolface": ("tool_face_swing", "rad"),
}  # fmt: skip


@dataclass(frozen=True)
class PlanTestOptions:
    """What a test may be.

    Attributes:
        minutes: Longest time that it may take.
        limits: That differ from what the rig file implies.
        tool_face_swing: rad that the toolface may swing to either side; infinite if it may be lost.
        evaluations: Number of programmes to compare.
        seed: Of the search.

    Raises:
        InputError: A number is out of range.
    """

    minutes: float = MINUTES
    limits: StepLimits = StepLimits()
    tool_face_swing: float = inf
    evaluations: int = EVALUATIONS
    seed: int = 0

    def __post_init__(self) -> None:
        check_option_types(self, "plan_test")
        if not _SHORTEST <= self.minutes <= _LONGEST:
            raise InputError(f"minutes {self.minutes:g}: must be {_SHORTEST:g} to {_LONGEST:g} min")
        if not self.tool_face_swing > 0.0:
            raise LimitError("tool_face_swing", self.tool_face_swing, "rad", "must be above 0")
        check_ranges(self.limits)
        if self.evaluations < 2:
            raise InputError(f"programmes: {self.evaluations} are none to choose from; compare at least 2")


@dataclass(frozen=True)
class DrillingPlan:
    """A planned test of a rig.

    Attributes:
        rig: The rig file.
        options: What the test may be.
        plan: The engine's plan.
        programmes: What may be done, with the limits.
        after: The answer that it follows; None before any log.
    """

    rig: Rig
    options: PlanTestOptions
    plan: TestPlan = field(repr=False)
    programmes: DrillingProgrammes = field(repr=False)
    after: EarlierAnswer | None = None

    @property
    def programme(self) -> Programme:
        """What the crew does, with the limits in force."""
        return replace(programme_in(self.plan.planned), limits=self.options.limits)

    @property
    def response(self) -> Response:
        """What the rig does in the programme, by the likeliest explanation so far."""
        return self.programmes.responses(self.plan.planned.manoeuvre, [self.plan.knowledge.values])[0]


def programme_in(run: PlannedRun) -> Programme:
    """The programme of a planned run."""
    manoeuvre = run.manoeuvre
    assert isinstance(manoeuvre, DrillingManoeuvre)
    return manoeuvre.programme


def plan_before_logs(
    rig: Rig, options: PlanTestOptions, progress: Callable[[float], None] = lambda share: None
) -> DrillingPlan:
    """The test that shows most of a rig of which there is no log.

    Raises:
        InputError: A limit cannot be used on this rig, or no programme stays within the limits.
    """
    check_on_rig(options.limits, rig)
    model = model_without_logs(rig, 60.0 * options.minutes)
    return _plan(model, before_any_log(model), options, None, progress)


def plan_after(
    answer: EarlierAnswer,
    logs: Sequence[RigLog],
    rig: Rig,
    options: PlanTestOptions,
    progress: Callable[[float], None] = lambda share: None,
) -> DrillingPlan:
    """The test that distinguishes the explanations of a diagnosis, and shows what its logs could not.

    Args:
        answer: The diagnosis.
        logs: The logs that it was made of.
        rig: The rig file that it was made with.
        options: What the test may be.
        progress: Called with the share done.

    Raises:
        InputError: The answer is that of another rig file, a log or a limit cannot be used, or no programme stays
            within the limits.
    """
    answer.check_rig(rig)
    check_on_rig(options.limits, rig)
    if not answer.explanations:
        return plan_before_logs(rig, options, progress)
    model, knowledge = knowledge_of(answer, logs, rig)
    return _plan(model, knowledge, options, answer, progress)


def _plan(
    model: DrillString, knowledge: Knowledge, options: PlanTestOptions, after: EarlierAnswer | None,
    progress: Callable[[float], None],
) -> DrillingPlan:  # fmt: skip
    programmes = replace(
        model.programmes(60.0 * options.minutes),
        limits=programme_limits(model.rig, options.limits, options.tool_face_swing),
    )
    try:
        plan = plan_run(
            knowledge, programmes, evaluations=options.evaluations, seed=options.seed, progress=progress
        )  # fmt: skip
    except NoProgrammeError as error:
        raise _limit_in_the_way(error, knowledge, programmes) from None
    except ValueError as error:
        raise InputError(f"plan-test: {error}") from None
    return DrillingPlan(model.rig, options, plan, programmes, after)


def _limit_in_the_way(error: NoProgrammeError, knowledge: Knowledge, programmes: DrillingProgrammes) -> InputError:
    """The error that names the limit of which the gentlest programme uses most."""
    worst: dict[str, float] = {}
    limits = programmes.limits
    for shares in programmes.shares_of_limits(error.gentlest, uncertain_values(knowledge)):
        if not all(isfinite(share) for share in shares.values()):
            return InputError("plan-test: no programme can be simulated with what is uncertain of this rig; check its "
                              "rig file")  # fmt: skip
        worst = {name: max(share, worst.get(name, share)) for name, share in shares.items()}
    name, unit = _ARGUMENTS[max(worst, key=lambda each: worst[each])]
    value = limits.tool_face_swing if name == "tool_face_swing" else getattr(limits.steps, name)
    return LimitError(name, value, unit, f"no programme stays within this limit: {error.figures}; allow more")
