"""A rig file from a rig's papers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.contact import PAPER
from slider_drilling.errors import InputError
from slider_drilling.rig import Assumption, Rig, dump_rig, parse_rig, rig_from_tree
from slider_drilling.rig.assumptions import put_assumptions
from slider_drilling.rig_papers import defaults
from slider_drilling.rig_papers.defaults import Default
from slider_drilling.rig_papers.sheet import (
    SHEET_KEYS,
    MotorPaper,
    read_circulating_pressure,
    read_motor,
    read_mud,
    read_pump,
    read_size,
    read_top_drive,
)
from slider_drilling.rig_papers.tally import Tally, read_tally
from slider_drilling.schema.changes import apply_changes
from slider_drilling.schema.fields import to_tree
from slider_drilling.schema.quantity_text import read_quantity
from slider_drilling.wellbore.survey_table import Survey, read_survey

MAX_PROJECTION = 60.0
"""m from the last station to the bit: the survey tool sits above the motor."""
_STEEL = {"density": 7850.0, "youngs_modulus": 2.06e11, "shear_modulus": 7.92e10}
_SAME_LENGTH = 0.05  # m, by which rounded lengths of a tally may miss the survey's end


@dataclass(frozen=True)
class NewRig:
    """A rig made from papers.

    Attributes:
        rig: `rig.assumed` lists what no paper tells.
        notes: What was looked up, merged or extended.
    """

    rig: Rig
    notes: tuple[str, ...]

    def text(self) -> str:
        """The rig file."""
        remarks = "".join(f"# {' '.join(note.split())}\n" for note in self.notes)
        return f"# Made from papers by slider-drilling rig new. SI units.\n{remarks}{dump_rig(self.rig)}"


def build_rig(survey_path: Path, tally_path: Path, sheet: Mapping[str, str]) -> NewRig:
    """Make a rig from survey, tally and what other papers say.

    Args:
        survey_path: Table of stations.
        tally_path: Table of the string's items.
        sheet: Key of `SHEET_KEYS` -> text.

    Raises:
        InputError: Something is missing or cannot be used; the message names it.
    """
    missing = [key for key in SHEET_KEYS if key.required and not sheet.get(key.name)]
    if missing:
        wanted = ", ".join(f"--{key.name.replace('_', '-')} '{key.example}'" for key in missing)
        raise InputError(f"rig new: missing: {wanted}")
    torque = sheet.get("make_up_torque")
    tally = read_tally(tally_path, None if torque is None else read_quantity(torque, "N m", "make_up_torque"))
    length = math.fsum(section.length for section in tally.sections)
    survey, notes = _to_bit(read_survey(survey_path), length, survey_path)
    tree, assumed = _tree(survey, tally, sheet, length)
    source = f"rig from {survey_path.name} and {tally_path.name}"
    changed = _rounded(apply_changes(tree, {item.key: item.value for item in assumed}, source))
    spreads = [Assumption(item.key, float(f"{item.spread:.3g}"), item.why) for item in assumed]
    rig = rig_from_tree(put_assumptions(changed, spreads), source)
    rig = parse_rig(dump_rig(rig), source)  # assumptions in the order of the file
    return NewRig(rig, (*notes, *tally.notes, *_pump_notes(sheet)))


def _to_bit(survey: Survey, length: float, path: Path) -> tuple[Survey, list[str]]:
    """The survey down to the bit. Raises InputError where it ends too far above it."""
    notes = [f"{path.name}: {note}" for note in survey.notes]
    below = length - survey.length
    if below > MAX_PROJECTION:
        raise InputError(f"{path}: ends at {survey.length:.5g} m, the string of the tally reaches {length:.5g} m; "
                         "add stations, or check the tally's lengths")  # fmt: skip
    if below <= 0.0:
        return survey, notes
    _, inclination, azimuth = survey.stations[-1]
    if below <= _SAME_LENGTH:
        return Survey((*survey.stations[:-1], (length, inclination, azimuth))), notes
    notes.append(f"{path.name}: ends {below:.3g} m above the bit: its last direction was kept to there")
    return Survey((*survey.stations, (length, inclination, azimuth))), notes


def _tree(
    survey: Survey, tally: Tally, sheet: Mapping[str, str], length: float
) -> tuple[dict[str, Any], list[Default]]:
    """Keys and values of the rig file, and what was assumed in it."""
    mud = read_mud(sheet["mud"])
    bit_diameter, bit_name = _bit(tally, sheet)
    hole = read_size(sheet["hole_diameter"], "hole_diameter") if "hole_diameter" in sheet else bit_diameter
    shoe = read_quantity(sheet["casing_shoe"], "m", "casing_shoe")
    if not 0.0 <= shoe < length:
        raise InputError(f"casing_shoe = {sheet['casing_shoe']!r}: not above the bit, which is at {length:.5g} m")
    pressure, flow = read_circulating_pressure(sheet["circulating_pressure"])
    torque, speed = read_top_drive(sheet["top_drive"])
    pump = read_pump(sheet["pump"])
    motor, of_motor = _motor(read_motor(sheet["motor"]))
    ends = [shoe, length] if shoe > 0.0 else [length]
    rate = read_quantity(sheet["sample_rate"], "Hz", "sample_rate") if "sample_rate" in sheet else 0.0
    pump_displacement = pump.stroke_volume / (2.0 * math.pi)
    tree = {
        "schema": "slider_drilling/rig/1",
        "well": {
            "name": sheet.get("well", ""), "survey": [list(row) for row in survey.stations], "hole_diameter": hole,
            "friction_intervals": [{"to": end, "factor": 1.0} for end in ends],
        },
        "mud": {"density": mud.density, "sound_speed": 0.0},
        "string": {"sections": [to_tree(section) for section in tally.sections], **_STEEL, "axial_damping": 0.0,
                   "torsional_damping": 0.0, "weight_factor": 1.0},
        "contact": to_tree(PAPER),
        "bit": {"diameter": bit_diameter, "aggressiveness": 0.0, "depth_of_cut_stiffness": 0.0},
        "motor": motor,
        "mud_pump": {"displacement": pump_displacement},
        "hydraulics": {"reference_pressure": pressure, "reference_flow": flow, "reference_density": mud.density,
                       "lag": 0.0},
        "top_drive": {"max_speed": speed, "max_acceleration": 0.0, "max_torque": torque},
        "sensors": {
            "rate": rate, "mwd": {"period": 0.0, "latency": 0.0, "noise": 0.0, "resolution": 0.0},
            **{name: {"noise": 0.0, "lag": 0.0, "resolution": 0.0}
               for name in ("surface_torque", "hook_load", "standpipe_pressure")},
        },
    }  # fmt: skip
    assumed = [
        *defaults.friction_defaults(mud.base, shoe > 0.0), *defaults.bit_defaults(bit_name, bit_diameter), *of_motor
    ]  # fmt: skip
    if not pump.measured:
        assumed.append(defaults.pump_displacement(pump_displacement))
    if "sample_rate" not in sheet:
        assumed.append(defaults.sample_rate_default())
    return tree, [*assumed, *defaults.common_defaults(mud.base)]


def _bit(tally: Tally, sheet: Mapping[str, str]) -> tuple[float, str]:
    """Diameter (m) and description of the bit. Raises InputError where no paper has it, or two differ."""
    if "bit" not in sheet:
        if tally.bit_diameter is None:
            raise InputError("bit: missing: the tally has none; give --bit '8.5 in PDC'")
        return tally.bit_diameter, tally.bit_description
    diameter = read_size(sheet["bit"], "bit")
    if tally.bit_diameter is not None and abs(diameter - tally.bit_diameter) > 1e-3:
        raise InputError(f"bit = {sheet['bit']!r}: the tally has one of {tally.bit_diameter:.4g} m; correct one")
    return diameter, f"{sheet['bit']} {tally.bit_description}"


def _motor(paper: MotorPaper) -> tuple[dict[str, float], list[Default]]:
    """The motor block, and what was assumed in it."""
    assumed, ideal = [], paper.displacement / (2.0 * math.pi)
    if paper.torque is None:
        assumed += [defaults.motor_torque(ideal), defaults.motor_full_load(paper.max_pressure)]
    if paper.leak is None:
        assumed.append(defaults.motor_leak())
    if paper.stall_pressure is None:
        assumed.append(defaults.motor_stall(paper.max_pressure))
    slope = paper.torque / paper.max_pressure if paper.torque is not None else ideal
    stall = paper.stall_pressure or paper.max_pressure
    return {"torque_per_pressure": slope, "displacement": paper.displacement, "leak": paper.leak or 0.0,
            "max_pressure": paper.max_pressure, "stall_pressure": stall}, assumed  # fmt: skip


def _rounded(node: Any) -> Any:
    """A tree whose numbers have 12 digits: 457.2 instead of 457.20000000000005."""
    if isinstance(node, dict):
        return {key: _rounded(value) for key, value in node.items()}
    if isinstance(node, list):
        return [_rounded(value) for value in node]
    return float(f"{node:.12g}") if isinstance(node, float) else node


def _pump_notes(sheet: Mapping[str, str]) -> Iterable[str]:
    if not read_pump(sheet["pump"]).measured:
        yield f"pump {sheet['pump']}: volume per stroke from liner and stroke"
