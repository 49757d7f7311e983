"""What a coarser mesh or a shorter step buys and costs: an error figure beside each gain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.bench.clock import processor_seconds
from slider_drilling.bench.work import example_rig, rocking
from slider_drilling.drillstring import Plant, Response, simulate

DURATION = 300.0
REFERENCE = 800
MESHES = (25, 40, 50, 100, 200, 400)


@dataclass(frozen=True)
class Choice:
    """A mesh, its step s, its processor time s, and RMS differences from 800 elements: N m, -, kN, deg."""

    elements: int
    step: float
    seconds: float
    torque: float
    torque_share: float
    hook_load: float
    tool_face: float


def compare() -> list[Choice]:
    """300 s of the example rig, rocked, on every mesh."""
    rig = example_rig()
    commands = rocking(rig, DURATION)
    best = simulate(rig, commands, REFERENCE)
    rows = []
    for elements in MESHES:
        seconds = processor_seconds(lambda n=elements: simulate(rig, commands, n), 3)
        rows.append(_choice(elements, Plant(rig, elements).step, seconds, simulate(rig, commands, elements), best))
    return rows


def _choice(elements: int, step: float, seconds: float, response: Response, best: Response) -> Choice:
    torque = _rms(response.surface_torque - best.surface_torque)
    return Choice(
        elements, step, seconds, torque, torque / float(np.std(best.surface_torque)),
        _rms(response.hook_load - best.hook_load) / 1000.0, math.degrees(_rms(response.tool_face - best.tool_face)),
    )  # fmt: skip


def _rms(difference: np.ndarray) -> float:
    return float(np.sqrt(np.mean(difference**2)))


def markdown(rows: list[Choice]) -> str:
    """A table with the gain over the 200 elements that are the default."""
    default = next(row.seconds for row in rows if row.elements == 200)
    lines = ["| elements | step | times faster than 200 | surface torque | of its standard deviation | hook load "
             "| tool-face |", "|---|---|---|---|---|---|---|"]  # fmt: skip
    lines += [
        f"| {row.elements} | {1e3 * row.step:.2f} ms | {default / row.seconds:.2f} | {row.torque:.1f} N m "
        f"| {100.0 * row.torque_share:.2f} % | {row.hook_load:.2f} kN | {row.tool_face:.2f} deg |"
        for row in rows
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    print(markdown(compare()))
