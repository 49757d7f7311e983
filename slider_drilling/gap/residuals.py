"""Residuals of a model's runs in noise units, stacked so that their squares add up to the gap E^2.

``E^2 = mean over runs and channels of mean((measured - simulated)^2) / sigma^2`` (spec gap.md); every channel
counts alike, however often it is sampled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.gap.missed_steps import missed_steps
from slider_drilling.gap.model import Anchored, Array, Channel, Model, Parameter, Values
from slider_drilling.gap.noise import NoiseFloor

# A fit weighs channels between E^2 (0: every channel alike) and likelihood (1: every sample alike). Pure E^2 lets
# the few tool-faces of a log steer the fit by their noise; pure likelihood ignores them.
FIT_TEMPER = 0.5
# Residuals beyond this many noise floors count by their size, not their square, in fits (never in scores): an effect
# that is not in the model turns the tool-face by tens of noise floors and would outvote every other channel.
ROBUST = 4.0
# How many samples' worth of trust the prior on the nuisance has: keeps directions that no channel sees at home.
PRIOR_SHARE = 1.0 / 500.0


@dataclass(frozen=True)
class Problem:
    """A model with its noise floors; everything stacked has length N, over runs, then channels, then samples.

    run, channel: (N,) indices into model.runs and ``channel_names``; time: (N,) s; score: (N,) with
    ``sum(score * r^2) = E^2``; weight: (N,) the fit's weight of r, near sqrt(score) but tempered; noise: (N,)
    the sensor's noise floor in the channel's unit; floor: (N,) the same with what cannot be foretold (`foretold`), the
    unit of every residual; step_size: noise floors beyond which a missed step costs by its logarithm.
    """

    model: Model
    floors: tuple[dict[str, NoiseFloor], ...]
    channel_names: tuple[str, ...]
    run: Array
    channel: Array
    time: Array
    score: Array
    weight: Array
    slices: dict[tuple[int, str], slice]
    noise: Array
    floor: Array
    step_size: float = ROBUST

    def set_of(self, values: Values, run: int) -> dict[str, float]:
        """The parameter set of one run: per-run parameters are named ``name@run`` outside the model."""
        suffix = f"@{run}"
        chosen = {name: value for name, value in values.items() if "@" not in name}
        chosen |= {name[: -len(suffix)]: value for name, value in values.items() if name.endswith(suffix)}
        return chosen

    def channel_of(self, run: int, name: str) -> Channel:
        """A run's channel by its name."""
        return next(channel for channel in self.model.runs[run].channels if channel.name == name)

    def anchor(self, values: Values) -> None:
        """Make the model exact at these values, where it is one that can be."""
        if isinstance(self.model, Anchored):
            self.model.anchor([self.set_of(values, run) for run in range(len(self.model.runs))])

    def simulate(self, sets: Sequence[Values]) -> Array:
        """(K, N) simulated channels of K parameter sets in noise units, wrapped angles as the model unwinds them."""
        stacked = np.empty((len(sets), self.time.size))
        for index, run in enumerate(self.model.runs):
            simulated = self.model.simulate(index, [self.set_of(values, index) for values in sets])
            for channel in run.channels:
                part = self.slices[index, channel.name]
                stacked[:, part] = simulated[channel.name] / self.floor[part]
        return stacked

    def against_log(self, simulated: Array) -> Array:
        """(K, N) residuals, measured - simulated in noise units, of what `simulate` gave; angles wrapped."""
        residual = np.empty_like(simulated)
        for index, run in enumerate(self.model.runs):
            for channel in run.channels:
                part = self.slices[index, channel.name]
                residual[..., part] = channel.residual(simulated[..., part] * self.floor[part]) / self.floor[part]
        return residual

    def residuals(self, sets: Sequence[Values]) -> Array:
        """(K, N) residuals in noise units of K parameter sets."""
        return self.against_log(self.simulate(sets))

    def robust(self, residual: Array) -> tuple[Array, Array]:
        """The residual (..., N) mapped so that its squares are the fit's loss, and the slope of that map.

        The loss is soft-l1, ``2 f^2 (sqrt(1 + (r / f)^2) - 1)``; where the channel accumulates, that of
        `slider_drilling.gap.missed_steps`.
        """
        stretch = np.sqrt(1.0 + (residual / ROBUST) ** 2)
        loss = 2.0 * ROBUST**2 * (stretch - 1.0)
        pull = residual / stretch
        for (run, name), part in self.slices.items():
            channel = self.channel_of(run, name)
            if channel.accumulates:
                whole = residual[..., part]
                if channel.period is not None:
                    whole = np.unwrap(whole * self.floor[part], period=channel.period) / self.floor[part]
                loss[..., part], pull[..., part] = _stepwise(whole, self.step_size)
        mapped = np.sign(pull) * np.sqrt(loss)
        small = np.abs(mapped) < 1e-3
        return np.where(small, residual, mapped), np.where(small, 1.0, pull / np.where(small, 1.0, mapped))

    @property
    def price(self) -> Array:
        """(N,) what a floor above the noise costs: the normalisation of a normal density, so that no model gains by
        foretelling less than it could (a proper score: Gneiting and Raftery, J. Am. Stat. Assoc. 102, 2007)."""
        return 2.0 * np.log(self.floor / self.noise)

    def reweighted(self, residual: Array) -> Array:
        """(N,) weights with which least squares, linearised at this residual, is the robust fit."""
        mapped, slope = self.robust(residual)
        near = np.abs(residual) < 1e-3
        share = np.where(near, 1.0, mapped * slope / np.where(near, 1.0, residual))
        return self.weight * np.sqrt(np.clip(share, 0.0, 1.0))

    def foretold(self, spread: Array) -> Problem:
        """The same with floors that hold, besides the sensors' noise, what no simulation can foretell: (N,) sigma."""
        return replace(self, floor=np.hypot(self.noise, spread))

    def in_floors_of(self, other: Problem, residual: Array) -> Array:
        """A residual (N,) of this problem in the floors of another."""
        return residual * (self.floor / other.floor)

    def gap_squared(self, residual: Array) -> float:
        """E^2 of one residual (N,)."""
        return float(self.score @ residual**2)

    def robust_gap(self, residual: Array) -> float:
        """As `gap_squared` with the fit's loss and weights, and the floors' price: what decides between models."""
        return float(self.weight**2 @ (self.robust(residual)[0] ** 2 + self.price))

    def by_channel(self, squares: Array) -> dict[str, float]:
        """Mean over each channel's runs of squares (N,): of a residual's, its E_c^2."""
        means = {}
        for index, name in enumerate(self.channel_names):
            here = self.channel == index
            means[name] = float(self.score[here] @ squares[here] / self.score[here].sum())
        return means

    def free(self, parameters: Sequence[Parameter]) -> list[Parameter]:
        """The parameters as the fit sees them: one copy per run of those that belong to the run."""
        expanded = []
        for parameter in parameters:
            if parameter.per_run:
                expanded += [_renamed(parameter, f"{parameter.name}@{run}") for run in range(len(self.model.runs))]
            else:
                expanded.append(parameter)
        return expanded


