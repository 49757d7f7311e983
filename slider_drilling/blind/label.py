"""What is behind the seal of one log."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slider_drilling.blind.lack import NOTHING
from slider_drilling.errors import InputError
from slider_drilling.files.output_files import read_text

SCHEMA = "slider_drilling/blind_label/1"


@dataclass(frozen=True)
class Label:
    """kind: ``none``, ``single``, ``outside`` or ``two``; effects: what acts, in no order; sites: of each, where it
    acts and where else no log could tell it from; size: noise floors asked for; sizes: reached by each effect alone;
    interval: measured depths m between which friction differs, for a cuttings bed; hidden, recorder: see there;
    lacking: what the recorder left out."""

    log: str
    kind: str
    effects: tuple[str, ...]
    sites: tuple[tuple[str, ...], ...]
    size: float
    sizes: tuple[float, ...]
    well: str
    manoeuvre: str
    seed: int
    interval: tuple[float, float] | None
    hidden: dict[str, Any]
    recorder: dict[str, Any]
    lacking: str = NOTHING
    schema: str = SCHEMA


def read_label(path: Path) -> Label:
    """Raises InputError where it is no label."""
    try:
        tree = json.loads(read_text(path, "label"))
        if tree["schema"] != SCHEMA:
            raise InputError(f"{path}: schema = {tree['schema']!r}: this version reads {SCHEMA!r}")
        interval = tree["interval"]
        return Label(**{
            **tree, "effects": tuple(tree["effects"]), "sites": tuple(tuple(sites) for sites in tree["sites"]),
            "sizes": tuple(tree["sizes"]), "interval": None if interval is None else tuple(interval),
        })  # fmt: skip
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{path}: not the label of a sealed log") from None


def read_labels(folder: Path) -> dict[str, Label]:
    """Labels by the name of their log, without its ending. Raises InputError where there are none."""
    found = {path.stem: read_label(path) for path in sorted(folder.glob("*.json"))}
    if not found:
        raise InputError(f"{folder}: holds no labels (*.json)")
    return found
