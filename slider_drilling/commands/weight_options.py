"""Options that give the driller's weights: pick-up, slack-off, rotating, free torque, and the block's."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from slider_drilling.commands.quantity import QuantityType
from slider_drilling.errors import InputError

Command = TypeVar("Command", bound=Callable[..., Any])
_FORCE, _TORQUE, _LENGTH = (
    QuantityType("N", "260klbf"),
    QuantityType("N m", "7000ft.lbf"),
    QuantityType("m", "14500ft"),
)
_OPTIONS = (
    click.option("--pick-up", type=_FORCE, help="Hook load while picking up, with its unit: 260klbf."),
    click.option("--slack-off", type=_FORCE, help="Hook load while slacking off without rotation."),
    click.option("--rotating", type=_FORCE, help="Hook load while rotating off bottom."),
    click.option("--free-torque", type=_TORQUE, help="Torque while rotating off bottom: 7000ft.lbf."),
    click.option("--bit-depth", type=_LENGTH, help="Measured depth of the bit at these weights. "
                 "[default: the string's length]"),
    click.option("--weights", "weights_path", type=click.Path(path_type=Path),
                 help="CSV table of such readings by depth: Bit depth [ft], Pick-up [klbf], Slack-off [klbf], "
                 "Rotating [klbf], Torque [ft lbf]."),
    click.option("--block-weight", type=_FORCE, help="Block, top drive and hoses in the hook loads, of these "
                 "readings and of the log; 0kN if tared. [default: found out, and asked for where unclear]"),
)  # fmt: skip


def weight_options(command: Command) -> Command:
    """Add the options to a command; `read_weights` makes readings of their values."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read_weights(rig_length: float | None, given: dict[str, Any]) -> tuple[Any, ...]:
    """The readings (`DrillerWeights`) of the options; empty if there are none.

    Args:
        rig_length: Of the string, m; None without a rig file.
        given: Values of `weight_options` by parameter name.

    Raises:
        InputError: A reading cannot be, or the table cannot be read.
    """
    from slider_drilling.analysis.driller_weights import DrillerWeights, check_weights, read_driller_weights
    from slider_drilling.units import FIELD

    names = {"pick_up": "pick_up", "slack_off": "slack_off", "rotating": "rotating", "free_torque": "torque"}
    typed = {field: given[name] for name, field in names.items() if given[name] is not None}
    path, depth = given["weights_path"], given["bit_depth"]
    if not typed:
        if depth is not None:
            raise InputError("--bit-depth: belongs to --pick-up, --slack-off, --rotating or --free-torque; give one")
        return () if path is None else read_driller_weights(path)
    depth = rig_length if depth is None else depth
    if depth is None:
        raise InputError("--pick-up: the weights need a rig file; give it with --rig")
    row = check_weights(DrillerWeights(depth, **typed), "weights", FIELD)
    return (row, *(() if path is None else read_driller_weights(path)))