def _stepwise(residual: Array, step_size: float) -> tuple[Array, Array]:
    """Loss and half its derivative, (..., n), of a channel that accumulates."""
    loss, pull = np.empty_like(residual), np.empty_like(residual)
    for index in np.ndindex(residual.shape[:-1]):
        loss[index], pull[index] = missed_steps(residual[index], step_size)
    return loss, pull


def build_problem(model: Model, floors: Sequence[dict[str, NoiseFloor]]) -> Problem:
    """Stack a model's runs. Raises ValueError when no channel is left."""
    names: list[str] = []
    pieces: list[tuple[int, int, Array]] = []
    slices: dict[tuple[int, str], slice] = {}
    start = 0
    for index, run in enumerate(model.runs):
        for channel in run.channels:
            if channel.name not in names:
                names.append(channel.name)
            pieces.append((index, names.index(channel.name), channel.time))
            slices[index, channel.name] = slice(start, start + channel.time.size)
            start += channel.time.size
    if not pieces:
        raise ValueError("no run holds a channel that can be used")
    run_of = np.concatenate([np.full(time.size, run) for run, _, time in pieces])
    channel_of = np.concatenate([np.full(time.size, channel) for _, channel, time in pieces])
    size = np.concatenate([np.full(time.size, time.size) for _, _, time in pieces])
    floor = np.concatenate([np.full(time.size, floors[run][names[c]].sigma) for run, c, time in pieces])
    score = 1.0 / (len(pieces) * size)
    tempered = size ** (FIT_TEMPER - 1.0)
    weight = np.sqrt(tempered / tempered.sum())
    return Problem(
        model, tuple(floors), tuple(names), run_of, channel_of,
        np.concatenate([time for _, _, time in pieces]), score, weight, slices, floor, floor,
    )  # fmt: skip


def _renamed(parameter: Parameter, name: str) -> Parameter:
    return Parameter(
        name, parameter.nominal, parameter.lower, parameter.upper, parameter.scale, parameter.unit,
        parameter.spread, True,
    )  # fmt: skip
