"""What the gap engine asks of a model: runs with channels, parameters, effects, and a batched simulation.

The engine knows nothing else. The drill string (`slider_drilling.diagnosis.drill_string`) is one such model, the
motor-driven slide of ``docs/examples/motor_slide.py`` another.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Values = Mapping[str, float]


@dataclass(frozen=True)
class Parameter:
    """One number that a fit may free.

    nominal: its value in the model as given (an effect's amplitude is neutral there); lower, upper: the range
    a fit may use; scale: a typical change, the unit of the optimiser's steps; spread: how far a rig's value
    commonly lies from nominal (one standard deviation, a weak prior), infinite when nothing is known;
    per_run: belongs to the run rather than to the rig.
    """

    name: str
    nominal: float
    lower: float
    upper: float
    scale: float
    unit: str = "-"
    spread: float = float("inf")
    per_run: bool = False

    def __post_init__(self) -> None:
        if not (self.lower < self.upper and self.lower <= self.nominal <= self.upper and self.scale > 0.0):
            raise ValueError(f"parameter {self.name}: needs lower <= nominal <= upper and scale > 0")


@dataclass(frozen=True)
class Effect:
    """A candidate cause: the parameters it frees, and how it can be looked for.

    parameters: first the amplitude (neutral at its nominal), then shape parameters. scan: full parameter values
    at which the score test probes, all away from neutral and from the bounds; the fits start from the best of
    them, so at least three. physical: the range of the amplitude that the effect's name stands for; a fit that
    leaves it is reported as ``nonphysical``, the shape it has. fidelity: of the cheapest simulation that shows it.
    """

    name: str
    site: str
    parameters: tuple[Parameter, ...]
    scan: tuple[tuple[float, ...], ...]
    physical: tuple[float, float] = (-float("inf"), float("inf"))
    nonphysical: str = "its opposite"
    law: str = ""
    fidelity: int = 0

    def __post_init__(self) -> None:
        if len(self.scan) < 3:
            raise ValueError(f"effect {self.name}: give at least three scan points")
        for point in self.scan:
            if len(point) != len(self.parameters):
                raise ValueError(f"effect {self.name}: scan point {point} does not fit its parameters")
            for value, parameter in zip(point, self.parameters, strict=True):
                if not parameter.lower < value < parameter.upper:
                    raise ValueError(f"effect {self.name}: scan value {parameter.name} = {value} on or past a bound")
            if point[0] == self.parameters[0].nominal:
                raise ValueError(f"effect {self.name}: scan point {point} is neutral")

    def is_physical(self, values: Values) -> bool:
        """Whether the amplitude among these values is of the sign and size that the name stands for."""
        low, high = self.physical
        return low <= values[self.parameters[0].name] <= high

    @property
    def within_physical_range(self) -> Effect:
        """The effect within what its name stands for: beside others it could bend the other way, and be told by it."""
        amplitude, *rest = self.parameters
        low = max(amplitude.lower, min(self.physical[0], amplitude.nominal))
        high = min(amplitude.upper, max(self.physical[1], amplitude.nominal))
        if low == high or any(not low < point[0] < high for point in self.scan):
            return self
        return replace(self, parameters=(replace(amplitude, lower=low, upper=high), *rest))

    def values(self, point: Sequence[float]) -> dict[str, float]:
        """Parameter values by name."""
        return {parameter.name: float(value) for parameter, value in zip(self.parameters, point, strict=True)}


@dataclass(frozen=True)
class Channel:
    """What one sensor measured: time (n,) s ascending, measured (n,) in unit.

    period: of a wrapped angle, else None; declared_noise: the standard deviation somebody states for the
    sensor; resolution: its smallest step, 0 if none; accumulates: what a
    simulation misses once stays in every later sample (`slider_drilling.gap.problem.step_loss`).
    """

    name: str
    time: Array
    measured: Array
    unit: str = "-"
    period: float | None = None
    declared_noise: float | None = None
    resolution: float = 0.0
    accumulates: bool = False

    def residual(self, simulated: Array) -> Array:
        """measured - simulated, (..., n), wrapped to half a period either way where the channel wraps."""
        difference = self.measured - simulated
        if self.period is None:
            return difference
        return (difference + 0.5 * self.period) % self.period - 0.5 * self.period


@dataclass(frozen=True)
class LoggedRun:
    """One log: the main command ``excitation`` (m,) over ``time`` (m,) s, and the channels measured.

    bands: named frequency ranges (name, from Hz, to Hz) to split the gap by, besides the excitation's own; command,
    command_unit: what the excitation is, in words.
    """

    name: str
    time: Array
    excitation: Array
    channels: tuple[Channel, ...]
    bands: tuple[tuple[str, float, float], ...] = ()
    command: str = "the excitation"
    command_unit: str = "-"

    @property
    def duration(self) -> float:
        """Length of the run, s."""
        return float(self.time[-1] - self.time[0])


@dataclass(frozen=True)
class SimulationOptions:
    """How a model is asked to simulate. What it has no use for it may ignore.

    fidelity: 0 the cheapest, up to the model's own finest; pull: gain of a weak observer that feeds the pulled
    channel's measurement back, 0 a free run (see `Pulled`).
    """

    fidelity: int = 0
    observer_gain: float = 0.0


@runtime_checkable
class HasObserver(Protocol):
    """A model with a weak observer: while it is fitted, a measured channel may pull a little at what is simulated.

    A free run of what sticks and slips loses phase, and its cost is full of holes; a passive pull makes the same cost
    smooth. The error of the pulled channel shrinks by 1 + pull.
    """

    @property
    def observed_channel(self) -> str:
        """Name of the channel that is fed back."""

    def with_measured(self, run: int, measured: Array) -> HasObserver:
        """The same model with other measurements (n,) of that channel in one run."""


@runtime_checkable
class HasFidelities(Protocol):
    """A model with simulations of several fidelities."""

    @property
    def max_fidelity(self) -> int:
        """The highest fidelity that `How` may ask for."""


class Model(Protocol):
    """Anything that can be simulated for many parameter sets at once."""

    @property
    def runs(self) -> tuple[LoggedRun, ...]:
        """The logs to explain."""

    @property
    def nuisance(self) -> tuple[Parameter, ...]:
        """What is re-tuned in any rig and is no effect."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The catalogue."""

    def simulate(self, run: int, sets: Sequence[Values], options: SimulationOptions) -> Mapping[str, Array]:
        """Channels of one run for K parameter sets, each (K, n) at the channel's times; pure.

        A name missing from a set stands at its nominal value.
        """


@runtime_checkable
class CanTruncate(Protocol):
    """A model that can be asked for the first part of its runs only, at that part's cost."""

    def truncated(self, fraction: float) -> Model:
        """The same model of the runs' first ``share`` (0 to 1)."""


@runtime_checkable
class HasCoupledEffects(Protocol):
    """A model some of whose effects may show only together (stick-slip: as long as one is missing the phase is off)."""

    @property
    def coupled_effects(self) -> tuple[str, ...]:
        """Names of the effects to free at once before they are looked for one by one; empty for none."""


@runtime_checkable
class HasUserParameters(Protocol):
    """A model that fits some of its parameters under other names than those that a user knows.

    A stretch of a hole is known by its ends and what is in it; a search gets along better with how much there is in
    all, where its middle is, and how long it is.
    """

    @property
    def user_parameters(self) -> Mapping[str, Parameter]:
        """The parameters that a user knows instead, by name."""

    def to_user(self, values: Values) -> dict[str, float]:
        """Fitted values by the names that a user knows; what has one name only is passed on."""


@runtime_checkable
class HasProbes(Protocol):
    """A model that can say where along it something is missing."""

    @property
    def probes(self) -> tuple[tuple[Parameter, float, float], ...]:
        """(parameter, from, to): a parameter that acts between two positions only."""


@dataclass(frozen=True)
class FreeForm:
    """Something flexible at one site that no law describes: how the channels move with each of its coefficients.

    words: what it would be ("friction over depth"); like: names of the effects whose free form it is; x: (m,) where
    each coefficient stands, in x_unit; sets: m parameter sets, each a small step of one coefficient from the values it
    was asked for; steps: (m,) those steps; parameters: (m,) the coefficients themselves where they may go far: then
    they are fitted, not solved for once; period: of x, where the curve closes on itself. y_unit: of what is off;
    curve: (m, m) what is off at each x by one of each coefficient, empty where that is the coefficient itself; least:
    below which what is off cannot be (a friction that pushes).
    """

    site: str
    description: str
    free_form_of: tuple[str, ...]
    x: tuple[float, ...]
    x_unit: str
    parameter_sets: tuple[dict[str, float], ...]
    steps: tuple[float, ...]
    parameters: tuple[Parameter, ...] = ()
    period: float | None = None
    y_unit: str = "-"
    basis: tuple[tuple[float, ...], ...] = ()
    lower_bound: float = -math.inf


@runtime_checkable
class HasFreeForms(Protocol):
    """A model that can be disturbed at its sites, and knows where what a channel reads comes from."""

    def free_forms(self, values: Values) -> Sequence[FreeForm]:
        """Rivals of every law, around these values."""

    def sensor_site(self, channel: str) -> str:
        """Where an error of the reading alone would lie."""


@dataclass(frozen=True)
class Manoeuvre:
    """A run that could be made next: what to do in words and numbers, and the model that simulates it.

    The model's runs carry the channels' times and declared noise; their measured values are not used.
    """

    description: str
    settings: Mapping[str, float]
    model: Model = field(repr=False)


@runtime_checkable
class HasManoeuvres(Protocol):
    """A model that can say which runs could be made next."""

    def manoeuvres(self) -> Sequence[Manoeuvre]:
        """Candidates to compare."""
