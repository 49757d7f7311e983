"""Static torque and drag of a 4 km horizontal well, compared with welleng and torque_drag from PyPI.

All three get the same stations every 20 m, one pipe and one friction coefficient. welleng expects weight in N/m;
torque_drag expects inches, and ignores friction that is not a list.
"""

from __future__ import annotations

import copy
import dataclasses
import importlib.util
import math
from dataclasses import dataclass

import numpy as np

from slider_drilling.benchmarks.timing import wall_seconds
from slider_drilling.rig import Rig
from slider_drilling.rig.example import example_rig
from slider_drilling.wellbore.mesh import build_mesh
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.well_path import WellPath

FRICTION = 0.25
STATION = 20.0  # m
CASES = ("raised", "lowered", "rotated")


@dataclass(frozen=True)
class Loads:
    """Hook loads in N (raised, lowered, rotated off bottom), torque in N m (rotated), and run time in s."""

    name: str
    hook_loads: tuple[float, float, float]
    torque: float
    seconds: float


def compare() -> list[Loads]:
    """Loads of this package, then of every peer that is installed."""
    rig = one_pipe(example_rig())
    rows = [ours(rig)]
    if importlib.util.find_spec("welleng") is not None:
        rows += [welleng(rig, turned=False), welleng(rig, turned=True)]
    if importlib.util.find_spec("torque_drag") is not None:
        rows.append(torque_drag(rig))
    return rows


def one_pipe(rig: Rig) -> Rig:
    """The rig with a single pipe size and without friction intervals."""
    pipe = dataclasses.replace(rig.string.sections[0], length=rig.string.length)
    return dataclasses.replace(
        rig,
        string=dataclasses.replace(rig.string, sections=(pipe,)),
        well=dataclasses.replace(rig.well, friction_intervals=()),
    )


def stations(rig: Rig) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Measured depth m, inclination and azimuth rad, every 20 m.

    In the vertical part the azimuth is that of the first build: both peers would take a jump for a bend.
    """
    depth = np.arange(0.0, rig.string.length + 0.5 * STATION, STATION)
    direction, _ = WellPath.from_survey(rig.well.survey).interpolate(depth)
    inclination = np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2])
    azimuth = np.arctan2(direction[:, 1], direction[:, 0])
    first = np.flatnonzero(inclination > 1e-6)[0]
    return depth, inclination, np.where(np.arange(len(depth)) < first, azimuth[first], azimuth)


def ours(rig: Rig) -> Loads:
    """`static_loads` with one element per station interval; the time includes the mesh."""
    elements = round(rig.string.length / STATION)

    def calculate():
        mesh = build_mesh(rig, elements)
        motions = ({"axial_speed": -1.0}, {"axial_speed": 1.0}, {"rotation_speed": 1.0})
        return [static_loads(rig, **motion, friction_coefficient=FRICTION, mesh=mesh) for motion in motions]

    loads = calculate()
    return Loads("slider_drilling", tuple(load.hook_load for load in loads), loads[2].surface_torque,
                 wall_seconds(calculate, 15))  # fmt: skip


def welleng(rig: Rig, turned: bool) -> Loads:
    """welleng.torque_drag.TorqueDrag; ``turned`` reverses the sign of its inclination changes."""
    from welleng.architecture import BHA, WellBore
    from welleng.survey import Survey, SurveyHeader
    from welleng.torque_drag import TorqueDrag

    depth, inclination, azimuth = stations(rig)
    pipe = rig.string.sections[0]
    survey = Survey(md=depth, inc=inclination, azi=azimuth, deg=False, header=SurveyHeader(deg=False))
    hole = WellBore("hole", 0.0, rig.string.length)
    hole.add_section(id=rig.well.hole_diameter, coeff_friction_sliding=FRICTION, length=rig.string.length)
    string = BHA("string", 0.0, rig.string.length)
    string.add_section(od=pipe.outer_diameter, id=pipe.inner_diameter, density=rig.string.density / 1000.0,
                       unit_weight=9.81 * rig.string.density * _area(rig), length=rig.string.length)  # fmt: skip

    class Turned(TorqueDrag):
        def get_inc_delta(self):
            super().get_inc_delta()
            self.inc_delta = -self.inc_delta

    kind = Turned if turned else TorqueDrag

    def calculate():
        return kind(survey, hole, string, rig.mud.density / 1000.0)

    loads = calculate()
    hook = tuple(float(loads.tension[case][0]) for case in ("pickup", "slackoff", "rotating"))
    name = "welleng, its sign of a build turned" if turned else "welleng"
    return Loads(name, hook, float(loads.torque["rotating"][0]), wall_seconds(calculate, 15))


def torque_drag(rig: Rig) -> Loads:
    """torque_drag.calc."""
    from torque_drag import calc

    depth, inclination, azimuth = (np.asarray(values) for values in stations(rig))
    pipe = rig.string.sections[0]
    degrees, turned = np.degrees(inclination), np.degrees(azimuth)
    trajectory = [
        {"md": depth[k], "inc": degrees[k], "azi": turned[k],
         "delta": {"md": depth[k] - depth[max(k - 1, 0)], "inc": degrees[k] - degrees[max(k - 1, 0)],
                   "azi": turned[k] - turned[max(k - 1, 0)]}}
        for k in range(len(depth))
    ]  # fmt: skip
    inches = {"od": 39.37 * pipe.outer_diameter, "id": 39.37 * pipe.inner_diameter, "shoe": rig.string.length}
    dimensions = {"pipe": inches, "odAnn": 39.37 * rig.well.hole_diameter}
    densities = {"rhof": rig.mud.density / 1000.0, "rhod": rig.string.density / 1000.0}

    def calculate(points):
        return calc(points, dimensions, densities, "all", [FRICTION] * len(points), torque_calc=True)

    loads = calculate(copy.deepcopy(trajectory))
    hook = tuple(1000.0 * loads.force[case][0] for case in ("hoisting", "lowering", "static"))
    return Loads("torque_drag", hook, 1000.0 * loads.torque["static"][0],
                 wall_seconds(lambda: calculate(trajectory), 15))  # fmt: skip


def _area(rig: Rig) -> float:
    pipe = rig.string.sections[0]
    return math.pi / 4.0 * (pipe.outer_diameter**2 - pipe.inner_diameter**2)


def markdown(rows: list[Loads]) -> str:
    """A table with each peer's difference from our loads."""
    lines = ["| | raised | lowered | rotated | surface torque | time |", "|---|---|---|---|---|---|"]
    for row in rows:
        cells = []
        for mine, theirs in zip(rows[0].hook_loads, row.hook_loads, strict=True):
            off = "" if row is rows[0] else f" ({100.0 * (theirs / mine - 1.0):+.2f} %)"
            cells.append(f"{theirs / 1000.0:.1f} kN{off}")
        off = "" if row is rows[0] else f" ({100.0 * (row.torque / rows[0].torque - 1.0):+.2f} %)"
        cells.append(f"{row.torque / 1000.0:.2f} kN m{off}")
        lines.append(f"| {row.name} | {' | '.join(cells)} | {1e3 * row.seconds:.2f} ms |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(markdown(compare()))
