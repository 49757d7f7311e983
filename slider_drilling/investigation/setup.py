"""What an investigation is made on. Its folder keeps it beside the logs, so that no other rig takes them as its own."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import delete_old, make_folder, read_text, write_atomically
from slider_drilling.investigation.loop import FIRST_PROGRAMME, log_path
from slider_drilling.rig import Rig, dump_rig, parse_rig

FILE = "investigation_setup.json"
SCHEMA = "slider_drilling/investigation_setup/1"
SEALED, ROS, FOLDER = "sealed", "ros", "FOLDER"


@dataclass(frozen=True)
class InvestigationSetup:
    """What the runs of an investigation are made on.

    Attributes:
        source: `SEALED`, `ROS` or `FOLDER`.
        rig: The rig file.
        seed: Of sealed and simulated rigs, plans and diagnoses.
        effects: As the options give them, of the sealed or the simulated rig.
        size: Of the effects of a sealed rig, in noise floors; None for another source.
        namespace: Of the rig that is driven; None where none is.
    """

    source: str
    rig: Rig
    seed: int
    effects: tuple[str, ...] = ()
    size: float | None = None
    namespace: str | None = None


def check_setup(folder: Path, setup: InvestigationSetup) -> None:
    """Check that the logs in a folder are of an investigation with this setup.

    Raises:
        InputError: They are of another, or nobody knows of which.
    """
    if not log_path(folder, 1).is_file():
        return
    kept = _read(folder)
    if kept is None and setup.source != FOLDER:
        raise InputError(f"{folder}: holds {log_path(folder, 1).name}, but no {FILE} that says on what it was "
                         "recorded; give another folder (-o)")  # fmt: skip
    differs = [] if kept is None else _differences(kept, setup)
    if differs:
        raise InputError(f"{folder}: holds an investigation with another setup: {'; '.join(differs)}; give its setup "
                         "to go on with it, or another folder")  # fmt: skip


def keep_setup(folder: Path, setup: InvestigationSetup) -> None:
    """Write the setup into the folder, in place of one without a log. Raises InputError as `check_setup` does."""
    check_setup(folder, setup)
    make_folder(folder)
    kept = _read(folder)
    if kept is not None and kept.rig != setup.rig:
        delete_old(folder / FIRST_PROGRAMME)  # it was made for another rig
    tree = {"schema": SCHEMA, **asdict(setup), "rig": dump_rig(setup.rig)}
    write_atomically(folder / FILE, f"{json.dumps(tree, indent=1)}\n".encode())


def _read(folder: Path) -> InvestigationSetup | None:
    path = folder / FILE
    if not path.is_file():
        return None
    try:
        tree = json.loads(read_text(path, "setup of an investigation"))
        if tree.pop("schema") != SCHEMA:
            raise ValueError
        rig, effects = parse_rig(tree.pop("rig"), str(path)), tuple(tree.pop("effects"))
        return InvestigationSetup(rig=rig, effects=effects, **tree)
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(f"{path}: damaged, or of another version; give another folder") from None


def _differences(kept: InvestigationSetup, given: InvestigationSetup) -> list[str]:
    """What differs, option by option: what was kept and what is given."""
    if kept.source != given.source:
        return [f"--on {kept.source}, not {given.source}"]
    differs = ["another rig file (--rig)"] if kept.rig != given.rig else []
    option = {SEALED: "--sealed-effect", ROS: "--effect"}.get(kept.source, "")
    pairs: list[tuple[str, Any, Any]] = [
        (option, ", ".join(kept.effects) or "none", ", ".join(given.effects) or "none"),
        ("--size", kept.size, given.size), ("--seed", kept.seed, given.seed),
        ("--drive-rig in", kept.namespace or "no namespace", given.namespace or "no namespace"),
    ]  # fmt: skip
    return differs + [f"{name} {before}, not {now}" for name, before, now in pairs if before != now]
