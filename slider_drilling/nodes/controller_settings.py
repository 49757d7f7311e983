"""A controller's settings as node parameters; apart from `parameters`, which nodes without a controller load."""

from __future__ import annotations

from typing import Any

from slider_drilling.control.settings import Limits, limits_of
from slider_drilling.nodes.parameters import NodeParameter


def settings_parameters(settings: Any) -> list[NodeParameter]:
    """A controller's settings as live parameters; their present values are the defaults."""

    def declared(name: str, limits: Limits) -> NodeParameter:
        value = getattr(settings, name)
        return NodeParameter(name, value, limits.description, limits.unit, limits.low, limits.high, live=True)

    return [declared(name, limits) for name, limits in limits_of(settings).items()]
