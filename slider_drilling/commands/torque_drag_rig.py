"""The rig that `torque-drag` draws, and what does not belong together in it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from slider_drilling.log import RigLog
    from slider_drilling.rig import Rig

_MAX_DEPTH_DIFFERENCE = 0.05  # of the string's length, between log and rig
_LOADS = (0.7, 1.3)  # of the lightest and the heaviest hook load that friction below 0.5 gives
_FRICTION = 0.5
_MOST_SHOWN = 4  # differences between two rig files
_ROUNDING = 0.1  # m by which a survey's last station and a string's length may differ: tables in whole tenths of feet


def charted_rig(
    rig_path: Path | None, log: RigLog | None, survey_path: Path | None
) -> tuple[Rig, tuple[str, ...]]:
    """The rig to draw, and notes on what was made up or does not belong together.

    Args:
        rig_path: Rig file; None for the log's own, else the example well.
        log: Whose points are drawn.
        survey_path: Survey instead of the rig's.

    Raises:
        InputError: The survey is shorter than the rig file's string, or a file cannot be used.
    """
    from slider_drilling.api.rigs import load_rig

    has_own = log is not None and (rig_path is not None or log.rig_text is not None)
    rig = log.rig() if log is not None and has_own else load_rig(rig_path)
    example = rig_path is None and not has_own
    notes = []
    if example and log is not None:
        notes.append(f"{log.source}: has no rig file: its points are drawn on the example well; give its own, --rig")
    elif example and survey_path is None:
        notes.append("no rig file: this is the example well, not yours; give yours with --rig")
    if survey_path is not None:
        rig, remarks = _with_survey(rig, survey_path, example)
        notes += remarks
    if log is not None:
        notes += [*_other_rig(log), *_strangers(log, rig)]
    return rig, tuple(notes)


def _with_survey(rig: Rig, path: Path, example: bool) -> tuple[Rig, list[str]]:
    from slider_drilling.errors import InputError
    from slider_drilling.rig import check_rig
    from slider_drilling.wellbore.broomstick import with_bit_at
    from slider_drilling.wellbore.survey_table import read_survey

    survey = read_survey(path)
    length, whose = rig.string.length, "the example well's" if example else "the rig file's"
    advice = "give a rig file for this well with --rig (slider-drilling rig new makes one)"
    if survey.length < length - _ROUNDING and not example:
        raise InputError(f"{path}: ends at {survey.length:.8g} m, but {whose} string reaches {length:.8g} m; {advice}")
    notes = [f"{path}: {note}" for note in survey.notes]
    if example:
        notes.append(f"string, mud, hole and casing are {whose}, not those of {path.name}; {advice}")
    if survey.length < length - 1e-6:
        notes.append(f"{path.name} ends at {survey.length:.8g} m: {whose} string of {length:.8g} m was cut to that")
        rig = with_bit_at(rig, survey.length)
    if survey.length > length + 1.0:
        notes.append(f"{path.name} reaches {survey.length:.5g} m, {whose} string {length:.5g} m: the chart ends there")
    well = dataclasses.replace(rig.well, survey=survey.stations, name="")
    return check_rig(dataclasses.replace(rig, well=well), str(path)), notes


def _other_rig(log: RigLog) -> list[str]:
    """A note where the log's own rig file has another well, string, mud or contact than the one given."""
    from slider_drilling.errors import InputError
    from slider_drilling.rig import parse_rig

    if log.replaced_rig_text is None:
        return []
    try:
        own = parse_rig(log.replaced_rig_text, log.source)
    except InputError:
        return []  # the given rig file is there to replace it
    found = _differences(own, log.rig())
    if not found:
        return []
    more = f", and {len(found) - _MOST_SHOWN} more" if len(found) > _MOST_SHOWN else ""
    return [f"{log.source}: its own rig file differs from {log.rig_source}, which is drawn: "
            f"{'; '.join(found[:_MOST_SHOWN])}{more}"]  # fmt: skip


def _differences(own: Rig, given: Rig) -> list[str]:
    """What differs between a log's rig and the given one in what hook load and torque depend on."""
    found = []
    if own.string.length != given.string.length:
        found.append(f"the string reaches {own.string.length:.5g} m, not {given.string.length:.5g} m")
    for part in ("well", "string", "mud", "contact"):
        one, other = getattr(own, part), getattr(given, part)
        for field in dataclasses.fields(one):
            values = getattr(one, field.name), getattr(other, field.name)
            if values[0] != values[1] and field.name != "name":
                found.append(f"{part}.{field.name}{_both(values, field)}")
    return found


def _both(values: tuple[Any, Any], field: dataclasses.Field[Any]) -> str:
    """Two numbers with their unit; empty for lists, which take too much room."""
    from slider_drilling.units import SI, displayed, sentence

    if not all(isinstance(value, (int, float)) for value in values):
        return ""
    unit = field.metadata["range"].unit if "range" in field.metadata else "-"
    own, given = (displayed(float(value), unit, 4) for value in values)
    return SI.convert_text(sentence(" is ", own, ", not ", given))


def _strangers(log: RigLog, rig: Rig) -> list[str]:
    """Notes where depth or hook load of a log cannot be those of the rig's string."""
    from slider_drilling.wellbore.static_loads import static_loads

    notes, length = [], rig.string.length
    depth = log.truth_depth if log.truth_depth is not None else log.bit_depth
    if depth is not None and depth.position.size:
        last = float(np.nanmax(depth.position))
        if abs(last - length) > _MAX_DEPTH_DIFFERENCE * length:
            notes.append(f"{log.source}: its bit is at {last:.5g} m, the rig's string reaches {length:.5g} m: another "
                         "well or another depth; give its own rig file with --rig")  # fmt: skip
    if log.draw_works is not None and np.isfinite(log.draw_works.effort).any():
        measured = float(np.nanmedian(log.draw_works.effort))
        lightest, heaviest = (
            static_loads(rig, axial, friction_coefficient=_FRICTION).hook_load for axial in (1.0, -1.0)
        )
        if not _LOADS[0] * max(lightest, 0.0) <= measured <= _LOADS[1] * heaviest:
            notes.append(
                f"{log.source}: its hook load is {measured / 1e3:.4g} kN, this string's {lightest / 1e3:.4g} to "
                f"{heaviest / 1e3:.4g} kN: another string, or the block's weight is in it"
            )
    return notes
