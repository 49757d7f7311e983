"""The label of a sealed slide: what began, when, and how large it became."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text

SCHEMA = "slider_drilling/slide_label/1"


@dataclass(frozen=True)
class SlideLabel:
    """The truth about one sealed slide.

    Attributes:
        log: File name of the log.
        case: Key of `beginnings.BEGINNINGS`, or ``none``.
        name: Name of what began, ``none`` without anything.
        accepted: Names that are right.
        site: Where it acts, None without anything.
        in_catalogue: Whether a diagnosis of a change could name it.
        onset: s, None without anything.
        growth: s, in which it grew; 0 for a step.
        reached: s, when it reached 1.5 noise levels; None where it never did.
        size: Largest size, in noise levels.
        operations: (name, start s, end s) of each operation.
        duration: s.
        seed: Of the case.
        well: Name of the well.
        plant: Fields of `blind.sealed_plant.PlantPerturbation`.
        structure: Fields of `blind.foreign.structure.Structure`.
        schema: Version of the label file.
    """

    log: str
    case: str
    name: str
    accepted: tuple[str, ...]
    site: str | None
    in_catalogue: bool
    onset: float | None
    growth: float
    reached: float | None
    size: float
    operations: tuple[tuple[str, float, float], ...]
    duration: float
    seed: int
    well: str
    plant: dict[str, Any] = field(default_factory=dict)
    structure: dict[str, Any] = field(default_factory=dict)
    schema: str = SCHEMA


def read_slide_label(path: Path) -> SlideLabel:
    """The label in a file.

    Raises:
        InputError: The file is not a label of a slide, or of another version.
    """
    try:
        tree = json.loads(read_text(path, "label"))
        if tree["schema"] != SCHEMA:
            raise InputError(f"{path}: schema = {tree['schema']!r}: this version reads {SCHEMA!r}")
        operations = tuple((str(name), float(start), float(end)) for name, start, end in tree["operations"])
        return SlideLabel(**(tree | {"accepted": tuple(tree["accepted"]), "operations": operations}))
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{path}: not the label of a sealed slide") from None
