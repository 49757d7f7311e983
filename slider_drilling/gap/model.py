"""What the gap engine asks of a model: logged runs, nuisance parameters, effects, and a batched simulation.

`Model` is all that is needed. The protocols after it are optional: the engine uses what a model offers. The drill
string (`slider_drilling.diagnosis.drill_string`) offers all of them, the motor-driven slide of
``docs/examples/motor_slide.py`` none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Parameter values by name.
Values = Mapping[str, float]


@dataclass(frozen=True)
class Parameter:
    """A number that a fit may free.

    Attributes:
        name: Its name.
        nominal: Its value in the model as given. An effect's amplitude is neutral there.
        lower: Lower bound.
        upper: Upper bound.
        scale: A typical change: the unit of the optimiser's steps.
        unit: Unit of all these values.
        spread: Standard deviation of its prior, a normal distribution around nominal; infinite if nothing is known.
        per_run: Whether each run has its own value.
        equivalents: Values that the log cannot distinguish, such as the aliases of a frequency above half the sampling
            rate. The parameter's interval covers them all.

    Raises:
        ValueError: Bounds, nominal value and scale do not fit together.
    """

    name: str
    nominal: float
    lower: float
    upper: float
    scale: float
    unit: str = "-"
    spread: float = float("inf")
    per_run: bool = False
    equivalents: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if not (self.lower < self.upper and self.lower <= self.nominal <= self.upper and self.scale > 0.0):
            raise ValueError(f"parameter {self.name}: needs lower <= nominal <= upper and scale > 0")


@dataclass(frozen=True)
class Effect:
    """A candidate cause of the gap: the parameters that it frees, and where to look for them.

    Attributes:
        name: Its name.
        site: Where it acts.
        parameters: The amplitude first, then parameters of its shape.
        scan: At least three sets of parameter values, none of them neutral or on a bound. The screen scores each, and
            fits start from the best.
        physical: Range of the amplitude that the name stands for.
        nonphysical: What a fit outside that range is called.
        law: The law in words.
        fidelity: Of the cheapest simulation that shows the effect.
        material: Smallest change from neutral that an engineer acts on, by user parameter; one that reaches it is
            enough. Empty if any change counts.

    Raises:
        ValueError: The scan does not fit the parameters.
    """

    name: str
    site: str
    parameters: tuple[Parameter, ...]
    scan: tuple[tuple[float, ...], ...]
    physical: tuple[float, float] = (-float("inf"), float("inf"))
    nonphysical: str = "its opposite"
    law: str = ""
    fidelity: int = 0
    material: Mapping[str, float] = field(default_factory=dict)

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

    def is_material(self, neutral: Values, values: Values) -> bool:
        """Whether the effect changes something that an engineer acts on.

        Args:
            neutral: User parameters without the effect.
            values: User parameters with it.

        Returns:
            True if one parameter of ``material`` differs by at least that amount, or if there is none.
        """
        return not self.material or any(
            abs(values[name] - neutral.get(name, 0.0)) >= amount for name, amount in self.material.items()
        )

    def is_physical(self, values: Values) -> bool:
        """Whether the amplitude among these values lies in the physical range."""
        low, high = self.physical
        return low <= values[self.parameters[0].name] <= high

    @property
    def within_physical_range(self) -> Effect:
        """The effect with its amplitude bounded to the physical range, where the scan allows that.

        Beside other effects a free amplitude could take the wrong sign and make up for them.
        """
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
    """What one sensor measured.

    Attributes:
        name: Its name.
        time: (n,) s, ascending.
        measured: (n,) values, in ``unit``.
        unit: Unit of the values.
        period: Period of a wrapped angle, else None.
        declared_noise: Standard deviation that somebody declares for the sensor, None if nobody does.
        resolution: Smallest step of the sensor, 0 if there is none.
        accumulates: Whether an error that a simulation makes once stays in every later sample, as in an angle that is
            integrated (`slider_drilling.gap.problem.step_loss`).
        model_error: Share of what the channel moves by which the model as such may be wrong, whatever its parameters.
        wander: RMS, in ``unit``, by which it may wander slowly, as the numbers of any rig do. What is left within it is
            no gap.
        tolerance: RMS error, in ``unit``, that nobody would act upon. It counts as no gap where nothing else shows one.
    """

    name: str
    time: Array
    measured: Array
    unit: str = "-"
    period: float | None = None
    declared_noise: float | None = None
    resolution: float = 0.0
    accumulates: bool = False
    model_error: float = 0.0
    wander: float = 0.0
    tolerance: float = 0.0

    def residual(self, simulated: Array) -> Array:
        """measured - simulated, (..., n), wrapped to half a period either way where the channel wraps."""
        difference = self.measured - simulated
        if self.period is None:
            return difference
        return (difference + 0.5 * self.period) % self.period - 0.5 * self.period


@dataclass(frozen=True)
class LoggedRun:
    """One log: a main command and the measured channels.

    Attributes:
        name: Its name.
        time: (m,) s, ascending.
        excitation: (m,) the main command over ``time``.
        channels: What was measured.
        bands: Named frequency bands (name, from Hz, to Hz) to split the gap by, besides those of the excitation.
        command: What the excitation is, in words.
        command_unit: Its unit.
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
            By channel, (K, n) values at the channel's times.
        """


@runtime_checkable
class HasObserver(Protocol):
    """A model with a weak observer: a measured channel is fed back a little while it is simulated.

    A free run of a system that sticks and slips loses phase, and its cost has many local minima. A weak observer makes
    the same cost smooth. It shrinks the error of the observed channel by 1 + gain.
    """

    @property
    def observed_channel(self) -> str:
        """Name of the channel that is fed back."""

    def with_measured(self, run: int, measured: Array) -> HasObserver:
        """The same model with other measurements (n,) of the observed channel in one run."""


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

    A user knows a stretch of hole by its ends and what is in it. A search works better with the total amount, the
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


@dataclass(frozen=True)
class FreeForm:
    """A flexible disturbance at one site that follows no law: a curve with several coefficients.

    Attributes:
        site: Where it acts.
        description: What it would be, such as "friction over depth".
        free_form_of: Names of the effects of which it is the free form.
        x: (m,) position of each coefficient, in ``x_unit``.
        x_unit: Unit of ``x``.
        parameter_sets: m parameter sets, each a small step of one coefficient from the values that were asked for.
        steps: (m,) those steps.
        parameters: The coefficients as parameters, where they may go far: then they are fitted, not solved for once.
        period: Period of ``x`` where the curve closes on itself, else None.
        y_unit: Unit of the curve.
        basis: (m, m) value of the curve at each x for one unit of each coefficient; empty where the coefficients are
            the curve.
        lower_bound: Smallest possible value of the curve (friction below it would push).
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
    """A model with free-form alternatives at its sites."""

    def free_forms(self, values: Values) -> Sequence[FreeForm]:
        """Free-form alternatives to every effect, around these values."""

    def sensor_site(self, channel: str) -> str:
        """Site of an error in the reading of a channel alone."""


