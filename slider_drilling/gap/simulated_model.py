"""The model: what it carries, and how it is simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from slider_drilling.gap.effect import Array, Effect, Parameter, Values
from slider_drilling.gap.logged_run import LoggedRun


@dataclass(frozen=True)
class SimulationOptions:
    """How a model is simulated. A model ignores what it has no use for.

    Attributes:
        fidelity: 0 for the cheapest simulation, up to `HasFidelities.max_fidelity`.
        observer_gain: Gain of a weak observer that feeds the observed channel's measurement back, 0 for a free run
            (`HasObserver`).
    """

    fidelity: int = 0
    observer_gain: float = 0.0


class Model(Protocol):
    """A model that can be simulated for many parameter sets at once."""

    @property
    def runs(self) -> tuple[LoggedRun, ...]:
        """The logs to explain."""

    @property
    def nuisance(self) -> tuple[Parameter, ...]:
        """Parameters that are calibrated in any real system and are no effect."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The catalogue of candidate effects."""

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """Simulate one run for K parameter sets, without side effects.

        Args:
            run: Index of the run.
            sets: K sets of values by parameter name; a parameter that is missing has its nominal value.
            options: How to simulate.

        Returns:
            By channel, (K, n) values at the channel's times; NaN where a set cannot be simulated.
        """
