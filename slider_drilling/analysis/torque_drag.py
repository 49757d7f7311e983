"""Torque and drag as drillers draw it: broomstick with a log's points, loads along the string, and well path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slider_drilling.analysis.calibrate_friction import FrictionCalibration
from slider_drilling.analysis.driller_weights import DrillerWeights
from slider_drilling.analysis.friction_tables import calibration_tables
from slider_drilling.log import RigLog
from slider_drilling.log.series import Array
from slider_drilling.pages import Chart, Line, Page, Panel, Section, Table
from slider_drilling.pages.colours import AMBER, BLUE, GREEN, GREY, INK, ORDER, RED
from slider_drilling.pages.titles import well_name
from slider_drilling.rig import Rig
from slider_drilling.units import SI, Units
from slider_drilling.wellbore.broomstick import Broomstick
from slider_drilling.wellbore.static_loads import static_loads
from slider_drilling.wellbore.well_path import WellPath

WINDOW = 30.0
"""s of a log that make one point."""
_MIN_SPEED = {"lowered": 2e-4, "raised": 2e-3}  # m/s of the block; drilling is slower than tripping
_MIN_TURNING = 0.2  # rad/s
_COLOURS = {"raised": RED, "lowered": INK, "lowered and rocked": BLUE, "turned": GREEN, "still": GREY}


@dataclass(frozen=True)
class LogPoints:
    """A log in stretches of `WINDOW` s, one point each.

    Attributes:
        depth: Of the bit, m, (n,).
        motion: What the rig did, (n,).
        hook_load: Median, N, (n,).
        torque: N m, (n,): mean where the string rotated, else the largest magnitude.
    """

    depth: Array
    motion: tuple[str, ...]
    hook_load: Array
    torque: Array


def log_points(log: RigLog, rig: Rig, block_weight: float = 0.0) -> LogPoints:
    """The points of a log, without the block's weight (N); bit depth is that of its channel, else of string and block.
    """
    if log.draw_works is None:
        return LogPoints(np.empty(0), (), np.empty(0), np.empty(0))
    block, drive = log.draw_works, log.top_drive
    bit = log.truth_depth if log.truth_depth is not None else log.bit_depth
    rows = []
    for start in np.arange(block.time[0], block.time[-1], WINDOW):
        inside = (block.time >= start) & (block.time < start + WINDOW)
        if inside.sum() < 2 or np.isnan(block.effort[inside]).all():
            continue
        moved, span = np.ptp(block.time[inside]), block.position[inside][-1] - block.position[inside][0]
        if bit is not None:
            depth = float(np.interp(start + 0.5 * WINDOW, bit.time, bit.position))
        else:
            depth = rig.string.length + float(block.position[inside].mean() - block.position[0])
        speed = float(span / moved) if moved > 0.0 else 0.0
        turn, torque = (math.nan, math.nan), math.nan
        if drive is not None:
            turning = (drive.time >= start) & (drive.time < start + WINDOW)
            if turning.sum() > 1:
                rate = np.gradient(drive.position[turning], drive.time[turning])
                turn = (float(np.mean(rate)), float(np.mean(np.abs(rate))))
                torque = _torque(drive.effort[turning], turn)
        rows.append((depth, _motion(speed, turn), float(np.nanmedian(block.effort[inside])) - block_weight, torque))
    depths, motions, loads, torques = zip(*rows, strict=True) if rows else ((), (), (), ())
    return LogPoints(np.array(depths), tuple(motions), np.array(loads), np.array(torques))


def _turned(turn: tuple[float, float]) -> bool:
    return turn[1] > _MIN_TURNING and abs(turn[0]) > 0.9 * turn[1]


def _torque(effort: Array, turn: tuple[float, float]) -> float:
    there = effort[~np.isnan(effort)]
    if not there.size:
        return math.nan
    return float(there.mean()) if _turned(turn) else float(np.abs(there).max())


def _motion(speed: float, turn: tuple[float, float]) -> str:
    if _turned(turn):
        return "turned"
    if speed <= -_MIN_SPEED["raised"]:
        return "raised"
    if speed >= _MIN_SPEED["lowered"]:
        return "lowered and rocked" if turn[1] > _MIN_TURNING else "lowered"
    return "still"


def torque_drag_page(
    rig: Rig, sticks: Sequence[Broomstick], points: LogPoints | None = None, notes: Sequence[str] = (),
    units: Units = SI, calibration: FrictionCalibration | None = None,
) -> Page:  # fmt: skip
    """The page: a broomstick for each friction, loads along the string with the rig's friction, and the well path.

    Args:
        rig: The rig.
        sticks: One for each friction, and that of the calibration.
        points: Of a log.
        notes: Remarks at the foot.
        units: Of the page.
        calibration: From the driller's weights.
    """
    weights = None if calibration is None else calibration.weights
    sections = (
        Section("Broomstick", (
            "Hook load and torque off bottom as the string goes in, for each friction coefficient (times the well's "
            "friction intervals). Points of a log on bottom lie to the left by their weight on bit; rocking gives back "
            "what friction along the hole takes.",
            hook_load_chart(sticks, points, weights), torque_chart(sticks, points, weights),
        )),
        *(() if calibration is None else
          (Section("Friction from the driller's weights", calibration_tables(calibration, units)),)),
        Section("At total depth", (_table(sticks),)),
        Section("Along the string, bit at total depth", along_charts(rig)),
        Section("Well path", path_charts(rig)),
    )  # fmt: skip
    facts = (("string", units.format(rig.string.length, "m", 4)),
             ("mud", units.format(rig.mud.density, "kg/m3", 4)))  # fmt: skip
    remarks = (*notes, *(() if calibration is None else calibration.notes))
    return Page("Torque and drag", well_name(rig), sections, facts, notes=remarks)


def _named(stick: Broomstick) -> str:
    if stick.calibrated:
        return "calibrated"
    return "the rig's contact" if stick.friction is None else f"friction {stick.friction:g}"


def hook_load_chart(
    sticks: Sequence[Broomstick], points: LogPoints | None = None, weights: Sequence[DrillerWeights] | None = None
) -> Chart:
    """Hook load over depth: slacking off to the left, picking up to the right, rotating between them."""
    lines = []
    for place, stick in enumerate(sticks):
        colour = INK if stick.friction is None else ORDER[place % len(ORDER)]
        lines += [Line(_named(stick), stick.slack_off / 1e3, stick.depth, colour=colour),
                  Line(_named(stick), stick.pick_up / 1e3, stick.depth, colour=colour)]  # fmt: skip
    if sticks:
        lines.append(Line("turning", sticks[0].rotating / 1e3, sticks[0].depth, "dashed", GREY))
    lines += _dots(points, None if points is None else points.hook_load / 1e3)
    for motion, colour in (("slack_off", INK), ("rotating", GREEN), ("pick_up", RED)):
        lines += _readings(weights, motion, colour)
    return Chart("Hook load", "hook load, kN", (Panel("bit depth, m", tuple(lines), inverted=True, height=1.5),))


def torque_chart(
    sticks: Sequence[Broomstick], points: LogPoints | None = None, weights: Sequence[DrillerWeights] | None = None
) -> Chart:
    """Torque over depth that turns the whole string; for a log that rocks, the largest of each stretch."""
    lines = [Line(_named(stick), stick.torque / 1e3, stick.depth,
                  colour=INK if stick.friction is None else ORDER[place % len(ORDER)])
             for place, stick in enumerate(sticks)]  # fmt: skip
    lines += _dots(points, None if points is None else points.torque / 1e3)
    lines += _readings(weights, "torque", GREEN)
    panel = Panel("bit depth, m", tuple(lines), inverted=True, height=1.5)
    return Chart("Surface torque", "surface torque, kN m", (panel,))


def _readings(weights: Sequence[DrillerWeights] | None, name: str, colour: str) -> list[Line]:
    rows = [(row.depth, getattr(row, name)) for row in weights or () if getattr(row, name) is not None]
    if not rows:
        return []
    depth, value = np.array(rows).T
    return [Line(f"driller: {name.replace('_', ' ')}", value / 1e3, depth, "dots", colour)]


def _dots(points: LogPoints | None, values: Array | None) -> list[Line]:
    if points is None or values is None:
        return []
    dots = []
    for motion, colour in _COLOURS.items():
        chosen = np.array([done == motion for done in points.motion], dtype=bool) & np.isfinite(values)
        if chosen.any():
            dots.append(Line(f"log: {motion}", values[chosen], points.depth[chosen], "dots", colour))
    return dots


def _table(sticks: Sequence[Broomstick]) -> Table:
    header = ("friction", "slacking off, kN", "turning, kN", "picking up, kN", "torque to turn, kN m")
    rows = tuple((_named(stick), stick.slack_off[-1] / 1e3, stick.rotating[-1] / 1e3, stick.pick_up[-1] / 1e3,
                  stick.torque[-1] / 1e3) for stick in sticks)  # fmt: skip
    return Table(header, rows, digits=4)


def along_charts(rig: Rig, elements: int = 200) -> tuple[Chart, ...]:
    """Tension, torque and side force along the string with the rig's own friction, bit at total depth."""
    down, up = (static_loads(rig, speed, elements=elements) for speed in (1.0, -1.0))
    turned = static_loads(rig, 0.0, 1.0, elements=elements)
    depth = turned.measured_depth
    middle = 0.5 * (depth[1:] + depth[:-1])
    tension = tuple(
        Line(name, loads.tension / 1e3, depth, colour=colour)
        for name, loads, colour in (("slacking off", down, BLUE), ("turning", turned, GREEN), ("picking up", up, RED))
    )
    torque = (Line("turning", turned.torque / 1e3, depth, colour=GREEN),)
    side = (Line("turning", turned.side_force, middle, colour=GREEN),)
    return tuple(
        Chart(title, label, (Panel("measured depth, m", lines, inverted=True),))
        for title, label, lines in (("Tension", "tension, kN", tension), ("Torque", "torque, kN m", torque),
                                    ("Side force", "side force, N/m", side))
    )  # fmt: skip


