"""A diagnosis on disk: diagnosis.json, rig.tuned.yaml and report.html."""

from __future__ import annotations

import json
from pathlib import Path

from slider_drilling.diagnosis.diagnose import Diagnosis, tuned_rig
from slider_drilling.diagnosis.page import report_page
from slider_drilling.diagnosis.tree import as_json
from slider_drilling.errors import InputError
from slider_drilling.files import write_whole
from slider_drilling.pages import page_html
from slider_drilling.rig import dump_rig
from slider_drilling.units import SI, Units


def write_diagnosis(diagnosis: Diagnosis, folder: Path, units: Units = SI) -> list[Path]:
    """Write the files into a folder, which is made; their paths. units: of the page, diagnosis.json is SI.

    Each file is written as a whole or not at all. Raises InputError where the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot make this folder: {error.strerror}") from None
    contents = {
        "diagnosis.json": json.dumps(as_json(diagnosis), indent=1, allow_nan=False) + "\n",
        "rig.tuned.yaml": dump_rig(tuned_rig(diagnosis)),
        "report.html": page_html(report_page(diagnosis), units),
    }
    for name, text in contents.items():
        write_whole(folder / name, text.encode("utf-8"))
    return [folder / name for name in contents]
