"""Free-form alternatives: disturbances that follow no law."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from slider_drilling.gap.effect import Parameter, Values


@dataclass(frozen=True)
class FreeForm:
    """A flexible disturbance at one site that follows no law: a curve with several coefficients.

    Attributes:
        site: Where it acts.
        description: What it would be, such as "friction over time".
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
