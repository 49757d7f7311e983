"""The label of a sealed log: what the sealed plant and its recorder really were."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slider_drilling.blind.log_defects import NO_DEFECT
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text

SCHEMA = "slider_drilling/blind_label/2"
# Version 1 has other keys for the same things.
_VERSION_1 = "slider_drilling/blind_label/1"
_RENAMED_KEYS = {"interval": "depth_interval", "hidden": "plant", "lacking": "log_defect"}
_RENAMED_DEFECTS = {
    "nothing": NO_DEFECT, "beginning": "late_start", "drawworks": "no_drawworks", "pump": "no_pump",
    "samples": "few_samples", "renewals": "held_samples", "resolution": "coarse_values",
}  # fmt: skip


@dataclass(frozen=True)
class Label:
    """The truth about one sealed log.

    Attributes:
        log: File name of the log.
        kind: ``none``, ``single``, ``outside`` (a law that is not in the catalogue) or ``two``.
        effects: Names of the effects that act, in no order.
        sites: For each effect its site, then the sites that no log could distinguish from it.
        size: Target size, in noise floors.
        sizes: Size that each effect reaches alone, in noise floors.
        well: Name of the well, see `wells`.
        manoeuvre: Name of the manoeuvre, see `manoeuvres`.
        seed: Seed of the case.
        depth_interval: Measured depths in m between which friction differs; None without a cuttings bed.
        plant: Fields of `PlantPerturbation`.
        recorder: Fields of `RecorderModel`.
        log_defect: What the recorder left out, see `log_defects`.
        structure: Fields of `foreign.structure.Structure`; empty for a plant of the model's own equations.
        schema: Version of the label file.
    """

    log: str
    kind: str
    effects: tuple[str, ...]
    sites: tuple[tuple[str, ...], ...]
    size: float
    sizes: tuple[float, ...]
    well: str
    manoeuvre: str
    seed: int
    depth_interval: tuple[float, float] | None
    plant: dict[str, Any]
    recorder: dict[str, Any]
    log_defect: str = NO_DEFECT
    structure: dict[str, Any] = field(default_factory=dict)
    schema: str = SCHEMA


def read_label(path: Path) -> Label:
    """Returns the label in a file.

    Raises:
        InputError: The file is not a label, or of another version.
    """
    try:
        tree = json.loads(read_text(path, "label"))
        if tree["schema"] == _VERSION_1:
            tree = {_RENAMED_KEYS.get(key, key): value for key, value in tree.items()} | {"schema": SCHEMA}
            tree["log_defect"] = _RENAMED_DEFECTS[tree["log_defect"]]
        if tree["schema"] != SCHEMA:
            raise InputError(f"{path}: schema = {tree['schema']!r}: this version reads {SCHEMA!r}")
        interval = tree["depth_interval"]
        lists = {
            "effects": tuple(tree["effects"]), "sites": tuple(tuple(sites) for sites in tree["sites"]),
            "sizes": tuple(tree["sizes"]), "depth_interval": None if interval is None else tuple(interval),
        }  # fmt: skip
        return Label(**(tree | lists))
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{path}: not the label of a sealed log") from None


def read_labels(folder: Path) -> dict[str, Label]:
    """Returns the labels of a folder by the stem of their log's file name.

    Raises:
        InputError: The folder holds no labels, or one that cannot be read.
    """
    labels = {path.stem: read_label(path) for path in sorted(folder.glob("*.json"))}
    if not labels:
        raise InputError(f"{folder}: holds no labels (*.json)")
    return labels
