"""A diagnosis on disk: diagnosis.json, rig.tuned.yaml, report.html, and the programme that it asks for next."""

from __future__ import annotations

import json
from pathlib import Path

from slider_drilling.diagnosis.asked_run import asked_programme
from slider_drilling.diagnosis.diagnose import tuned_rig
from slider_drilling.diagnosis.page import report_page
from slider_drilling.diagnosis.result import Diagnosis
from slider_drilling.diagnosis.to_json import to_json
from slider_drilling.files.output_files import delete_old, make_folder, write_atomically
from slider_drilling.pages import page_html
from slider_drilling.programmes import dump_programme
from slider_drilling.rig import dump_rig
from slider_drilling.units import SI, Units

FILES = ("diagnosis.json", "rig.tuned.yaml", "report.html")
NEXT_PROGRAMME = "next_programme.yaml"  # only where a run is asked for


def write_diagnosis(diagnosis: Diagnosis, folder: Path, units: Units = SI) -> list[Path]:
    """Write the files, each as a whole or not at all; delete the old programme where no run is asked for.

    Args:
        diagnosis: The result.
        folder: Made if it does not exist.
        units: Of the page; diagnosis.json is in SI units.

    Returns:
        Paths of the files.

    Raises:
        InputError: The folder cannot be written.
    """
    make_folder(folder)
    contents = (
        json.dumps(to_json(diagnosis), indent=1, allow_nan=False) + "\n",
        dump_rig(tuned_rig(diagnosis)),
        page_html(report_page(diagnosis), units),
    )
    for name, text in zip(FILES, contents, strict=True):
        write_atomically(folder / name, text.encode("utf-8"))
    written = [folder / name for name in FILES]
    if diagnosis.next_manoeuvre is None:
        delete_old(folder / NEXT_PROGRAMME)
        return written
    programme = dump_programme(asked_programme(diagnosis.next_manoeuvre))
    write_atomically(folder / NEXT_PROGRAMME, programme.encode("utf-8"))
    return [*written, folder / NEXT_PROGRAMME]
