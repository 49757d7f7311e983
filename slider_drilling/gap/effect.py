"""Parameters that a fit may free, and candidate effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

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
