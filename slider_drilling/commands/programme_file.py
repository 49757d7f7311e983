"""The file of `run --programme`: a programme, a slide sheet, or a built-in name; checked on the rig before it runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slider_drilling.rig import Rig


@dataclass(frozen=True)
class ProgrammeFile:
    """A programme that a rig can run.

    Attributes:
        path: Of its YAML file.
        nominal_time: s.
    """

    path: Path
    nominal_time: float


def prepare_programme(name: str, rig: Rig, folder: Path) -> ProgrammeFile:
    """Read a programme and check it on a rig.

    Args:
        name: Path of a programme or of a slide sheet (CSV, XLSX), or the name of a built-in programme.
        rig: That runs it.
        folder: For the programme of a slide sheet.

    Raises:
        InputError: The file cannot be used, or not by this rig.
    """
    from slider_drilling.files.output_files import write_atomically
    from slider_drilling.programmes import dump_programme
    from slider_drilling.programmes.find_programme import find_programme
    from slider_drilling.programmes.open_loop import SETTLING, check_simulated_start
    from slider_drilling.programmes.rig_check import check_start_depth, nominal_times

    found = find_programme(name)
    check_start_depth(found.start, rig, name)
    check_simulated_start(found.programme, name)
    times = nominal_times(found.programme, rig, name)
    path = found.path
    if path is None:
        path = folder / "programme.yaml"
        write_atomically(path, dump_programme(found.programme).encode("utf-8"))
    return ProgrammeFile(path, SETTLING + sum(times))
