"""`load_rig`: a rig from a file, a text or a tree."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from slider_drilling import rig as rig_file
from slider_drilling.files.installed_files import installed_file
from slider_drilling.rig import Rig, parse_rig, rig_from_tree

WELLS = {"example": "config/rig.example.yaml", "short": "config/rig.short.yaml", "long": "config/rig.long.yaml"}


def load_rig(source: str | os.PathLike[str] | Mapping[str, Any] | None = None) -> Rig:
    """Load and check a rig.

    Args:
        source: Path of a rig file, its text (more than one line), or its keys and values. ``"example"`` (also the
            default), ``"short"`` and ``"long"`` are the wells of 4.0, 2.6 and 5.6 km of the package.

    Raises:
        InputError: Something cannot be used; the message names file, key and value.
    """
    if source is None:
        source = "example"
    if isinstance(source, Mapping):
        return rig_from_tree(dict(source), "rig")
    if isinstance(source, str) and source in WELLS:
        source = installed_file(WELLS[source])
    if isinstance(source, str) and "\n" in source:
        return parse_rig(source, "rig")
    return rig_file.load_rig(source)