@dataclass(frozen=True)
class Manoeuvre:
    """A run that could be made next.

    Attributes:
        description: What to do, in words.
        settings: What to do, in numbers.
        model: The model that simulates it. Its only run carries the channels' times and declared noise; measured values
            are not used.
    """

    description: str
    settings: Mapping[str, float]
    model: Model = field(repr=False)


class Programmes(Protocol):
    """Test programmes of one length: what the real thing may be asked to do."""

    @property
    def variables(self) -> tuple[Parameter, ...]:
        """The numbers of a programme; every point within their bounds is one."""

    @property
    def starts(self) -> Sequence[Values]:
        """Points from which a search starts."""

    @property
    def fixed(self) -> Mapping[str, Manoeuvre]:
        """Runs to compare with, by name: routine operation first."""

    def programme(self, values: Values) -> Manoeuvre:
        """The run with these numbers."""

    def limit_use(self, manoeuvre: Manoeuvre, sets: Sequence[Values]) -> Array:
        """(K,) the largest share of any limit that a run uses, for K parameter sets; above 1 it must not be made."""


@runtime_checkable
class HasProgrammes(Protocol):
    """A model that knows which runs could be made next."""

    @property
    def programme_duration(self) -> float:
        """Usual length of a test, s."""

    def programmes(self, duration: float) -> Programmes:
        """What may be done within so many seconds."""
