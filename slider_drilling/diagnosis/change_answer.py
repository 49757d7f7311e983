"""What a search for a change supports: a name, a group, changed numbers, or an unknown difference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.diagnosis.baseline import Baseline
from slider_drilling.diagnosis.change_search import (
    ChangeSearch,
    TriedChange,
    changed_beside,
    only_wandered,
)
from slider_drilling.diagnosis.changed_string import ChangedString
from slider_drilling.diagnosis.usual_error import counted, counts_of, usual_gap, usual_gaps
from slider_drilling.gap.evidence.compare import share_closed
from slider_drilling.gap.model import Array
from slider_drilling.gap.problem.problem import Piece, Problem
from slider_drilling.gap.results.intervals import (
    SPREAD_OF_ANSWERS,
    TWO_SIDED_95,
    deviations_from_none,
    parameter_intervals,
    user_values,
)
from slider_drilling.gap.search.least_squares import Fit, linearised_at_its_end
from slider_drilling.plain_names import plain_name

# Gain of ``-2 log p`` from which a candidate has evidence, and from which it is suspected. A likelihood ratio of that
# size is beyond chance; without a change, only the model's own error in a manoeuvre that the baseline lacks exceeds it.
MIN_EVIDENCE, MIN_SUSPICION = 50.0, 20.0
# Candidates are indistinguishable within this gain, or this share of the best one's.
_SAME_GAIN, _SAME_SHARE = 12.0, 0.2
# E that a named change may leave, relative to calibration without it; and share of the difference that it explains at
# least.
_NO_WORSE, _MIN_EXPLAINED = 1.05, 0.7
_MIN_EXPLAINED_THERE = 0.5  # the same of the channel in which the change was seen
# Names that one answer may hold together. More say only that something is different.
_MAX_GROUP = 3
# E, in units of what the baseline left, up to which a log is as the baseline was.
SAME_AS_BEFORE = 1.25
# A calibrated number has changed where it moved by so many standard deviations of what it may be, and by this share.
_MOVED, _MIN_SHARE = 2.0, 0.02
_MIN_SAMPLES = 100  # of a channel that counts by itself
_BLOCK_S, _RESAMPLES, _LEVEL = 20.0, 500, 0.95


@dataclass(frozen=True)
class ChangedParameter:
    """A number of the rig before and after.

    Attributes:
        before: Value in the baseline.
        after: Value since.
        interval: 95 % interval of ``after``; it leaves out ``before``.
        unit: SI unit of all of them, "-" for none.
    """

    before: float
    after: float
    interval: tuple[float, float]
    unit: str


@dataclass(frozen=True)
class ChangeAnswer:
    """What has changed.

    Attributes:
        verdict: As of a diagnosis: ``none``, ``parameters``, ``effect``, ``effect_and_unknown`` or ``unknown``.
        named: The candidate that is named, None without any.
        group: Candidates that the log cannot distinguish from it.
        suspected: Candidates with some evidence that are not named, those of the group first.
        site: Where it acts.
        moved: Calibrated numbers that changed for certain, by name.
        explained: Share of the difference that the answer explains, None without a difference or an answer.
        interval: 95 % interval of ``explained`` over blocks of time.
        refused: Why a candidate may not be named, by its name; those that may are missing.
        gaps: E of the later log: with the baseline's model, calibrated again, and with the named change or None.
    """

    verdict: str
    named: TriedChange | None
    group: tuple[str, ...]
    suspected: tuple[str, ...]
    site: str | None
    moved: Mapping[str, ChangedParameter]
    explained: float | None
    interval: tuple[float, float] | None
    refused: Mapping[str, str] = field(default_factory=dict)
    gaps: tuple[float, float, float | None] = field(default=(1.0, 1.0, None))

    @property
    def final(self) -> float:
        """E of the best model of the answer."""
        return self.gaps[1] if self.gaps[2] is None else self.gaps[2]


def answer_from(
    search: ChangeSearch, baseline: Baseline, seed: int = 0, further: Mapping[str, str] | None = None
) -> ChangeAnswer:
    """The answer that a search supports.

    Args:
        search: The search.
        baseline: What the earlier log gave.
        seed: Of the bootstrap.
        further: Why else a candidate may not be named, by its name.
    """
    unchanged, calibrated = (usual_gap(search.problem, each.residual) for each in (search.unchanged, search.calibrated))
    refused = _refused(search, further or {})
    group = _indistinguishable([each for each in search.tried if each.effect.name not in refused])
    different = largest_gap(search.problem, search.unchanged.residual) > SAME_AS_BEFORE
    named = _linearised(group[0]) if 0 < len(group) <= _MAX_GROUP and different else None
    final = search.calibrated if named is None else named.fit
    verdict = _verdict(search, named, different)
    explained, interval = None, None
    if verdict in ("parameters", "effect", "effect_and_unknown"):
        explained, interval = share_explained(search.problem, search.unchanged.residual, final.residual, seed)
    others = [each for each in search.tried if each.gain >= MIN_SUSPICION and each.effect.is_physical(each.fit.values)]
    names = tuple(each.effect.name for each in group) if named else ()
    evident = [name for name in (*names, *(each.effect.name for each in others)) if name not in names[:1]]
    return ChangeAnswer(
        verdict=verdict,
        named=named,
        group=names[1:],
        suspected=tuple(dict.fromkeys(evident)) if different else (),
        site=named.effect.site if named else _likely_site(others, verdict),
        moved=moved_parameters(search.problem if named is None else named.problem, final, baseline),
        explained=explained,
        interval=interval,
        refused=refused,
        gaps=(unchanged, calibrated, None if named is None else named.gap),
    )


def _linearised(tried: TriedChange) -> TriedChange:
    """The candidate with a Jacobian of where its fit ended, for the intervals of its parameters."""
    return replace(tried, fit=linearised_at_its_end(tried.problem, tried.fit))


def _verdict(search: ChangeSearch, named: TriedChange | None, different: bool) -> str:
    if named is not None:
        enough = largest_gap(named.problem, named.fit.residual) <= SAME_AS_BEFORE
        return "effect" if enough else "effect_and_unknown"
    if not different:
        return "none"
    return "parameters" if largest_gap(search.problem, search.calibrated.residual) <= SAME_AS_BEFORE else "unknown"


def largest_gap(problem: Problem, residual: Array) -> float:
    """E of the channel that misfits most, or of all together."""
    large_channels = {piece.name for piece in problem.pieces if _counts_by_itself(problem, piece)}
    own = [gap for name, gap in usual_gaps(problem, residual).items() if name in large_channels]
    return max([usual_gap(problem, residual), *own])


def _counts_by_itself(problem: Problem, piece: Piece) -> bool:
    return bool(np.sum(counts_of(problem, piece)) >= _MIN_SAMPLES and not piece.channel.accumulates)


def why_unsupported(tried: TriedChange, search: ChangeSearch) -> str:
    """Why a candidate may not be named, empty if it may.

    Args:
        tried: The candidate.
        search: The search that tried it.
    """
    unchanged, calibrated = (usual_gap(search.problem, each.residual) for each in (search.unchanged, search.calibrated))
    if tried.gain < MIN_EVIDENCE:
        return "explains no more than chance and the model's own error may"
    calibration_is_enough = largest_gap(search.problem, search.calibrated.residual) <= SAME_AS_BEFORE
    if only_wandered(search.calibrated) and calibration_is_enough:
        return "calibrated numbers that have moved no farther than they wander explain the difference, too"
    if not tried.effect.is_physical(tried.fit.values):
        return f"its fitted value is not physical: it would be {tried.effect.nonphysical}"
    if not is_physical_and_material(tried):
        return "too small: by less than anybody would act on"
    if tried.gap > _NO_WORSE * max(calibrated, 1.0):
        return "leaves a larger error than calibration alone"
    # NaN where there is no difference to explain: that is no reason against it.
    if share_closed(unchanged**2, tried.gap**2) < _MIN_EXPLAINED:
        return f"explains less than {100.0 * _MIN_EXPLAINED:.0f} % of the difference"
    beside = changed_beside(tried, search.calibrated)
    if beside:
        return f"explains the difference only if {plain_name(beside)} has changed too"
    if not differs_from_none(tried):
        return "its size is not significantly different from none"
    return ""


def differs_from_none(tried: TriedChange) -> bool:
    """Whether the 95 % interval of a candidate's amplitude, as an answer shows it, leaves out none."""
    deviations = deviations_from_none(tried.problem, tried.fit, tried.effect.parameters[0].name)
    return deviations > SPREAD_OF_ANSWERS * TWO_SIDED_95