def path_charts(rig: Rig) -> tuple[Chart, ...]:
    """The well path from the side and from above, and its angles."""
    rows = np.asarray(rig.well.survey)
    depth = np.linspace(0.0, rows[-1, 0], 400)
    tangents, positions = WellPath.from_survey(rig.well.survey).interpolate(depth)
    away = np.cumsum(np.hypot(*np.diff(positions[:, :2], axis=0, prepend=positions[:1, :2]).T))
    inclination = np.degrees(np.arccos(np.clip(tangents[:, 2], -1.0, 1.0)))
    turned = np.degrees(np.arccos(np.clip(np.sum(tangents[1:] * tangents[:-1], axis=1), -1.0, 1.0)))
    dog_leg = np.append(turned / np.diff(depth) * 30.0, np.nan)
    side = Panel("true vertical depth, m", (Line("well path", away, positions[:, 2], colour=BLUE),), inverted=True)
    above = Panel("north, m", (Line("well path", positions[:, 1], positions[:, 0], colour=BLUE),))
    bends = Panel("dog leg, deg/30 m", (Line("dog leg", depth, dog_leg, colour=AMBER),))
    return (
        Chart("From the side", "horizontal distance along the well path, m", (side,)),
        Chart("From above", "east, m", (above,), x_limits=_east_limits(positions)),
        Chart("Angles", "measured depth, m", (
            Panel("inclination, deg", (Line("inclination", depth, inclination, colour=BLUE),)), bends)),
    )  # fmt: skip


def _east_limits(positions: Array) -> tuple[float, float]:
    """East limits of a map of the path (n, 3): a straight path shows as straight, not as its rounding errors."""
    north, east = positions[:, 0], positions[:, 1]
    room = max(0.55 * float(np.ptp(east)), 0.1 * float(np.ptp(north)), 10.0)
    middle = 0.5 * float(east.min() + east.max())
    return middle - room, middle + room
