"""Runs that could be made next: manoeuvres and test programmes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from slider_drilling.gap.effect import Array, Parameter, Values
from slider_drilling.gap.simulated_model import Model


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
