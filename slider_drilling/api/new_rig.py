"""`new_rig`: a rig from a rig's papers."""

from __future__ import annotations

import os
import warnings

from slider_drilling.errors import InputError
from slider_drilling.files.paths import as_path
from slider_drilling.rig import Rig
from slider_drilling.rig_papers.build import build_rig
from slider_drilling.rig_papers.sheet import SHEET_KEYS, read_sheet

PathLike = str | os.PathLike[str]


def new_rig(survey: PathLike, tally: PathLike, sheet: PathLike | None = None, **values: str) -> Rig:
    """Make a rig from survey, tally and what sheets say, as ``slider-drilling rig new`` does.

    ``rig.assumed`` lists what no paper tells; what was looked up or merged is given as warnings.

    Args:
        survey: CSV or XLSX of measured depth, inclination and azimuth.
        tally: CSV or XLSX of the string's items.
        sheet: CSV or XLSX with the columns key and value.
        **values: Instead of the sheet's or beside them, as texts with their units: ``mud="9.6 ppg OBM"``,
            ``motor="0.28 rev/gal, 6600 ft-lbf @ 1100 psi"``, ``pump="4.2 gal/stk"``,
            ``top_drive="45000 ft-lbf, 180 rpm"``, ``circulating_pressure="3000 psi @ 500 gpm"``,
            ``casing_shoe="6200 ft"``; also ``bit``, ``hole_diameter``, ``make_up_torque``, ``sample_rate``, ``well``.

    Raises:
        InputError: Something is missing or cannot be used; the message names it.
    """
    known = [key.name for key in SHEET_KEYS]
    for name, text in values.items():
        if name not in known:
            raise InputError(f"new_rig: {name}: unknown; known: {', '.join(known)}")
        if not isinstance(text, str):
            raise InputError(f"new_rig: {name} = {text!r}: give a text with the unit, such as '9.6 ppg'")
    given = {} if sheet is None else read_sheet(as_path(sheet, "new_rig: sheet"))
    made = build_rig(as_path(survey, "new_rig: survey"), as_path(tally, "new_rig: tally"), {**given, **values})
    for note in made.notes:
        warnings.warn(note, stacklevel=2)
    return made.rig
