"""The drill string of a later log: what an earlier log calibrated is shared, and something may have changed since."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.diagnosis.drill_string import DrillString
from slider_drilling.diagnosis.onset import Onset
from slider_drilling.gap.model import (
    Array,
    Effect,
    LoggedRun,
    Parameter,
    SimulationOptions,
    Values,
)

_NOWHERE = 1e9  # SI, of a channel whose simulation fails: no change that makes the string unstable is a candidate


@dataclass(frozen=True)
class ChangedString:
    """A `slider_drilling.gap.model.Model` of logs made after a baseline.

    Attributes:
        string: Model of these logs alone.
        shared: Values that the baseline gave to calibrated parameters and standing effects: they hold where a set of
            values says nothing else.
        nuisance: Calibrated parameters, around the baseline's values.
        effects: What may have changed.
        growing: Whether a change grows evenly from where it begins to the end of each log, where it has its full size;
            else all of it is there at once.
        onset: When it begins in each log; None where that is its start.
        changing: Names of the parameters that change then; all others are what they are from the start of each log.
    """

    string: DrillString
    shared: Mapping[str, float]
    nuisance: tuple[Parameter, ...]
    effects: tuple[Effect, ...]
    growing: bool = False
    onset: Onset | None = None
    changing: frozenset[str] = field(default=frozenset(), repr=False)

    @property
    def runs(self) -> tuple[LoggedRun, ...]:
        """See `Model`."""
        return self.string.runs

    @property
    def max_fidelity(self) -> int:
        """See `HasFidelities`."""
        return self.string.max_fidelity

    @property
    def user_parameters(self) -> Mapping[str, Parameter]:
        """See `HasUserParameters`."""
        return self.string.user_parameters

    def to_user(self, values: Values) -> dict[str, float]:
        """See `HasUserParameters`."""
        return self.string.to_user(values)

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """See `Model`. From its onset on the string is another one; a change that grows is blended over into that.

        The blend is exact where the response is linear in the change and follows it within a rocking cycle.
        """
        # A change that makes the string unstable overflows on its way to `_NOWHERE`.
        with np.errstate(over="ignore", invalid="ignore"):
            full = [{**self.shared, **values} for values in sets]
            begins_later = self.growing or self.onset is not None
            changed = [
                index for index, values in enumerate(sets) if begins_later and not self.changing.isdisjoint(values)
            ]  # fmt: skip
            steady = [index for index in range(len(sets)) if index not in changed]
            before = [self._unchanged(full[index]) for index in changed]
            rows = self._rows(run, [full[index] for index in steady], options)
            after = self._changed(run, before, [full[index] for index in changed], options)
        order = np.argsort([*steady, *changed])
        return {name: np.concatenate([rows[name], after[name]])[order] for name in rows}

    def _rows(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> dict[str, Array]:
        """Rows (k, n) of every channel of sets that hold from the start."""
        if not sets:
            return {channel.name: np.empty((0, channel.time.size)) for channel in self.runs[run].channels}
        return {name: _finite(rows) for name, rows in self.string.simulate(run, sets, options).items()}

    def _changed(
        self, run: int, before: Sequence[Values], after: Sequence[Values], options: SimulationOptions
    ) -> dict[str, Array]:
        """The same of sets that become others."""
        if self.onset is None or not before:
            rows = self._rows(run, after, options)
        else:
            begins = self.runs[run].time[0] + self.onset.middle
            switched = self.string.simulate_switched(run, before, after, begins, options)
            rows = {name: _finite(values) for name, values in switched.items()}
        if not self.growing:
            return rows
        unchanged = self._rows(run, before, options)
        return {name: unchanged[name] + self._share(run, name) * (rows[name] - unchanged[name]) for name in rows}

    def _unchanged(self, values: Values) -> dict[str, float]:
        """The values as they are before the change."""
        kept = {name: value for name, value in values.items() if name not in self.changing}
        return kept | {name: self.shared[name] for name in self.changing if name in self.shared}

    def _share(self, run: int, channel: str) -> Array:
        """Share (n,) of a growing change that is there at a channel's samples."""
        logged = self.runs[run]
        time = next(own.time for own in logged.channels if own.name == channel) - logged.time[0]
        begins = 0.0 if self.onset is None else self.onset.middle
        return np.asarray(np.clip((time - begins) / max(logged.duration - begins, 1e-9), 0.0, 1.0))

    def changed_in(self, effects: Sequence[Effect], growing: bool, before: Values) -> ChangedString:
        """The same model where any of these may change.

        Args:
            effects: What may change.
            growing: Whether it grows.
            before: Calibrated values: what the rig had all along is as large before the change.
        """
        names = frozenset(parameter.name for effect in effects for parameter in effect.parameters)
        shared = {name: before.get(name, value) for name, value in self.shared.items()}
        return replace(self, growing=growing, shared=shared, changing=names)


def compared_around(string: DrillString, onset: Onset | None) -> DrillString:
    """The same model, without the samples of which nobody knows whether they are from before a change or after it.

    Reported errors count those after it alone.
    """
    if onset is None:
        return string
    runs = []
    for run in string.runs:
        channels = []
        for channel in run.channels:
            time = channel.time - run.time[0]
            known = (time <= onset.unchanged_until) | (time >= onset.changed_from)
            channels.append(replace(channel, time=channel.time[known], measured=channel.measured[known]))
        runs.append(replace(run, channels=tuple(channels), counts_from=float(run.time[0] + onset.changed_from)))
    return replace(string, runs=tuple(runs))


def _finite(rows: Array) -> Array:
    """Rows (k, n) of a channel; those of simulations that failed are far from any measurement."""
    failed: NDArray[np.bool_] = ~np.asarray(np.isfinite(rows).all(axis=1))
    return np.asarray(np.where(failed[:, np.newaxis], _NOWHERE, rows)) if np.any(failed) else rows
