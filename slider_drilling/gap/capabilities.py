"""What a model may offer besides: the engine uses what it finds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

from slider_drilling.gap.effect import Array, Effect, Parameter, Values
from slider_drilling.gap.simulated_model import Model


@runtime_checkable
class HasObserver(Protocol):
    """A model with a weak observer: a measured channel is fed back a little while it is simulated.

    A free run of a system that sticks and slips loses phase, and its cost has many local minima. A weak observer makes
    the same cost smooth.
    """

    @property
    def observed_channel(self) -> str:
        """Name of the channel that is fed back."""

    def with_measured(self, run: int, measured: Array) -> HasObserver:
        """The same model with other measurements (n,) of the observed channel in one run."""

    def noise_shrinkage(self, run: int, gain: float) -> float:
        """Factor (1 or more) by which feedback with a gain shrinks the noise in a run's error of that channel."""


@runtime_checkable
class HasFidelities(Protocol):
    """A model with simulations of several fidelities."""

    @property
    def max_fidelity(self) -> int:
        """The highest fidelity that `SimulationOptions` may ask for."""


@runtime_checkable
class CanTruncate(Protocol):
    """A model that can simulate only the first part of its runs, at that part's cost."""

    def truncated(self, fraction: float) -> Model:
        """The same model with the first ``fraction`` (0 to 1) of every run."""


@runtime_checkable
class HasCoupledEffects(Protocol):
    """A model with effects that may show only together.

    In stick-slip, for example, the phase is off as long as one of the causes is missing.
    """

    @property
    def coupled_effects(self) -> tuple[str, ...]:
        """Names of the effects to start together before they are tried one by one; empty for none."""


@runtime_checkable
class HasUserParameters(Protocol):
    """A model that fits some parameters under other names than a user knows.

    A user knows a stretch by its ends and what is in it. A search works better with the total amount, the
    middle and the length.
    """

    @property
    def user_parameters(self) -> Mapping[str, Parameter]:
        """The parameters that a user knows instead, by name."""

    def to_user(self, values: Values) -> dict[str, float]:
        """Fitted values by the names that a user knows; other parameters are passed on."""


@runtime_checkable
class HasConditionalNuisance(Protocol):
    """A model with nuisance parameters that are calibrated only where they explain what no effect does as well.

    Calibrated always, such a parameter would hide the effects that act alike.
    """

    @property
    def conditional_nuisance(self) -> tuple[Effect, ...]:
        """Candidates that race beside the effects and are never named; each frees nuisance parameters."""

    def with_nuisance(self, parameters: Sequence[Parameter]) -> Model:
        """The same model with these parameters calibrated too."""


@runtime_checkable
class HasProbes(Protocol):
    """A model with parameters that each act along one stretch, to locate what is missing."""

    @property
    def probes(self) -> tuple[tuple[Parameter, float, float], ...]:
        """(parameter, from, to): each parameter acts between two positions only."""
