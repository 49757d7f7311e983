"""Calibration of friction from given weights, or from those that a log holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from slider_drilling.analysis.calibrate_friction import FrictionCalibration, calibrate_friction
from slider_drilling.analysis.driller_weights import DrillerWeights
from slider_drilling.analysis.weights_in_log import find_weights
from slider_drilling.errors import InputError
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig
from slider_drilling.units import SI, Units


def calibrate_log(
    log: RigLog | None, rig: Rig | None, weights: Sequence[DrillerWeights], block_weight: float | None,
    units: Units = SI,
) -> tuple[FrictionCalibration | None, str | None]:  # fmt: skip
    """Calibrate the rig's friction.

    Args:
        log: Searched for weights if none are given.
        rig: None for no calibration.
        weights: The driller's.
        block_weight: In the hook loads, N.
        units: Of the messages.

    Returns:
        The calibration, or None and a sentence that says why there is none.

    Raises:
        InputError: Weights are given and cannot be used.
    """
    if rig is None:
        if weights:
            raise InputError("weights: friction needs a rig file; give one with --rig")
        return None, None
    if weights:
        return calibrate_friction(rig, weights, block_weight, units), None
    found = () if log is None else find_weights(log, rig)
    if not found:
        missing = "friction from the driller's weights: the log holds no pick-up, slack-off or rotation off bottom"
        return None, None if log is None else missing
    try:
        calibration = calibrate_friction(rig, found, block_weight, units)
    except InputError as error:
        return None, f"friction from the weights in the log: {error}"
    return replace(calibration, notes=(*calibration.notes, "the weights are those that the log holds")), None
