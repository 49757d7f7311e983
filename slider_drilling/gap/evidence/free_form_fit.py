"""A free form that was fitted: its shape and its held-out score."""

from __future__ import annotations

from dataclasses import dataclass, field

from slider_drilling.gap.evidence.score import HeldOutScore
from slider_drilling.gap.model import Array, Effect


@dataclass(frozen=True)
class FreeFormFit:
    """A free form, fitted and cross-validated.

    Attributes:
        site: Where it acts.
        description: What it would be, in words.
        free_form_of: Names of the effects of which it is the free form; None for any effect of its site.
        x: (m,) positions, in ``x_unit``.
        x_unit: Unit of ``x``.
        y: (m,) its shape, in ``y_unit``.
        y_unit: Unit of ``y``.
        score: Its held-out score.
        sensor_channel: The channel whose reading alone would be off; None if it acts in the model.
    """

    site: str
    description: str
    free_form_of: tuple[str, ...] | None
    x: Array = field(repr=False)
    x_unit: str
    y: Array = field(repr=False)
    y_unit: str
    score: HeldOutScore = field(repr=False)
    sensor_channel: str | None = None

    def covers(self, effect: Effect) -> bool:
        """Whether it is the free form of the effect."""
        return effect.site == self.site if self.free_form_of is None else effect.name in self.free_form_of