def _explains_another_channel(tried: TriedChange, search: ChangeSearch) -> bool:
    """Whether the channel in which the change was seen differs, and would fit as well without this candidate."""
    channel = search.seen_in or ""
    if usual_gaps(search.problem, search.unchanged.residual).get(channel, 1.0) <= SAME_AS_BEFORE:
        return False
    without = tried.problem.residuals([_without(tried)])[0]
    missing, left = (usual_gaps(tried.problem, each)[channel] for each in (without, tried.fit.residual))
    return missing <= 1.0 or bool(share_closed(missing**2, left**2) < _MIN_EXPLAINED_THERE)


def _without(tried: TriedChange) -> dict[str, float]:
    """The fitted values, the candidate's own at nothing."""
    return {**tried.fit.values, **{parameter.name: parameter.nominal for parameter in tried.effect.parameters}}


def is_physical_and_material(tried: TriedChange) -> bool:
    """Whether the fitted values are what the name stands for, and large enough that somebody acts on them."""
    effect, values = tried.effect, tried.fit.values
    before, after = user_values(tried.problem, _without(tried)), user_values(tried.problem, values)
    return effect.is_physical(values) and effect.is_material(before, after)


def _refused(search: ChangeSearch, further: Mapping[str, str]) -> dict[str, str]:
    """Why a candidate may not be named, by its name."""
    refused = {each.effect.name: why for each in search.tried if (why := why_unsupported(each, search))} | dict(further)
    supported = [each for each in search.tried if each.effect.name not in refused]
    elsewhere = [each for each in supported if _explains_another_channel(each, search)]
    refused |= refused_by_channel(supported, elsewhere, plain_name(search.seen_in or ""))
    return refused | refused_behind(search.tried, refused)


