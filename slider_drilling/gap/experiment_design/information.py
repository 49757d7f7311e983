"""Information of one run about a model: inner products of whitened sensitivities, which add up over runs.

The Fisher information of parameters in a run is the Gram matrix of their whitened sensitivities. Beside them stand the
changes that effects and alternative explanations make. Whether an effect shows while everything else stays free follows
from the Schur complement of the free parameters (Ds-optimality; Atkinson, Donev and Tobias, Optimum Experimental
Designs, 2007, section 10.3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slider_drilling.gap.evidence.likelihood import Discrepancy, whiten
from slider_drilling.gap.model import Array, Parameter, Values
from slider_drilling.gap.problem.model_error import INDEPENDENT_ERRORS, model_error_size
from slider_drilling.gap.problem.problem import Piece, Problem
from slider_drilling.gap.search.least_squares import DIFFERENCE_STEP


@dataclass(frozen=True)
class ChannelInformation:
    """One channel of one or several runs.

    Attributes:
        gram: (m, m) inner products of the sensitivities in noise units, not whitened.
        samples: Number of samples.
        model_error: Sum over the samples of E^2 that the model's own error may hold.
    """

    gram: Array = field(repr=False)
    samples: int
    model_error: float


@dataclass(frozen=True)
class Information:
    """What one or several runs tell.

    Attributes:
        names: (m,) free parameters first, then changes.
        free: Number of free parameters.
        white: (m, m) inner products of the whitened sensitivities: per scale of each parameter, and of each change.
        channels: By name of the channel.
        prior: (free,) squared weight of each free parameter's prior, per scale.
    """

    names: tuple[str, ...]
    free: int
    white: Array = field(repr=False)
    channels: Mapping[str, ChannelInformation] = field(repr=False)
    prior: Array = field(repr=False)

    @property
    def changes(self) -> tuple[str, ...]:
        """Names of the changes."""
        return self.names[self.free :]

    def __add__(self, other: Information) -> Information:
        """The information of both; what only one of them has made no difference in the other."""
        parameters = dict.fromkeys((*self.names[: self.free], *other.names[: other.free]))
        names = (*parameters, *dict.fromkeys((*self.changes, *other.changes)))
        count = len(parameters)
        place = {name: index for index, name in enumerate(names)}

        def widened(information: Information, gram: Array) -> Array:
            at = [place[name] for name in information.names]
            wide = np.zeros((len(names), len(names)))
            wide[np.ix_(at, at)] = gram
            return wide

        prior = np.zeros(count)
        for information in (self, other):
            prior[[place[name] for name in information.names[: information.free]]] = information.prior
        channels = {}
        for name in dict.fromkeys((*self.channels, *other.channels)):
            own = [(each, each.channels[name]) for each in (self, other) if name in each.channels]
            channels[name] = ChannelInformation(
                np.sum([widened(each, channel.gram) for each, channel in own], axis=0),
                sum(channel.samples for _, channel in own), sum(channel.model_error for _, channel in own),
            )  # fmt: skip
        return Information(names, count, widened(self, self.white) + widened(other, other.white), channels, prior)

    def beyond_free(self) -> tuple[Array, dict[str, Array]]:
        """What the free parameters cannot make up for.

        Returns:
            (c, c) Schur complement of the changes: its diagonal is the noncentrality of each. And by channel, (c,) sum
            over the samples of the squared noise units that each change leaves after the free parameters have followed.
        """
        count = self.free
        normal = self.white[:count, :count] + np.diag(self.prior)
        ridge = 1e-9 * max(float(np.max(np.diag(normal), initial=0.0)), 1e-30)
        cross = self.white[:count, count:]
        follow = np.linalg.solve(normal + ridge * np.eye(count), cross) if count else np.zeros(cross.shape)
        schur = self.white[count:, count:] - cross.T @ follow
        left = np.vstack([-follow, np.eye(cross.shape[1])])
        power = {
            name: np.maximum(np.einsum("ic,ij,jc->c", left, channel.gram, left), 0.0)
            for name, channel in self.channels.items()
        }
        return 0.5 * (schur + schur.T), power


@dataclass(frozen=True)
class Change:
    """A parameter set whose difference from the model's present values is of interest.

    Attributes:
        name: Its name.
        values: The whole parameter set.
        fidelity: Of the cheapest simulation that shows it.
    """

    name: str
    values: Values
    fidelity: int = 0


def run_information(
    problem: Problem, values: Values, parameters: Sequence[Parameter], changes: Sequence[Change], run: str
) -> Information:
    """What a problem of one run would tell.

    Args:
        problem: The problem. Measured values are not used.
        values: Parameter values around which it is linearised, without those of other runs.
        parameters: Free parameters, not expanded per run.
        changes: Changes of interest.
        run: Suffix of the free parameters that belong to this run.
    """
    forward = [_value(values, each) + DIFFERENCE_STEP * each.scale < each.upper for each in parameters]
    steps = [DIFFERENCE_STEP if has_room else -DIFFERENCE_STEP for has_room in forward]
    sets = [values]
    sets += [
        {**values, each.name: _value(values, each) + step * each.scale}
        for each, step in zip(parameters, steps, strict=True)
    ]
    coarse = [change for change in changes if change.fidelity <= problem.options.fidelity]
    simulated = problem.simulate([*sets, *(change.values for change in coarse)])
    base, moved = simulated[0], simulated[1:] - simulated[0]
    moved[~np.isfinite(moved).all(axis=1)] = 0.0  # what cannot be simulated shows nothing
    rows = {change.name: row for change, row in zip(coarse, moved[len(parameters) :], strict=True)}
    for fidelity in sorted({change.fidelity for change in changes} - {change.fidelity for change in coarse}):
        own = [change for change in changes if change.fidelity == fidelity]
        options = replace(problem.options, fidelity=fidelity)
        without, *with_it = problem.simulate([values, *(change.values for change in own)], options)
        finer = np.nan_to_num(np.array(with_it) - without, posinf=0.0, neginf=0.0)
        rows |= {change.name: row for change, row in zip(own, finer, strict=True)}
    names = [f"{each.name}@{run}" if each.per_run else each.name for each in parameters]
    jacobian = moved[: len(parameters)] / np.array(steps)[:, None] if steps else np.empty((0, problem.size))
    stacked = np.vstack([jacobian, *(rows[change.name][None] for change in changes)])
    return _collect(problem, base, stacked, (*names, *(change.name for change in changes)), parameters)


def fitted_information(
    problem: Problem, simulated: Array, jacobian: Array, parameters: Sequence[Parameter], changes: Mapping[str, Array]
) -> Information:
    """What logs tell, at a fit to them.

    Args:
        problem: The problem.
        simulated: (N,) simulation of the fit.
        jacobian: (p, N) its Jacobian, per scale.
        parameters: (p,) its free parameters.
        changes: By name, (N,) change of the simulation.
    """
    rows = np.vstack([jacobian, *(row[None] for row in changes.values())])
    return _collect(problem, simulated, rows, (*(each.name for each in parameters), *changes), parameters)


def _value(values: Values, parameter: Parameter) -> float:
    return values.get(parameter.name, parameter.nominal)


def _collect(
    problem: Problem, simulated: Array, rows: Array, names: tuple[str, ...], parameters: Sequence[Parameter]
) -> Information:
    """Gram matrices of rows (m, N), whitened and not.

    A channel that accumulates is left out: one missed step there looks like any effect.
    """
    count = len(names)
    white = np.zeros((count, count))
    channels: dict[str, ChannelInformation] = {}
    for piece in problem.pieces:
        if piece.channel.accumulates:
            continue
        own = np.ascontiguousarray(problem.observer_factor(piece) * rows[:, piece.rows])
        through, _ = whiten(own, piece.interval, _model_error_of(piece, simulated))
        white += through @ through.T
        before = channels.get(piece.name, ChannelInformation(np.zeros((count, count)), 0, 0.0))
        samples = piece.channel.time.size
        channels[piece.name] = ChannelInformation(
            before.gram + own @ own.T, before.samples + samples,
            before.model_error + samples * model_error_size(piece, simulated) ** 2,
        )  # fmt: skip
    prior = np.array([(each.scale / each.spread) ** 2 if np.isfinite(each.spread) else 0.0 for each in parameters])
    return Information(names, len(parameters), white, channels, prior)


def _model_error_of(piece: Piece, simulated: Array) -> Discrepancy:
    """The model's own error as coloured noise that holds `INDEPENDENT_ERRORS` independent numbers in a run."""
    duration = float(piece.channel.time[-1] - piece.channel.time[0]) if piece.channel.time.size > 1 else 1.0
    return Discrepancy(model_error_size(piece, simulated), max(duration, 1e-9) / (2.0 * INDEPENDENT_ERRORS))
