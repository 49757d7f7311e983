"""A nuisance that went far: re-tuning was enough, and may have stood in for a law."""

from __future__ import annotations

from slider_drilling.gap.choice.state import Explained
from slider_drilling.gap.choice.tuning import FAR_OFF
from slider_drilling.gap.model import Parameter


def far_off(explained: Explained) -> list[tuple[Parameter, float, float]]:
    """What of the nuisance had to go farther than rigs are commonly off: parameter, its value, how many spreads."""
    found = []
    for parameter in explained.problem.model.nuisance:
        value = explained.fit.values.get(parameter.name, parameter.nominal)
        spreads = abs(value - parameter.nominal) / parameter.spread
        if not parameter.per_run and spreads > FAR_OFF:
            found.append((parameter, value, spreads))
    return found