def refused_behind(tried: Sequence[TriedChange], refused: Mapping[str, str]) -> dict[str, str]:
    """Why no candidate may be named where even the best explains clearly less than one that may not, by their names.

    A candidate whose fitted value is not physical stands before no other. One about as good as the best that may be
    named remains of its group.

    Args:
        tried: Fitted candidates.
        refused: Those of them that may not be named, by name.
    """
    unconfirmed = [each for each in tried if each.effect.name in refused and each.effect.is_physical(each.fit.values)]
    supported = [each for each in tried if each.effect.name not in refused]
    if not unconfirmed or not supported:
        return {}
    most = max(unconfirmed, key=lambda each: each.gain)
    if max(each.gain for each in supported) >= _least_gain_beside(most):
        return {}
    why = f"{plain_name(most.effect.name)} explains more, but was not confirmed"
    return {each.effect.name: why for each in supported}


def refused_by_channel(
    supported: Sequence[TriedChange], elsewhere: Sequence[TriedChange], channel: str
) -> dict[str, str]:
    """Why a candidate may not be named for the channel in which the change was seen, by its name.

    Where one explains most, but not that channel, two things differ, or the channel showed it by chance: the next best
    is no better known then.

    Args:
        supported: Candidates that may be named but for the channel.
        elsewhere: Those of them that do not explain the channel.
        channel: Its name.
    """
    reasons = {each.effect.name: f"does not explain the {channel}, in which the change was seen" for each in elsewhere}
    for most in elsewhere:
        behind = f"{plain_name(most.effect.name)} explains more, but not the {channel}, in which the change was seen"
        less = [each.effect.name for each in supported if each.gain < most.gain]
        reasons = dict.fromkeys(less, behind) | reasons
    return reasons


