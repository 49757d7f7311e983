"""Whether a log can carry a diagnosis: stuck or saturated channels, too little motion, a rig file it contradicts."""

from __future__ import annotations

import numpy as np

from slider_drilling.gap.model import Array, Channel, Run
from slider_drilling.log import RigLog
from slider_drilling.rig import Rig

# A channel is stuck when this share of its samples repeats the one before.
_STUCK = 0.5
_SATURATED = 0.02
_LEAST_SAMPLES = 12
_LEAST_TURN = 0.5  # rad
_ON = 0.3  # of the reference flow


def unusable(channel: Channel) -> str | None:
    """Why a channel cannot be used, None when it can."""
    values = channel.measured
    if values.size < _LEAST_SAMPLES:
        return f"only {values.size} samples"
    if np.ptp(values) == 0.0:
        return "stuck: it never changes"
    if channel.period is not None or channel.resolution > 0.0:
        return None
    longest = longest_repeat(values)
    if longest > _STUCK * values.size:
        return f"stuck: the same value for {100.0 * longest / values.size:.0f} % of the log"
    # A rig that has not moved yet shows one value too: only what lies between the first and the last change counts.
    changed = np.flatnonzero(np.diff(values) != 0.0)
    values = values[changed[0] + 1 : changed[-1] + 1]
    if values.size < _LEAST_SAMPLES:
        return f"only {values.size} samples that change"
    for edge, name in ((values.max(), "upper"), (values.min(), "lower")):
        at_edge = float(np.mean(values == edge))
        if at_edge > _SATURATED and longest_repeat(np.where(values == edge, 1.0, np.arange(values.size) + 2.0)) > 5:
            return f"saturated: {100.0 * at_edge:.0f} % of the samples at its {name} limit {edge:g} {channel.unit}"
    return None


def longest_repeat(values: Array) -> int:
    """Length of the longest stretch of equal samples."""
    changes = np.flatnonzero(np.diff(values) != 0.0)
    edges = np.concatenate([[-1], changes, [values.size - 1]])
    return int(np.max(np.diff(edges)))


def too_little_excitation(run: Run) -> str | None:
    """Why the run says nothing about friction, None when it does."""
    turned = float(np.ptp(run.excitation))
    if turned < _LEAST_TURN:
        return f"the top drive turned {turned:.2f} rad in all: too little to tell friction from anything else"
    if run.duration < 30.0:
        return f"the log is {run.duration:.0f} s long: shorter than any effect takes to show"
    return None


def contradictions(log: RigLog, rig: Rig) -> list[str]:
    """What in the log cannot be if the rig file is right."""
    found = []
    works, pump, pipe = log.draw_works, log.mud_pump, log.standpipe_pressure
    if works is not None and pump is not None and works.position.size > 10 and pump.velocity.size > 10:
        lowered = float(np.nanmax(works.position) - np.nanmin(works.position))
        flow = float(np.nanmedian(pump.velocity)) * rig.mud_pump.displacement
        if lowered > 0.2 and flow < _ON * rig.hydraulics.reference_flow:
            found.append(
                f"the block went down {lowered:.1f} m with the pump at {flow * 1e3:.1f} L/s: the motor would not turn"
            )
    if works is not None and np.isfinite(works.effort).any():
        measured = float(np.nanmedian(works.effort[: max(works.effort.size // 20, 1)]))
        hanging = hanging_weight(rig)
        if not 0.5 * hanging < measured < 1.7 * hanging:
            found.append(
                f"hook load starts at {measured / 1e3:.0f} kN, the rig file's string hangs at {hanging / 1e3:.0f} kN"
            )
    if pipe is not None and pump is not None and np.isfinite(pump.velocity).any():
        flow = float(np.nanmedian(pump.velocity)) * rig.mud_pump.displacement
        expected = rig.hydraulics.reference_pressure * (max(flow, 0.0) / rig.hydraulics.reference_flow) ** 1.8
        measured = float(np.nanmedian(pipe.value))
        if expected > 0.0 and not 0.4 < measured / expected < 2.5:
            found.append(
                f"standpipe pressure is {measured / 1e5:.0f} bar, by the rig file it would be {expected / 1e5:.0f} bar"
            )
    return found


def hanging_weight(rig: Rig) -> float:
    """Buoyed weight N of the string along its well."""
    from slider_drilling.wellbore.mesh import GRAVITY, build_mesh

    mesh = build_mesh(rig, 100)
    per_metre = (rig.string.density - rig.mud.density) * GRAVITY * mesh.area
    return float(np.sum(per_metre * mesh.length * mesh.cosine))
