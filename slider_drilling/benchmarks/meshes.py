"""Speed and error of coarser meshes and of single precision."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from slider_drilling.benchmarks.timing import processor_seconds
from slider_drilling.benchmarks.workload import rocking_commands
from slider_drilling.drillstring import Plant, Response, simulate, simulate_batch
from slider_drilling.rig import Rig
from slider_drilling.rig.example import example_rig
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.well_path import WellPath

Survey = tuple[tuple[float, float, float], ...]

# Build, turn and drop between few stations.
TURN = ((0.0, 0.0, 10.0), (600.0, 0.0, 10.0), (1400.0, 60.0, 10.0), (2200.0, 60.0, 95.0), (2900.0, 22.0, 95.0),
        (4000.0, 20.0, 95.0))  # fmt: skip

DURATION = 300.0
REFERENCE = 800
MESHES = (25, 40, 50, 100, 200, 400)


@dataclass(frozen=True)
class MeshError:
    """RMS differences of one mesh from the reference of 800 elements.

    Attributes:
        elements: Elements of the string.
        step: Time step, s.
        seconds: Processor time, s.
        torque: Surface torque, N m.
        torque_share: The same over its standard deviation.
        hook_load: kN.
        tool_face: deg.
    """

    elements: int
    step: float
    seconds: float
    torque: float
    torque_share: float
    hook_load: float
    tool_face: float


def compare() -> list[MeshError]:
    """Simulate 300 s of rocking the example rig on every mesh."""
    rig = example_rig()
    commands = rocking_commands(rig, DURATION)
    best = simulate(rig, commands, REFERENCE)
    rows = []
    for elements in MESHES:
        seconds = processor_seconds(lambda n=elements: simulate(rig, commands, n), 3)
        rows.append(_choice(elements, Plant(rig, elements).step, seconds, simulate(rig, commands, elements), best))
    return rows


def _choice(elements: int, step: float, seconds: float, response: Response, best: Response) -> MeshError:
    torque = _rms(response.surface_torque - best.surface_torque)
    return MeshError(
        elements, step, seconds, torque, torque / float(np.std(best.surface_torque)),
        _rms(response.hook_load - best.hook_load) / 1000.0, math.degrees(_rms(response.tool_face - best.tool_face)),
    )  # fmt: skip


def _rms(difference: np.ndarray) -> float:
    return float(np.sqrt(np.mean(difference**2)))


def markdown(rows: list[MeshError]) -> str:
    """A table with the speed-up over the default of 200 elements."""
    default = next(row.seconds for row in rows if row.elements == 200)
    lines = ["| elements | step | times faster than 200 | surface torque | of its standard deviation | hook load "
             "| toolface |", "|---|---|---|---|---|---|---|"]  # fmt: skip
    lines += [
        f"| {row.elements} | {1e3 * row.step:.2f} ms | {default / row.seconds:.2f} | {row.torque:.1f} N m "
        f"| {100.0 * row.torque_share:.2f} % | {row.hook_load:.2f} kN | {row.tool_face:.2f} deg |"
        for row in rows
    ]
    return "\n".join(lines)


def single_precision(counts: tuple[int, ...] = (32, 100, 200)) -> str:
    """A table of RMS differences between single and double precision, 300 s of rocking the example rig."""
    rig = example_rig()
    commands = rocking_commands(rig, DURATION)
    lines = ["| elements | surface torque | hook load | standpipe pressure | toolface |", "|---|---|---|---|---|"]
    for elements in counts:
        (double,), (single,) = (
            simulate_batch([rig], commands, elements, single_precision=which) for which in (False, True)
        )
        off = {
            name: _rms(getattr(single, name) - getattr(double, name))
            for name in ("surface_torque", "hook_load", "standpipe_pressure", "tool_face")
        }
        lines.append(
            f"| {elements} | {off['surface_torque']:.2g} N m | {off['hook_load']:.2g} N "
            f"| {off['standpipe_pressure']:.2g} Pa | {math.degrees(off['tool_face']):.1g} deg |"
        )
    return "\n".join(lines)


def crooked(counts: tuple[int, ...] = (32, 100), fine: int = 2000) -> str:
    """A table of the errors of static loads on few elements in crooked holes."""
    lines = ["| hole | elements | torque, turning | hook load, lowered | hook load, raised |", "|---|---|---|---|---|"]
    for words, rig in _holes().items():
        best = static_loads_of(rig, fine)
        for count in counts:
            off = 100.0 * (static_loads_of(rig, count) / best - 1.0)
            lines.append(f"| {words} | {count} | " + " | ".join(f"{share:+.2f} %" for share in off) + " |")
    return "\n".join(lines)


def _holes() -> dict[str, Rig]:
    rig = example_rig()
    surveys = {
        "the example's": rig.well.survey,
        "the example's, a station every 30 m, off by half a degree": stationed(rig.well.survey),
        "build, turn and drop": TURN,
        "build, turn and drop, a station every 30 m, off by half a degree": stationed(TURN),
    }
    return {words: replace(rig, well=replace(rig.well, survey=survey)) for words, survey in surveys.items()}


def stationed(survey: Survey) -> Survey:
    """The same well path with a station every 30 m, each with a random error of half a degree."""
    course, off = WellPath.from_survey(survey), np.random.default_rng(0)
    depth = np.append(np.arange(0.0, course.depth[-1], 30.0), course.depth[-1])
    north, east, down = course.interpolate(depth)[0].T
    inclination, azimuth = np.degrees(np.arccos(np.clip(down, -1.0, 1.0))), np.degrees(np.arctan2(east, north))
    inclination += 0.5 * off.normal(size=depth.size) * (inclination > 3.0)
    azimuth += 0.5 * off.normal(size=depth.size)
    return tuple(zip(depth.tolist(), inclination.tolist(), azimuth.tolist(), strict=True))


def static_loads_of(rig: Rig, elements: int) -> np.ndarray:
    """(3,): torque of a rotating string, N m; hook loads while lowering on bottom and while raising, N."""
    turning = static_loads(rig, rotation_speed=1.0, elements=elements)
    lowered = static_loads(rig, axial_speed=1.0, weight_on_bit=5e4, elements=elements)
    raised = static_loads(rig, axial_speed=-1.0, elements=elements)
    return np.array([turning.surface_torque, lowered.hook_load, raised.hook_load])


if __name__ == "__main__":
    print(markdown(compare()))
    print(crooked())