def _indistinguishable(supported: Sequence[TriedChange]) -> list[TriedChange]:
    """The best candidate and those that explain nearly as much, best first."""
    if not supported:
        return []
    least = _least_gain_beside(max(supported, key=lambda each: each.gain))
    return sorted((each for each in supported if each.gain >= least), key=lambda each: -each.gain)


def _least_gain_beside(best: TriedChange) -> float:
    """Gain from which a candidate explains about as much as a better one."""
    return best.gain - max(_SAME_GAIN, _SAME_SHARE * best.gain)


def _likely_site(others: Sequence[TriedChange], verdict: str) -> str | None:
    """The site of the candidate that gains most, where something unknown is different."""
    return others[0].effect.site if verdict == "unknown" and others else None


def moved_parameters(problem: Problem, found: Fit, baseline: Baseline) -> dict[str, ChangedParameter]:
    """Calibrated numbers that are for certain no longer what the baseline found, by name.

    Args:
        problem: The problem of the fit.
        found: The fit of the later log.
        baseline: What the earlier log gave.
    """
    intervals = parameter_intervals(problem, found)
    moved = {}
    for parameter in found.parameters:
        known = baseline.parameters.get(parameter.name)
        if known is None or "." in parameter.name:
            continue
        value, (low, high) = found.values[parameter.name], intervals[parameter.name]
        step = abs(value - known.value)
        large = step > _MOVED * known.spread and (parameter.unit != "-" or step > _MIN_SHARE * abs(known.value))
        if large and not low <= known.value <= high:
            moved[parameter.name] = ChangedParameter(known.value, value, (low, high), parameter.unit)
    return moved


def share_explained(
    problem: Problem, before: Array, after: Array, seed: int = 0
) -> tuple[float | None, tuple[float, float] | None]:
    """Share of the difference that a model explains, and its 95 % interval over blocks of time.

    Args:
        problem: Where the residuals belong.
        before: (N,) residual of the baseline's model.
        after: (N,) residual of the model with the answer.
        seed: Of the bootstrap.

    Returns:
        ``1 - (E_after^2 - 1) / (E_before^2 - 1)``; None where the log is no worse than the baseline.
    """
    if usual_gap(problem, before) <= 1.0:
        return None, None
    rows = counted(problem)
    before, after, block = before[rows], after[rows], _time_blocks(problem)[rows]
    _, block, count = np.unique(block, return_inverse=True, return_counts=True)
    sums = [np.bincount(block, weights=residual**2) for residual in (before, after)]
    drawn = np.random.default_rng(seed).integers(0, count.size, size=(_RESAMPLES, count.size))
    shares = share_closed(sums[0][drawn].sum(1) / count[drawn].sum(1), sums[1][drawn].sum(1) / count[drawn].sum(1))
    low, high = (float(np.nanquantile(shares, q)) for q in (0.5 - 0.5 * _LEVEL, 0.5 + 0.5 * _LEVEL))
    return float(share_closed(float(np.mean(before**2)), float(np.mean(after**2)))), (low, high)


def _time_blocks(problem: Problem) -> NDArray[np.int_]:
    """(N,) number of the block of time to which each sample belongs; every log has blocks of its own."""
    block, first = np.empty(problem.size, dtype=int), 0
    for run in range(len(problem.model.runs)):
        own = [piece for piece in problem.pieces if piece.run == run]
        start = min(piece.channel.time[0] for piece in own)
        for piece in own:
            block[piece.rows] = first + (piece.channel.time - start) // _BLOCK_S
        first = 1 + max(int(block[piece.rows].max()) for piece in own)
    return block


def changed_model(search: ChangeSearch) -> ChangedString:
    """The model that the search used."""
    model = search.problem.model
    assert isinstance(model, ChangedString)
    return model
