"""How well a calibrated rig predicts parts of its own log, each from a state of the string that is not known.

A later log is compared with the baseline just so. What a fit leaves of the log that it was fitted to says too little:
weight that hangs where a part begins, mud that warms up and a bit that wears in differ from part to part of a rig in
which nothing has changed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from slider_drilling.diagnosis.build_model import build_model
from slider_drilling.diagnosis.changed_string import ChangedString
from slider_drilling.diagnosis.start_state import fit_start_state
from slider_drilling.diagnosis.undisturbed import calm_share, from_calm_start, without_operations
from slider_drilling.diagnosis.usual_error import problem_in_units, usual_gaps
from slider_drilling.gap.model import Values
from slider_drilling.gap.problem.noise import NoiseFloor, raise_floor
from slider_drilling.log import RigLog
from slider_drilling.log.time_window import cut_time_window
from slider_drilling.rig import Rig

# s, of a part; a log is cut into parts of about this length, two at least, or not at all where they would be shorter.
_PART_S, _SHORTEST_S = 200.0, 100.0
_MIN_CALM = 0.7  # of a part that is compared


def prediction_noise(
    logs: Sequence[RigLog], rig: Rig, noise: Mapping[str, NoiseFloor], values: Values
) -> dict[str, NoiseFloor]:
    """By channel, the larger of its noise and the usual error with which calibrated numbers predict its parts.

    Args:
        logs: Checked logs of the baseline, without the operation that they begin in.
        rig: The rig file.
        noise: What the fit to all of them left, by channel.
        values: Of that fit.
    """
    shared = {name: value for name, value in values.items() if "@" not in name}
    errors: dict[str, list[float]] = {name: [] for name in noise}
    for part in (part for log in logs for part in _parts(log, rig)):
        string = without_operations(build_model([part], rig).model.with_channels(tuple(noise)))
        model = ChangedString(string, shared, string.nuisance, ())
        problem = problem_in_units(model, noise)
        for name, error in usual_gaps(problem, fit_start_state(problem).residual).items():
            errors[name].append(error)
    usual = {name: float(np.sqrt(np.mean(np.square(own)))) for name, own in errors.items() if own}
    return {name: raise_floor(floor, usual.get(name, 1.0), "baseline") for name, floor in noise.items()}


def _parts(log: RigLog, rig: Rig) -> list[RigLog]:
    """Parts of equal length of a log, but for those that an operation takes a good part of."""
    count = max(round(log.end / _PART_S), 2)
    length = log.end / count
    if length < _SHORTEST_S:
        return []
    parts = [cut_time_window(log, index * length, (index + 1) * length) for index in range(count)]
    return [from_calm_start(part, rig) for part in parts if calm_share(part, rig) >= _MIN_CALM]
