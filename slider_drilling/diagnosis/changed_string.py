"""The drill string of a later log: what an earlier log calibrated is shared, and something may have changed since."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from slider_drilling.diagnosis.drill_string import DrillString
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
        growing: Whether a change grows evenly from the start of each log to its end, where it has its full size; else
            it is there from the start.
    """

    string: DrillString
    shared: Mapping[str, float]
    nuisance: tuple[Parameter, ...]
    effects: tuple[Effect, ...]
    growing: bool = False
    _changing: frozenset[str] = field(default=frozenset(), repr=False)

    def __post_init__(self) -> None:
        names = frozenset(parameter.name for effect in self.effects for parameter in effect.parameters)
        object.__setattr__(self, "_changing", names)

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
        """See `Model`. A change that grows is the unchanged response, blended over into that of the full change.

        The blend is exact where the response is linear in the change and follows it within a rocking cycle.
        """
        # A change that makes the string unstable overflows on its way to `_NOWHERE`.
        with np.errstate(over="ignore", invalid="ignore"):
            return self._simulate(run, sets, options)

    def _simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        full = [{**self.shared, **values} for values in sets]
        if not self.growing:
            return {name: _finite(rows) for name, rows in self.string.simulate(run, full, options).items()}
        unchanged = [
            {name: self.shared.get(name, value) if name in self._changing else value for name, value in values.items()
             if name not in self._changing or name in self.shared}
            for values in full
        ]  # fmt: skip
        simulated = self.string.simulate(run, [*full, *unchanged], options)
        return {name: self._blend(run, name, _finite(rows)) for name, rows in simulated.items()} if sets else simulated

    def _blend(self, run: int, channel: str, rows: Array) -> Array:
        logged = self.runs[run]
        time = next(own.time for own in logged.channels if own.name == channel)
        share = np.clip((time - logged.time[0]) / max(logged.duration, 1e-9), 0.0, 1.0)
        count = len(rows) // 2
        return np.asarray(rows[count:] + share * (rows[:count] - rows[count:]))

    def growing_change(self, growing: bool) -> ChangedString:
        """The same model with changes that grow, or with sudden ones."""
        return replace(self, growing=growing)


def _finite(rows: Array) -> Array:
    """Rows (k, n) of a channel; those of simulations that failed are far from any measurement."""
    failed: NDArray[np.bool_] = ~np.asarray(np.isfinite(rows).all(axis=1))
    return np.asarray(np.where(failed[:, np.newaxis], _NOWHERE, rows)) if np.any(failed) else rows
